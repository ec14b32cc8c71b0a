//! Tests of `dialect.rs`.

use super::*;

fn rows(text: &str) -> Vec<Vec<String>> {
    let mut fields = Fields::new(Dialect::guess(text, Writing::default()));
    let lines = text.lines().filter(|line| !is_remark(line));
    lines
        .map(|line| fields.split(line).iter().map(str::to_owned).collect())
        .collect()
}

#[test]
fn the_separator_is_the_one_that_leaves_values() {
    let same = [["a", "b"], ["1", "2.5"], ["3", "4"]];
    for text in [
        "a,b\n1,2.5\n3,4\n",
        "a;b\n1;2.5\n3;4\n",
        "a;b\r\n1;2,5\r\n3;4\r\n",
        "a\tb\n1\t2,5\n3\t4\n",
        "  a   b\n  1   2.5\n  3   4\n",
        "# made today, by hand\na b\n1 2,5\n# pause\n3 4\n",
        "\"a\",\"b\"\n\"1\",\"2.5\"\n3,4\n",
    ] {
        assert_eq!(rows(text), same, "{text}");
    }
    // One damaged line does not change how the others are read.
    let damaged = rows("a;b\n1;2,5\n3;4\n5\n6;7\n");
    assert_eq!(damaged[1], ["1", "2.5"]);
}

#[test]
fn a_separator_at_the_end_of_a_line_is_no_field() {
    let mut fields = Fields::new(Dialect::default());
    let row = fields.split("1,2,");
    assert!(row.has_width(2) && row.has_width(3) && !row.has_width(1));
    assert!(!fields.split("1,2,3").has_width(2));
}

#[test]
fn dates_and_numbers_are_values_and_names_are_not() {
    let dates = [
        "2026-03-01T12:00:00Z",
        "2026-03-01",
        "1.3.2026 12:00:00,5",
        "12:00:00.5",
    ];
    for value in ["1", "-2.5e-3", "1,5", "", "nan"].into_iter().chain(dates) {
        assert!(is_value(value), "{value}");
    }
    for name in ["a", "1,2,3", "12:00", "0x12", "3-axis-1"] {
        assert!(!is_value(name), "{name}");
    }
}

#[test]
fn quotes_may_hold_commas_and_spaces_may_stand_around_fields() {
    let mut fields = Fields::new(Dialect::default());
    let mut of = |line: &str| {
        fields
            .split(line)
            .iter()
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    assert_eq!(of("a, b ,c"), ["a", "b", "c"]);
    assert_eq!(
        of("\"pressure, kPa\",\"x \"\"y\"\"\",z"),
        ["pressure, kPa", "x \"y\"", "z"]
    );
    assert_eq!(of("1, \"2\""), ["1", "2"]);
    assert_eq!(of("1,,"), ["1", "", ""]);
    assert_eq!(of("1"), ["1"]);
    // The memory of a longer line before leaves nothing behind.
    assert_eq!(of("100,200,300"), ["100", "200", "300"]);
    assert_eq!(of("4,5"), ["4", "5"]);
}
