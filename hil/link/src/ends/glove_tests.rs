//! Tests of round trips: each message is answered once, and late or unknown numbers add nothing.

use super::*;

#[test]
fn the_first_frame_under_a_message_is_its_answer() {
    let at = |ms: u64| Instant::from_micros(ms * 1000);
    let mut awaited = Awaited::default();
    for number in 1..=4 {
        awaited.send(number, at(10 * number));
    }
    awaited.hear(0, at(11)); // a skin that nothing bends
    awaited.hear(2, at(27)); // 7 ms; the first was passed over
    awaited.hear(2, at(37));
    awaited.hear(1, at(38));
    awaited.hear(9, at(45)); // another glove's
    assert_eq!(awaited.answered, 1);
    let spread = awaited.round_trips.spread().unwrap();
    assert_eq!(format!("{:.1} {:.1}", spread.median, spread.max), "7.0 7.0");
}

#[test]
fn messages_without_an_answer_do_not_grow() {
    let mut awaited = Awaited::default();
    for number in 1..=5000 {
        awaited.send(number, Instant::ZERO);
    }
    assert_eq!(awaited.sent.len(), MOST_AWAITED);
    assert_eq!(awaited.sent.front(), Some(&(4001, Instant::ZERO)));
}
