//! Tests of `contacts_csv.rs`.

use super::*;
use crate::synthetic;

#[test]
fn every_row_has_the_columns_of_the_header() {
    let trace = synthetic::circle(1);
    let mut out = Vec::new();
    write_table(&trace, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(HEADER));
    let mut rows = 0;
    for line in lines {
        let fields: Vec<_> = line.split(',').collect();
        assert_eq!(fields.len(), 9, "{line}");
        assert!(fields[4].parse::<f64>().unwrap().abs() < 10.0);
        rows += 1;
    }
    assert_eq!(rows, trace.each::<event::Contact>().count());
}

#[test]
fn with_several_displays_a_row_says_whose_it_is() {
    let mut trace = synthetic::circle(1);
    let display = |name: &str, module| DisplayInfo {
        name: name.to_owned(),
        wires: 8,
        modules: vec![module],
    };
    trace.header.displays = vec![display("thumb", 3), display("a, \"b\"", 0)];
    let mut out = Vec::new();
    write_table(&trace, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(&*format!("{HEADER},display")));
    assert!(lines.clone().count() > 10);
    assert!(
        lines.all(|line| line.ends_with(",\"a, \"\"b\"\"\"")),
        "{text}"
    );
}
