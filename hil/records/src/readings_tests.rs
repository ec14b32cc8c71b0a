//! Tests of `readings.rs`.

use super::*;
use palpate_core::skin::Axes;

#[test]
fn what_would_be_too_much_loses_every_other_frame_and_keeps_the_first() {
    let layout = Layout::single(Module::grid("pad", 2, 2, 4.7).unwrap()).unwrap();
    let mut frame = RelativeFrame::new(&layout);
    let mut readings = Readings {
        most: 64,
        ..Readings::sampled(&layout, 0)
    };
    for n in 0..1000_u64 {
        let counts = [[0.0, 0.0, n as f32]; 4];
        frame.load(&counts, Axes::Z, 5.0).unwrap();
        readings.push(n * 10, &frame);
    }
    let kept: Vec<_> = readings.driving().map(|(t, all)| (t, all[3][3])).collect();
    assert!((8..=16).contains(&kept.len()), "{}", kept.len());
    assert_eq!(kept[0], (0, 0));
    assert!(kept.iter().all(|(t, v)| *t == u64::from(*v) * 10));
    assert!(kept.windows(2).all(|w| w[1].0 - w[0].0 == kept[1].0));
}
