//! Tests of `stroke.rs`.

use super::super::display::tests::{line, thimble};
use super::*;

fn stroke(from: (f32, f32), to: (f32, f32), ms: u64) -> Stroke {
    Stroke {
        from: Point::new(from.0, from.1),
        to: Point::new(to.0, to.1),
        length: Duration::from_millis(ms),
    }
}

#[test]
fn even_passages_keep_the_law() {
    let display = line(&[0.0, 10.0, 20.0, 30.0]);
    let cells = Cells::new(&display).unwrap();
    // 180 ms over three gaps: 60 ms each, (60 - 47.3) / 0.32 = 39.7 ms.
    let dabs = stroke((0.0, 0.0), (30.0, 0.0), 180)
        .plan(&cells, display.gap(), LONGEST)
        .unwrap();
    assert_eq!(dabs.len(), 4);
    for (i, dab) in dabs.iter().enumerate() {
        assert!((dab.place.x - 10.0 * i as f32).abs() < 1e-3);
        assert!(dab.duration.as_micros().abs_diff(39_687) < 20);
        assert!(dab.at.as_micros().abs_diff(60_000 * i as u64) < 40);
    }
}

#[test]
fn every_plan_keeps_onsets_in_order_and_bursts_in_bounds() {
    let display = thimble();
    let cells = Cells::new(&display).unwrap();
    for ms in [400, 700, 1500, 6000] {
        let dabs = stroke((-9.0, -5.0), (7.0, 6.0), ms)
            .plan(&cells, display.gap(), LONGEST)
            .unwrap();
        assert!(dabs.len() >= 3);
        for pair in dabs.windows(2) {
            assert!(pair[0].at < pair[1].at);
            let soa = Duration::from_micros(pair[1].at.as_micros() - pair[0].at.as_micros());
            assert!(pair[0].duration <= soa, "{ms} ms: d <= SOA");
            assert!(pair[0].duration <= LONGEST);
        }
    }
}

#[test]
fn no_stroke_and_a_stroke_too_fast_are_refused() {
    let display = thimble();
    let cells = Cells::new(&display).unwrap();
    let plan = |s: Stroke| s.plan(&cells, display.gap(), LONGEST);
    assert_eq!(
        plan(stroke((1.0, 1.0), (1.0, 1.0), 500)),
        Err(StrokeError::NoLength)
    );
    assert_eq!(
        plan(stroke((f32::NAN, 1.0), (1.0, 1.0), 500)),
        Err(StrokeError::NoLength)
    );
    let Err(StrokeError::TooFast(least)) = plan(stroke((0.0, -14.25), (0.0, 14.25), 50)) else {
        panic!("50 ms are too short for two stimuli");
    };
    let slower = Stroke {
        length: least,
        ..stroke((0.0, -14.25), (0.0, 14.25), 0)
    };
    assert!(plan(slower).is_ok());
}
