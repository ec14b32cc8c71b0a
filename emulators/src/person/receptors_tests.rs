//! Tests of `receptors.rs`.

use super::*;

fn train(rate_hz: f64, seconds: f64, um: f64) -> Vec<Kick> {
    let count = (rate_hz * seconds) as usize;
    let at = |n: usize| n as f64 / rate_hz;
    (0..count).map(|n| Kick { at_s: at(n), um }).collect()
}

fn one(rate_hz: f64, um: f64) -> Intensity {
    Receptors::fitted(1.2).intensity(&[train(rate_hz, 1.0, um)], 1.0)
}

#[test]
fn the_perceivers_threshold_is_the_pacinian_channels() {
    assert_eq!(one(196.89, 1.15), Intensity::default());
    let above = one(196.89, 1.25);
    assert!(above.pacinian > 1.0 && above.pacinian < 1.08, "{above:?}");
    assert!(above.meissner <= 0.0);
}

#[test]
fn thresholds_rise_on_both_sides_by_their_slopes() {
    let p = Receptors::fitted(1.2).pacinian;
    let ratio = |hz: f64| p.threshold(hz) / p.threshold(250.0);
    assert!((ratio(125.0) - 4.0).abs() < 1e-9 && (ratio(500.0) - 4.0).abs() < 1e-9);
    let r = Receptors::fitted(1.2);
    let above = 20.0 * libm::log10(r.meissner.threshold(40.0) / p.threshold(250.0));
    assert!((above - 20.0).abs() < 1e-9);
}

/// Slow pulses flutter, fast ones vibrate; and intensity grows with amplitude by the exponent.
#[test]
fn slow_trains_move_towards_meissners_corpuscles() {
    // Over a second at once: the beginning and the end of a train, which a shorter stretch is full of, are slow.
    let share = |hz: f64| {
        let i = Receptors::fitted(1.2).stretch(&[train(hz, 1.0, 60.0)], 1.0);
        i.meissner / i.pacinian
    };
    let (slow, middle, fast) = (share(40.0), share(100.0), share(196.89));
    assert!(
        slow > 2.0 * middle && middle > 1.3 * fast,
        "{slow} {middle} {fast}"
    );
    let twice = one(100.0, 120.0).felt() / one(100.0, 60.0).felt();
    assert!((twice - libm::pow(2.0, 0.9)).abs() < 1e-9, "{twice}");
}

/// What the weave of a moving contact's texture does: pulses of a burst are left out, the others grow by the root.
#[test]
fn a_thinned_out_burst_that_is_widened_feels_as_strong() {
    let receptors = Receptors::fitted(1.2);
    let felt = |periods: &[u32], um: f64| {
        let at = |n: &u32| f64::from(*n) * 5.079_04e-3;
        let kicks = periods.iter().map(|n| Kick { at_s: at(n), um }).collect();
        receptors.intensity(&[kicks], 0.0585).felt()
    };
    let whole = felt(&[0, 1, 2, 3, 4, 5, 6], 10.0);
    for left in [
        &[0, 1, 2, 4, 5][..],
        &[0, 1, 3, 4, 6],
        &[0, 2, 4, 6],
        &[0, 3, 6],
    ] {
        let gain = libm::sqrt(7.0 / left.len() as f64);
        let (widened, plain) = (felt(left, 10.0 * gain) / whole, felt(left, 10.0) / whole);
        println!(
            "{} pulses: {widened:.2} widened, {plain:.2} not",
            left.len()
        );
        assert!(
            widened > 0.9 && widened < 1.1 && plain < 0.9,
            "{widened} {plain}"
        );
    }
}

#[test]
fn the_weaker_channel_counts_half_and_only_the_pacinian_one_adds_up_over_wires() {
    let i = Intensity {
        pacinian: 3.0,
        meissner: 4.0,
    };
    assert!((i.felt() - 5.5).abs() < 1e-12);
    let receptors = Receptors::fitted(1.2);
    let wire = train(40.0, 1.0, 60.0);
    let alone = receptors.intensity(std::slice::from_ref(&wire), 1.0);
    let four = receptors.intensity(&[wire.clone(), wire.clone(), wire.clone(), wire], 1.0);
    assert!((four.pacinian / alone.pacinian - libm::pow(2.0, 0.9)).abs() < 1e-9);
    assert!((four.meissner - alone.meissner).abs() < 1e-12);
}
