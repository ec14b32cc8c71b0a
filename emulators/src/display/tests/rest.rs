//! Rest of a wire, cold, after a hot pass, and cold again: for an hour nothing moves, and a wire that went round is the one
//! that set out.

use super::*;
use palpate_core::physics::{History, Mount, TissueParameters, WireParameters, WireState};

const HOUR: Nanos = Nanos(3_600_000_000_000);
const MINUTE: Nanos = Nanos(60_000_000_000);
/// Fractions and kelvins, and metres, that rounding may take away.
const SAME: f64 = 1e-9;
const SAME_M: f64 = 1e-15;

const fn hours(n: u64) -> Nanos {
    Nanos(n * HOUR.0)
}

/// Everything that could drift.
#[derive(Clone, Copy, Debug)]
struct Standing {
    martensite: f64,
    r: f64,
    wire_c: f64,
    tissue_c: [f64; 2],
    bow_m: f64,
    skin_m: f64,
}

impl Standing {
    fn new(wire: &mut Wire, at: Nanos) -> Self {
        let martensite = wire.fraction(at);
        let strain = wire.strain(at).phase;
        let parameters = wire.solver().wire();
        let by_m = parameters.mechanics.transformation_strain;
        let by_r = parameters
            .r_phase
            .as_ref()
            .map_or(f64::INFINITY, |r| r.strain);
        let (shallow, deep) = wire.tissue(at);
        Self {
            martensite,
            r: (strain - by_m * martensite) / by_r,
            wire_c: wire.temperature(at),
            tissue_c: [shallow, deep],
            bow_m: wire.solver().bow_m(),
            skin_m: wire.displacement_m(at),
        }
    }

    fn assert_is(&self, other: &Self) {
        let pairs = [
            (self.martensite, other.martensite, SAME),
            (self.r, other.r, SAME),
            (self.wire_c, other.wire_c, SAME),
            (self.tissue_c[0], other.tissue_c[0], SAME),
            (self.tissue_c[1], other.tissue_c[1], SAME),
            (self.bow_m, other.bow_m, SAME_M),
            (self.skin_m, other.skin_m, SAME_M),
        ];
        for (a, b, same) in pairs {
            assert!((a - b).abs() < same, "{self:?} for {other:?}");
        }
    }
}

/// The thin wire of little two-way strain in a deep bow, which a pass leaves slack.
fn thin(state: WireState) -> WireParameters {
    WireParameters {
        diameter_m: 50e-6,
        length_m: 8e-3,
        resistance_ohm: 4.871,
        wire_share: 0.8448,
        air_h: 240.0,
        mount: Mount {
            sag_m: 250e-6,
            ..Mount::DEFAULT
        },
        history: History {
            state,
            ..History::COLD
        },
        ..WireParameters::FINAL
    }
}

/// Lets an hour pass, looked at every minute, and returns its end.
fn rest(wire: &mut Wire, from: Nanos) -> Nanos {
    let first = Standing::new(wire, from);
    for minute in 1..=60 {
        Standing::new(wire, from + Nanos(minute * MINUTE.0)).assert_is(&first);
    }
    from + HOUR
}

/// Drives three pulses as a hot pass has them, and returns their end.
fn pass(wire: &mut Wire, from: Nanos) -> Nanos {
    for pulse in 0..3 {
        let start = from + Nanos(pulse * PERIOD.0);
        wire.set_current(start, 1.2);
        wire.set_current(start + Nanos(183_000), 0.0);
    }
    from + Nanos(3 * PERIOD.0)
}

/// A wire on a finger, in colder air, comes to rest within the first hour and stays.
#[test]
fn an_hour_of_rest_moves_nothing() {
    let tissue = TissueParameters::DEFAULT;
    for (state, cold) in [(WireState::Cold, true), (WireState::Passed, false)] {
        let wire = Wire::new(&thin(state), &tissue, 33.0);
        let mut wire = wire.and_then(|w| w.worn(&tissue)).unwrap();
        let begun = Standing::new(&mut wire, Nanos::ZERO);
        rest(&mut wire, HOUR);
        let rested = Standing::new(&mut wire, hours(2));
        let m = if cold { 1.0 } else { 0.0 };
        assert!((rested.martensite - m).abs() < SAME, "{rested:?}");
        assert!(cold || rested.r > 0.9, "{rested:?}");
        // It did settle, from the finger's temperature towards the air's.
        assert!(begun.wire_c - rested.wire_c > 0.3, "{begun:?} {rested:?}");
        // A pass in mid-rest leaves what a wire that begins passed rests as.
        let end = pass(&mut wire, hours(2));
        assert!(wire.peaks(end).wire_c > 60.0);
        rest(&mut wire, hours(3));
        let passed = Standing::new(&mut wire, hours(4));
        assert!(passed.martensite < SAME, "{passed:?}");
        if cold {
            assert!(passed.bow_m - rested.bow_m > 20e-6, "{passed:?}");
        } else {
            passed.assert_is(&rested);
        }
    }
}

/// Rounds in a room under the martensite's finish, where a steady current holds the wire as warm as a finger does.
#[test]
fn a_wire_that_is_passed_and_cooled_is_the_cold_one() {
    let tissue = TissueParameters {
        body_c: 5.0,
        air_c: 5.0,
        ..TissueParameters::DEFAULT
    };
    let cool = WireParameters {
        ends_c: 5.0,
        ..thin(WireState::Cold)
    };
    let wire = Wire::new(&cool, &tissue, 5.0);
    let mut wire = wire.and_then(|w| w.worn(&tissue)).unwrap();
    let warm_w = {
        let mut other = wire.clone();
        other.set_power(Nanos::ZERO, 1e-3);
        28.0 * 1e-3 / (other.temperature(HOUR) - 5.0)
    };
    let mut now = rest(&mut wire, Nanos::ZERO);
    let set_out = Standing::new(&mut wire, now);
    assert!((set_out.martensite - 1.0).abs() < SAME, "{set_out:?}");
    wire.set_power(now, warm_w);
    now = rest(&mut wire, now + HOUR);
    let cold = Standing::new(&mut wire, now);
    assert!((cold.wire_c - 33.0).abs() < 1e-6, "{cold:?}");
    now = pass(&mut wire, now);
    wire.set_power(now, warm_w);
    now = rest(&mut wire, now + HOUR);
    let passed = Standing::new(&mut wire, now);
    assert!(passed.martensite < SAME && passed.r > 0.9, "{passed:?}");
    assert!(passed.bow_m - cold.bow_m > 20e-6, "{passed:?} {cold:?}");
    // Cooled under the martensite's finish, and warmed again.
    wire.set_power(now, 0.0);
    now = rest(&mut wire, now + HOUR);
    Standing::new(&mut wire, now).assert_is(&set_out);
    wire.set_power(now, warm_w);
    now = rest(&mut wire, now + HOUR);
    Standing::new(&mut wire, now).assert_is(&cold);
}
