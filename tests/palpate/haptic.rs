//! The tables in `docs/drv2605.md` name tests that exist, and leave none out.

const TABLES: &str = include_str!("../../docs/drv2605.md");
const FILES: [(&str, &str); 5] = [
    (
        "drv2605",
        include_str!("../../emulators/src/haptic/drv2605/tests.rs"),
    ),
    (
        "erm",
        include_str!("../../emulators/src/haptic/erm_tests.rs"),
    ),
    (
        "lra",
        include_str!("../../emulators/src/haptic/lra_tests.rs"),
    ),
    (
        "published",
        include_str!("../../emulators/src/haptic/published_tests.rs"),
    ),
    (
        "tca9548a",
        include_str!("../../emulators/src/haptic/tca9548a_tests.rs"),
    ),
];

#[test]
fn the_tables_and_the_tests_agree() {
    crate::pca9685::agree(TABLES, &FILES, 40);
}
