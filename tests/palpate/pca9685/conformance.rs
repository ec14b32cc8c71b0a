//! The table in `docs/pca9685.md` names tests that exist, and leaves none out.

const TABLE: &str = include_str!("../../../docs/pca9685.md");
const FILES: [(&str, &str); 10] = [
    ("addresses", include_str!("addresses.rs")),
    ("benches", include_str!("benches.rs")),
    ("bus_time", include_str!("bus_time.rs")),
    ("clients", include_str!("clients.rs")),
    ("outputs", include_str!("outputs.rs")),
    ("pins", include_str!("pins.rs")),
    ("registers", include_str!("registers.rs")),
    ("sleep", include_str!("sleep.rs")),
    ("time", include_str!("time.rs")),
    ("updates", include_str!("updates.rs")),
];

/// The names of the tests in a source file.
fn tests(source: &str) -> impl Iterator<Item = &str> {
    (source.split("#[test]\n").skip(1))
        .filter_map(|rest| rest.trim_start().strip_prefix("fn ")?.split('(').next())
}

#[test]
fn the_table_and_the_tests_agree() {
    agree(TABLE, &FILES, 80);
}

/// Compares a page's tables with the tests of these files, of which there are more than `least`.
pub fn agree(page: &str, files: &[(&str, &str)], least: usize) {
    let named: Vec<&str> = (page.split('`').skip(1).step_by(2))
        .filter(|code| code.contains("::") && !code.contains(' '))
        .collect();
    let there: Vec<String> = (files.iter())
        .flat_map(|(file, source)| tests(source).map(move |name| format!("{file}::{name}")))
        .collect();
    assert!(there.len() > least);
    for name in &named {
        assert!(there.iter().any(|t| t == name), "the table names {name}");
    }
    for name in &there {
        assert!(named.contains(&name.as_str()), "the table lacks {name}");
    }
}
