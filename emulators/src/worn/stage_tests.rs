//! Tests of `stage.rs`.

use palpate_core::units::Point;

use super::*;

/// What a wire is to get after a pulse of this length, us, and when that changed last, of amplifiers that rise in 30 us.
fn after_a_pulse(us: u64) -> (u32, Option<Nanos>) {
    let config = AmplifierConfig {
        current: Milliamps(990),
        set: None,
        rise: Nanos::from_micros(30),
        on_ohm: 0.0,
    };
    let mut stage = Stage::new(config, 1);
    let edge = |at_us, pin| Edge {
        at: Nanos::from_micros(at_us),
        channel: Channel(3),
        pin,
    };
    stage.edge(0, edge(100, Pin::High));
    stage.edge(0, edge(100 + us, Pin::Low));
    let due = stage.due(Nanos::from_micros(1_000));
    let last = (0..due).filter_map(|index| stage.apply(index)).last();
    let place = WirePlace {
        at: Point::new(0.0, 0.0),
        board: 0,
        channel: 3,
    };
    (stage.current(&place).0, last)
}

#[test]
fn a_pulse_shorter_than_a_third_of_the_rise_gives_nothing_and_ends() {
    assert_eq!(after_a_pulse(50), (0, Some(Nanos::from_micros(160))));
    assert_eq!(after_a_pulse(11), (0, Some(Nanos::from_micros(121))));
    assert_eq!(after_a_pulse(9), (0, None));
    assert_eq!(after_a_pulse(1), (0, None));
}
