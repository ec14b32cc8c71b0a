//! A path that is no adapter is refused with what to type.

use super::*;

#[test]
fn nodes_that_are_none_say_what_to_type() {
    let missing = LinuxAdapter::open(Path::new("/dev/i2c-999"), &[0x40]).unwrap_err();
    assert!(
        missing.to_string().contains("modprobe i2c-dev"),
        "{missing}"
    );
    let null = LinuxAdapter::open(Path::new("/dev/null"), &[0x40]).unwrap_err();
    assert_eq!(null.to_string(), "/dev/null: is no I2C adapter");
    assert_eq!(number(Path::new("/dev/i2c-12")), Some(12));
    assert_eq!(number(Path::new("/dev/null")), None);
}
