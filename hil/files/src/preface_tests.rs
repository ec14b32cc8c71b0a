//! Tests of `preface.rs`.

use super::*;

fn found(text: &str) -> Option<Preface> {
    Preface::find(text, Writing::default())
}

const fn lines(lines: usize) -> Preface {
    Preface {
        lines,
        has_units: false,
        separator: None,
    }
}

#[test]
fn a_table_that_begins_at_once_has_none() {
    for text in [
        "t,a1,a2\n0,1,2\n1,1,2\n2,1,2\n3,1,2\n",
        "0,1,2\n1,1,2\n2,1,2\n3,1,2\n",
        "# made today\nt a1 a2\n0 1 2\n1 1 2\n2 1 2\n",
        "a1\ta2\tTime (ms)\n1\t2\t0\n1\t2\t10\n1\t2\t20\n",
        "a1\ttimestamp\n1\t2026-03-01 00:00:00.000\n1\t2026-03-01 00:00:00.010\n1\t2026-03-01 00:00:00.020\n",
        // A row that cannot be read has an error of its own.
        "t,a1,a2\n0,1,oops\n1,1,2\n2,1,2\n3,1,2\n",
        "words\nand words\n",
        // Nor is one that was cut.
        "t,a1,a2\n0,1\n1\n2,1,2\n3,1,2\n4,1,2\n",
        "0,1\n1,2\n2,1,2\n3,1,2\n4,1,2\n",
        "0,1\n2,1,2\n3,1,2\n4,1,2\n",
        "",
    ] {
        assert_eq!(found(text), None, "{text}");
    }
}

#[test]
fn lines_of_another_width_stand_before_the_heading() {
    let rows = "t;a1;a2\n0,5;1;2\n1,5;1;2\n2,5;1;2\n3,5;1;2\n";
    let text = format!("Device: XR1944, 3\nrate = 100\n\n{rows}");
    let preface = found(&text).unwrap();
    assert_eq!(preface, lines(3));
    assert_eq!(preface.rest(&text), rows);
    assert!(
        preface
            .note(&text)
            .unwrap()
            .contains("behind 3 lines, from `Device: XR1944, 3`")
    );
    // Without a heading the first row comes next.
    assert_eq!(
        found("made by me\nat noon\n0,1,2\n1,1,2\n2,1,2\n3,1,2\n"),
        Some(lines(2))
    );
}

#[test]
fn units_below_the_heading_are_known_by_their_repetition() {
    let text = "t,a1,a2,a3\ns,mT,mT,mT\n0,1,2,3\n1,1,2,3\n2,1,2,3\n3,1,2,3\n";
    let preface = found(text).unwrap();
    assert!(preface.has_units && preface.lines == 0);
    assert_eq!(
        preface.rest(text),
        "t,a1,a2,a3\n0,1,2,3\n1,1,2,3\n2,1,2,3\n3,1,2,3\n"
    );
    // Names of groups above the names repeat, too, and have no units below them.
    let groups = "left,left,left,left\nt,a1,a2,a3\n0,1,2,3\n1,1,2,3\n2,1,2,3\n3,1,2,3\n";
    assert_eq!(found(groups), Some(lines(1)));
}

#[test]
fn a_spreadsheet_states_its_separator() {
    let text = "sep=;\nt;a1;a2\n0,5;1;2\n1,5;1;2\n2,5;1;2\n3,5;1;2\n";
    let stated = Preface {
        separator: Some(b';'),
        ..lines(1)
    };
    assert_eq!(found(text), Some(stated));
}
