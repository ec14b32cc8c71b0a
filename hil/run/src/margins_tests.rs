//! Tests of `margins.rs`.

use super::*;

fn flow(wire: usize, from_ms: u64, to_ms: u64, watts: f64) -> Flow {
    Flow {
        wire,
        from: Nanos::from_micros(from_ms * 1000),
        to: Nanos::from_micros(to_ms * 1000),
        watts,
    }
}

#[test]
fn the_worst_window_is_found_wherever_it_lies() {
    // 100 ms at 1 W, twice, half a second apart: any second that holds both has 200 mW.
    let flows = [flow(0, 3000, 3100, 1.0), flow(0, 3600, 3700, 1.0)];
    let energy = Energy::new(&flows, |_| true);
    assert!((energy.worst_mean_mw(1.0) - 200.0).abs() < 1e-9);
    // A window of 0.65 s holds one of them and half the other.
    assert!((energy.worst_mean_mw(0.65) - 150.0 / 0.65).abs() < 1e-9);
    // A run shorter than the window: the rest was nothing.
    assert!((energy.worst_mean_mw(10.0) - 20.0).abs() < 1e-9);
    assert!(Energy::new(&[], |_| true).worst_mean_mw(1.0).abs() < 1e-12);
}

#[test]
fn bursts_end_with_a_gap_and_belong_to_one_wire() {
    let flows = [
        flow(0, 0, 1, 2.0),
        flow(1, 2, 3, 2.0),
        flow(0, 5, 6, 2.0),
        flow(0, 30, 31, 2.0),
    ];
    let (ms, mj) = bursts(&flows, 2);
    assert!(
        (ms - 6.0).abs() < 1e-9 && (mj - 4.0).abs() < 1e-9,
        "{ms} {mj}"
    );
}

#[test]
fn a_guard_that_found_an_overrun_knows_the_rows_that_it_passed() {
    use palpate_core::guard::{HARD, Plant, WornWire};
    use palpate_core::illusion::DisplayWire;
    use palpate_core::schedule::Stimulus;
    use palpate_core::units::{Board, Channel, Instant, Point, Ticks};

    let wire = DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(0),
    };
    let rows = |width: u16, off_ms: u64| {
        let mut guard = Guard::new(HARD, Plant::default(), &[wire], WornWire::default()).unwrap();
        let at = |ms: u64| Instant::from_micros(ms * 1000);
        let stimulus = Stimulus {
            wire: 0,
            width: Ticks::new(width),
            peak: guard.plant().peak,
            at: at(0),
            until: at(35),
        };
        guard.admit(at(0), Board(0), &[stimulus], |_| ());
        guard.ask_off(at(35));
        guard.all_off(at(off_ms));
        let rows = exceeded(&guard);
        rows.iter().map(|m| (m.of, m.worst())).collect::<Vec<_>>()
    };
    assert_eq!(rows(60, 56), []);
    assert_eq!(rows(60, 60), [(Limited::Burst, 60.0)]);
    let worst = rows(140, 4035);
    let of: Vec<Limited> = worst.iter().map(|row| row.0).collect();
    assert_eq!(of[0], Limited::Burst);
    for row in [Limited::BurstEnergy, Limited::SkinPeak, Limited::SkinMean] {
        assert!(of.contains(&row), "{worst:?}");
    }
    let energy = worst.iter().find(|row| row.0 == Limited::BurstEnergy);
    // 64 mW of current for 4 s and a little more, from above.
    assert!((257.0..270.0).contains(&energy.unwrap().1), "{energy:?}");
}
