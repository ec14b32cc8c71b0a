//! Tests of the rows.

use std::collections::BTreeSet;

use super::*;

#[test]
fn rows_have_names_of_their_own_and_say_something() {
    let mut seen = BTreeSet::new();
    for row in rows() {
        assert!(seen.insert(row.id), "{}", row.id);
        let kind = row.id.split('-').next().unwrap();
        assert!(["eq", "fig", "tab", "sec", "claim"].contains(&kind));
        assert!(row.says.ends_with('.') && row.assumed.ends_with('.'));
    }
    assert!(seen.len() >= 25, "{}", seen.len());
}

/// A second computation gives the same numbers.
#[test]
fn equations_are_the_same_numbers_twice() {
    let equations = rows().filter(|row| row.id.starts_with("eq-"));
    for row in equations {
        let (one, two) = ((row.compute)().unwrap(), (row.compute)().unwrap());
        assert_eq!(one, two, "{}", row.id);
        assert!(!one.values.is_empty(), "{}", row.id);
    }
}
