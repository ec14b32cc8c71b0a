//! Tests of `order.rs`.

use super::*;

fn places(names: &[&str]) -> Vec<(String, Vec<usize>, bool)> {
    let groups = groups(names.iter().copied().enumerate());
    let parts = |g: Group| (g.pattern, g.places, g.has_axes);
    groups.into_iter().map(parts).collect()
}

fn one(names: &[&str], pattern: &str, order: &[usize], has_axes: bool) {
    assert_eq!(
        places(names),
        [(pattern.to_owned(), order.to_vec(), has_axes)]
    );
}

#[test]
fn numbers_are_counted_and_not_spelt() {
    one(&["ch0", "ch1", "ch10", "ch2"], "ch#", &[0, 1, 3, 2], false);
    one(
        &["row1_col0", "row0_col1", "row0_col0"],
        "row#_col#",
        &[2, 1, 0],
        false,
    );
    one(&["data[1]", "data[0]"], "data[#]", &[1, 0], false);
}

#[test]
fn axes_go_with_their_number_wherever_the_letter_stands() {
    let by_axis = ["raw_x0", "raw_x1", "raw_y0", "raw_y1", "raw_z0", "raw_z1"];
    one(&by_axis, "raw_?#", &[0, 2, 4, 1, 3, 5], true);
    one(
        &["2X", "2Y", "2Z", "1X", "1Y", "1Z"],
        "#?",
        &[3, 4, 5, 0, 1, 2],
        true,
    );
    // An x in a word is none.
    one(
        &["taxel1_z", "taxel1_y", "taxel1_x"],
        "taxel#_?",
        &[2, 1, 0],
        true,
    );
}

#[test]
fn names_without_a_number_and_names_that_stand_twice_have_no_order() {
    assert_eq!(places(&["time", "temperature"]), []);
    assert_eq!(places(&["ch1", "ch01"]), []);
    assert_eq!(places(&["ch99999999999999999999999"]), []);
}

#[test]
fn several_groups_stand_in_the_order_of_the_file() {
    let names = ["b1", "b2", "a1", "a2"];
    let found = [
        ("b#".to_owned(), vec![0, 1], false),
        ("a#".to_owned(), vec![2, 3], false),
    ];
    assert_eq!(places(&names), found);
}
