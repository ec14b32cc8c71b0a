//! Tests of `uptime.rs`.

use super::*;

#[test]
fn uptime_goes_on_from_one_start() {
    let before = (uptime_start(), uptime_ms());
    let after = (uptime_start(), uptime_ms());
    assert_eq!(before.0, after.0);
    assert!(0 < before.1 && before.1 <= after.1);
    // A kernel says which start it is, and in a line.
    assert!(
        before
            .0
            .is_none_or(|start| start.len() >= 36 && !start.contains('\n'))
    );
}

#[test]
fn a_file_that_is_absent_says_nothing_and_one_that_is_unreadable_leaves_the_start_unknown() {
    let failed = |kind: io::ErrorKind| unless_absent(Err(kind.into()));
    assert_eq!(failed(io::ErrorKind::NotFound).as_deref(), Some(""));
    assert_eq!(failed(io::ErrorKind::PermissionDenied), None);
    assert_eq!(unless_absent(Ok("x".into())).as_deref(), Some("x"));
}
