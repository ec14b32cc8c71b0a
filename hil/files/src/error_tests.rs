//! Tests of `error.rs`.

use super::*;

#[test]
fn numbers_of_the_system_are_left_out_wherever_they_stand() {
    for (text, plain) in [
        ("File exists (os error 17)", "File exists"),
        (
            "can0: No such device (os error 19); `ip link` lists some",
            "can0: No such device; `ip link` lists some",
        ),
        ("a (os error 2), b (os error -1)", "a, b"),
        ("an (os error message", "an (os error message"),
        ("", ""),
    ] {
        assert_eq!(unnumbered(text), plain);
    }
    let gone = std::fs::metadata("/no/such/place").unwrap_err();
    assert_eq!(said(&gone), "no such file or folder");
    let denied = io::Error::from_raw_os_error(13);
    assert_eq!(said(&denied), "Permission denied");
}
