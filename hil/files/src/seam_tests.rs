//! Tests of `seam.rs`.

use super::super::LayoutFile;
use super::*;

const PADS: &str = r#"
kind = "sensor"
name = "pads"
description = "Three pads"

[[modules]]
name = "pad"
grid = { rows = 4, columns = 4, pitch_mm = 5.0 }
repeat = { rows = 1, columns = 3, step_mm = [20.0, 20.0] }
"#;

fn layout(modules: &str, edges: &str) -> Result<LayoutFile, FileError> {
    let text = format!("{PADS}\n[[seams]]\nmodules = {modules}\nedges_mm = {edges}\n");
    LayoutFile::read(&Source::new("f.toml", text))
}

const EDGES: &str = "[[[10.0, -10.0], [10.0, 10.0]], [[-10.0, -10.0], [-10.0, 10.0]]]";

#[test]
fn copies_join_by_their_own_names() {
    let Ok(LayoutFile::Sensor(file)) = layout(r#"["pad-3", "pad-1"]"#, EDGES) else {
        panic!("refused");
    };
    assert_eq!(file.seams[0].indices(&file.modules), Some([2, 0]));
}

#[test]
fn a_seam_names_two_modules_and_an_edge_of_one_length() {
    let names = "seams[0].modules: expected the names of two different modules of this layout";
    let length = "seams[0].edges_mm: expected an edge of one length in both modules";
    for (modules, edges, said) in [
        (r#"["pad", "pad-1"]"#, EDGES, names),
        (r#"["pad-2", "pad-2"]"#, EDGES, names),
        (
            r#"["pad-1", "pad-2"]"#,
            "[[[1.0, 1.0], [1.0, 1.0]], [[2.0, 2.0], [2.0, 2.0]]]",
            length,
        ),
        (
            r#"["pad-1", "pad-2"]"#,
            "[[[0.0, 0.0], [9.0, 0.0]], [[0.0, 0.0], [9.1, 0.0]]]",
            length,
        ),
        (
            r#"["pad-1", "pad-2"]"#,
            "[[[0.0, nan], [9.0, 0.0]], [[0.0, 0.0], [9.0, 0.0]]]",
            "seams[0].edges_mm[0][0][1]: expected a finite number, found nan",
        ),
    ] {
        let error = layout(modules, edges).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
}
