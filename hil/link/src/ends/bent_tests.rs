//! Tests of a hand's messages: the newest counts, and what cannot be is left out.

use super::*;
use crate::message::JointAngle;

fn flexed(session: u64, sequence: u64, deg: f64) -> Flexed {
    let name = "mcp".to_owned();
    Flexed {
        version: VERSION,
        session,
        sequence,
        said_us: 0,
        joints: vec![JointAngle { name, deg }],
    }
}

#[test]
fn the_newest_message_of_one_glove_counts() {
    let mut newest = None;
    let at = Instant::from_micros;
    let mut heard = |session, sequence, deg, us| {
        keep(&mut newest, flexed(session, sequence, deg), at(us));
        newest.as_ref().map(|(own, _)| (own.session, own.sequence))
    };
    assert_eq!(heard(1, 0, 5.0, 0), None); // zero means none
    assert_eq!(heard(1, 3, 5.0, 0), Some((1, 3)));
    assert_eq!(heard(1, 3, 6.0, 10), Some((1, 3))); // twice
    assert_eq!(heard(1, 2, 6.0, 10), Some((1, 3))); // overtaken
    assert_eq!(heard(1, 4, f64::NAN, 10), Some((1, 3)));
    assert_eq!(heard(1, 4, 361.0, 10), Some((1, 3)));
    assert_eq!(heard(1, 4, -360.0, 10), Some((1, 4)));
    assert_eq!(heard(2, 9, 5.0, 1_000_010), Some((1, 4))); // the first one is still there
    assert_eq!(heard(2, 1, 5.0, 1_000_011), Some((2, 1)));
}
