//! Tests of `socket.rs`.

use super::*;

fn bytes(id: u32, length: u8) -> [u8; FRAME] {
    let mut bytes = [0; FRAME];
    bytes[..4].copy_from_slice(&id.to_ne_bytes());
    bytes[4] = length;
    bytes[8..].copy_from_slice(&[0x93, 0x7e, 0x31, 0x7e, 0x15, 0x93, 0x12, 0x0f]);
    bytes
}

#[test]
fn frames_of_seven_and_eight_bytes_are_frames() {
    for length in [0, 2, 7, 8] {
        let Content::Frame(frame) = content(&bytes(0x004, length)) else {
            panic!("length {length}");
        };
        assert_eq!((frame.id(), frame.data().len()), (4, usize::from(length)));
    }
}

#[test]
fn what_no_board_sends_is_no_frame() {
    let strange = [
        (libc::CAN_EFF_FLAG | 4, 8),
        (libc::CAN_RTR_FLAG | 4, 0),
        (0x800, 8),
        (4, 9),
        (4, 255),
    ];
    for (id, length) in strange {
        assert_eq!(content(&bytes(id, length)), Content::Other, "{id:x}");
    }
    assert_eq!(content(&bytes(4, 8)[..15]), Content::Other);
    assert_eq!(content(&[]), Content::Other);
}

#[test]
fn error_frames_keep_class_and_data() {
    let id = libc::CAN_ERR_FLAG | libc::CAN_ERR_BUSOFF;
    assert_eq!(
        content(&bytes(id, 8)),
        Content::Error(0x40, [0x93, 0x7e, 0x31, 0x7e, 0x15, 0x93, 0x12, 0x0f])
    );
}
