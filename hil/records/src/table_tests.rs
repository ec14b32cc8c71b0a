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
fn rows_may_differ_in_length() {
    assert_eq!(as_csv([vec![1, 2], vec![3]]), "1,2\n3\n");
    assert_eq!(as_csv(Vec::<u8>::new()), "");
}
