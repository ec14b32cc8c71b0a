//! Layouts whose boards cannot send what their taxels measure.

use super::super::*;
use super::bad_toml::check;

#[test]
fn boards_send_what_they_can() {
    check(
        include_str!("layout.toml"),
        LayoutFile::read,
        &[
            (
                "axes = 3",
                "axes = 3\ntransducer = \"capacitive\"",
                "f.toml:5: axes: expected 1: such taxels measure the normal axis alone, found 3",
            ),
            (
                "axes = 3",
                "axes = 1\ntransducer = \"cells\"",
                "f.toml:5: axes: expected 3: a cell's three modalities, found 1",
            ),
            (
                "axes = 3",
                "axes = 1\ntransducer = \"camera\"",
                "f.toml:11: modules[0].bus: expected no bus: no board known here sends such taxels, found 0",
            ),
        ],
    );
    check(
        palpate_fixtures::layout("icub-forearm").unwrap(),
        LayoutFile::read,
        &[
            (
                "columns = 10",
                "columns = 33",
                "f.toml:14: modules[0].boards: expected at most 192 taxels on a board (16 triangles of 12), here 198, found [0]",
            ),
            (
                "boards = [0]",
                "boards = [0, 1]",
                "f.toml:14: modules[0].boards: expected 1 board for all of the module's triangles, found [0, 1]",
            ),
        ],
    );
}
