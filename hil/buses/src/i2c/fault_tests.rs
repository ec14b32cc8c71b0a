//! Tests of `fault.rs`.

use super::*;

#[test]
fn errnos_are_told_apart_and_only_passing_ones_are_tried_again() {
    let kind = |errno: Errno| {
        let fault = Fault {
            bus: "/dev/i2c-1".into(),
            address: 0x40,
            kind: errno.into(),
        };
        (fault.kind(), fault.to_string())
    };
    let address = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);
    let unknown = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Unknown);
    assert_eq!(kind(Errno::ENXIO).0, address);
    assert_eq!(kind(Errno::EREMOTEIO).0, unknown);
    assert_eq!(kind(Errno::EAGAIN).0, ErrorKind::ArbitrationLoss);
    assert_eq!(kind(Errno::EBUSY).0, ErrorKind::Bus);
    assert_eq!(kind(Errno::EIO).0, ErrorKind::Bus);
    assert_eq!(kind(Errno::ETIMEDOUT).0, ErrorKind::Other);
    assert_eq!(kind(Errno::ENODEV).0, ErrorKind::Other);
    let texts = [
        Errno::ENXIO,
        Errno::EREMOTEIO,
        Errno::EBUSY,
        Errno::ETIMEDOUT,
        Errno::ENODEV,
    ];
    let texts = texts.map(|e| kind(e).1);
    for (i, text) in texts.iter().enumerate() {
        assert!(text.starts_with("/dev/i2c-1, address 0x40: "), "{text}");
        assert!(!texts[..i].contains(text), "{text}");
    }
}
