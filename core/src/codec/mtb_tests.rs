//! Tests of `mtb.rs`.

use super::*;

#[test]
fn a_triangle_survives_the_wire() {
    let taxels: [u8; TAXELS] = core::array::from_fn(|i| i as u8);
    let mut seen = [0; TAXELS];
    for (half, head) in halves(&taxels).into_iter().zip([0x40, 0xC0]) {
        let message = Message {
            board: 0xA,
            triangle: 3,
            half,
        };
        let frame = message.encode().unwrap();
        assert_eq!(
            (frame.id(), frame.data()[0], frame.data().len()),
            (0x4A3, head, 8)
        );
        assert_eq!(Message::decode(&frame), Some(message));
        match half {
            Half::First(t) => seen[..7].copy_from_slice(&t),
            Half::Second(t, errors) => {
                seen[7..].copy_from_slice(&t);
                assert_eq!(errors, [0, 0]);
            }
        }
    }
    assert_eq!(seen, taxels);
}

#[test]
fn other_classes_and_heads_are_not_skin() {
    let frame = |id, data: &[u8]| CanFrame::new(id, data).unwrap();
    assert_eq!(Message::decode(&frame(0x5A3, &[0x40; 8])), None);
    assert_eq!(Message::decode(&frame(0x4A3, &[0x41; 8])), None);
    assert_eq!(Message::decode(&frame(0x4A3, &[0x40; 7])), None);
    let high = Message {
        board: 16,
        triangle: 0,
        half: Half::First([0; 7]),
    };
    assert_eq!(high.encode(), None);
}
