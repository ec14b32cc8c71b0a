//! Tests of `strokes.rs`.

use super::*;
use crate::units::{Duration, Point};

#[test]
fn stimuli_come_in_their_turn_and_missed_ones_are_left_out() {
    let at = |ms: u64| Instant::from_micros(1000 * ms);
    let dab = |ms: u64| Dab {
        at: Duration::from_millis(ms),
        duration: Duration::from_millis(30),
        place: Point::new(ms as f32, 0.0),
        weight: 1.0,
    };
    let planned = Planned {
        start: at(100),
        end: at(400),
        dabs: [dab(0), dab(60), dab(120)].into(),
    };
    let mut strokes = Strokes::new(&[planned]);
    assert_eq!(strokes.next(), at(100));
    assert_eq!(strokes.due(at(99)), None);
    assert_eq!(strokes.due(at(100)), Some((at(100), dab(0))));
    assert_eq!(strokes.due(at(300)), Some((at(220), dab(120))));
    assert_eq!(strokes.next(), Instant::FAR_FUTURE);
    assert!(!strokes.hold(at(99)) && strokes.hold(at(100)) && !strokes.hold(at(400)));
    strokes.leave(&[(at(500), at(600))]);
    assert!(strokes.hold(at(500)) && !strokes.hold(at(600)) && strokes.hold(at(399)));
    assert_eq!(strokes.spans(), [(at(100), at(400))]);
}
