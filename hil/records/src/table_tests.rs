//! Tests of `table.rs`.

use super::*;

#[test]
fn texts_that_need_quotes_have_them() {
    let rows = [("plain", ["a, \"b\"", ""]), ("two\nlines", ["c", "d"])];
    assert_eq!(
        as_csv(rows),
        "plain,\"a, \"\"b\"\"\",\n\"two\nlines\",c,d\n"
    );
}

#[test]
fn what_a_reader_takes_for_the_end_of_a_row_stands_in_quotes() {
    assert_eq!(as_csv([["a\rb", "c"]]), "\"a\rb\",c\n");
}

#[test]
fn a_plain_text_has_nothing_that_moves_a_cursor() {
    let text = "why\r\n\t\u{1b}[2J \u{9b}31m \u{202e}ew \u{2028}";
    let plain_text = "why\\r\\n\\t\\u{1b}[2J \\u{9b}31m \\u{202e}ew \\u{2028}";
    assert_eq!(plain(text), plain_text);
    for same in ["", "1.5 mm, \"so\" \\ ", "Größe – 10 Ω"] {
        assert_eq!(plain(same), same);
    }
}

#[test]
fn rows_may_differ_in_length() {
    assert_eq!(as_csv([vec![1, 2], vec![3]]), "1,2\n3\n");
    assert_eq!(as_csv(Vec::<u8>::new()), "");
}
