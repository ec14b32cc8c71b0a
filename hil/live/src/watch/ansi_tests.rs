//! What goes to a terminal.

use super::super::grid::Style;
use super::*;

#[test]
fn cells_in_a_row_need_one_position_and_one_style() {
    let hot = Cell {
        symbol: Some('#'),
        style: Style::of_color(Color::Indexed(196)),
    };
    let mut ansi = Ansi::new(Vec::new());
    let cells = [(3, 1, &hot), (4, 1, &hot), (0, 2, &Cell::EMPTY)];
    ansi.draw(&cells).unwrap();
    let text = String::from_utf8(ansi.out).unwrap();
    assert_eq!(text, "\x1b[2;4H\x1b[0;38;5;196m##\x1b[3;1H\x1b[0m \x1b[0m");
}
