//! Tests of `inbox.rs`.

use super::*;

#[test]
fn a_flood_fills_the_room_and_no_more() {
    let inbox = Inbox::new(3);
    (0..1000).for_each(|n| inbox.push(n));
    inbox.wait(Duration::from_secs(3600)); // something is there
    assert_eq!(
        [inbox.take(), inbox.take(), inbox.take(), inbox.take()],
        [Some(0), Some(1), Some(2), None]
    );
    assert_eq!(inbox.overflowed(), 997);
    inbox.wait(Duration::ZERO);
}
