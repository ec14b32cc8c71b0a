//! A frame that cannot be on a bus cannot be made.

use super::*;

#[test]
fn refuses_what_does_not_fit() {
    assert_eq!(CanFrame::new(0x800, &[]), None);
    assert_eq!(CanFrame::new(0x7ff, &[0; 9]), None);
    let frame = CanFrame::new(0x104, &[1, 2]).unwrap();
    assert_eq!((frame.id(), frame.data()), (0x104, &[1u8, 2][..]));
    assert_eq!(
        Frame::id(&frame),
        Id::Standard(StandardId::new(0x104).unwrap())
    );
}
