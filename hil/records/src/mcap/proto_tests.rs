//! Tests of `proto.rs`.

use super::*;

#[test]
fn what_was_written_is_read_and_defaults_take_no_room() {
    let mut message = Message::default();
    message
        .uint(1, 300_u32)
        .uint(2, 0_u32)
        .double(3, -1.5)
        .text(4, "ä")
        .uint(200, u64::MAX);
    assert_eq!(&message.bytes()[..3], [0x08, 0xac, 0x02]); // the encoding guide's own example
    let fields: Option<Vec<_>> = Fields::new(message.bytes()).collect();
    assert_eq!(
        fields.unwrap(),
        [
            (1, Value::Number(300)),
            (3, Value::Fixed64((-1.5_f64).to_bits())),
            (4, Value::Data("ä".as_bytes())),
            (200, Value::Number(u64::MAX)),
        ]
    );
}

#[test]
fn damaged_messages_end() {
    for bytes in [
        &[0x08][..],
        &[0x08, 0x80],
        &[0x0a, 5, 1],
        &[0x0b, 0],
        &[0x00, 1],
        &[0x08, 255, 255, 255, 255, 255, 255, 255, 255, 255, 2],
    ] {
        let last = Fields::new(bytes).last().unwrap();
        assert_eq!(last, None, "{bytes:?}");
    }
}
