//! Tests of `bench.rs`: which limits of time a burst bears.

use palpate_core::guard::{HARD, Limits, Plant, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::units::{Board, Channel, Duration, Point, Prescale};

use super::*;

fn guard(prescale: u8, burst_ms: u64) -> Guard {
    let wire = DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(0),
    };
    let plant = Plant {
        prescale: Prescale::new(prescale),
        ..Plant::default()
    };
    let limits = Limits {
        burst: Duration::from_millis(burst_ms),
        ..HARD
    };
    Guard::new(limits, plant, &[wire], WornWire::default()).unwrap()
}

/// What is said of these limits of time, if they are refused.
fn said(guard: &Guard, heartbeat_ms: u64, transfer_ms: u64) -> Option<String> {
    let real = Real {
        heartbeat_ms: heartbeat_ms.try_into().unwrap(),
        transfer_ms: transfer_ms.try_into().unwrap(),
        ..Real::new(vec![], vec![])
    };
    match refuse_slow(&real, guard) {
        Ok(()) => None,
        Err(Failure::Input(said)) => Some(said),
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn both_limits_of_time_leave_a_period_and_the_bus_of_a_burst() {
    for (prescale, burst_ms) in [(30, 50), (30, 40), (92, 50)] {
        let guard = guard(prescale, burst_ms);
        let surplus = guard.surplus();
        let most = (burst_ms * 1000 - surplus.as_micros()) / 1000;
        assert!((5..burst_ms).contains(&most), "{most}");
        assert_eq!(said(&guard, most, most), None);
        let rest = format!("{:.1} ms", surplus.as_micros() as f64 * 1e-3);
        let burst = format!("{burst_ms} ms");
        for (key, heartbeat, transfer) in [
            ("real.heartbeat_ms", most + 1, most),
            ("real.transfer_ms", most, most + 1),
        ] {
            let said = said(&guard, heartbeat, transfer).unwrap();
            let bound = format!("{key}: expected at most {most}, found {}", most + 1);
            for words in [&bound, &rest, &burst] {
                assert!(said.contains(words), "no `{words}` in {said}");
            }
        }
    }
}

#[test]
fn where_a_period_leaves_nothing_of_a_burst_the_frequency_is_too_low() {
    let guard = guard(92, 19);
    let most = (19_000 - guard.surplus().as_micros()) / 1000;
    assert!((1..5).contains(&most), "{most}");
    let heartbeat = said(&guard, 5, 1).unwrap();
    assert!(
        heartbeat.starts_with("real.heartbeat_ms: no value from 5 fits, raise drive.pwm_hz"),
        "{heartbeat}"
    );
}
