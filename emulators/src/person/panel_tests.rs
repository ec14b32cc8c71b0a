//! Tests of `panel.rs`.

use super::*;

fn ends() -> ScaleEnds {
    let at = |coarseness, slowness| Sensation {
        coarseness: Some(coarseness),
        slowness: Some(slowness),
    };
    ScaleEnds {
        smooth: at(-2.0, -3.0),
        rough: at(0.0, -1.5),
    }
}

#[test]
fn ratings_are_seeded_whole_and_spread_as_stated() {
    let panel = Panel::new(1);
    assert_eq!(
        panel.bare("wood", 3, [6.0, 2.0, 2.0]),
        panel.bare("wood", 3, [6.0, 2.0, 2.0])
    );
    let mut within = [0, 0];
    for seed in 0..50 {
        let panel = Panel::new(seed);
        for subject in 0..SUBJECTS {
            let of = |repeat| panel.bare("a", subject + SUBJECTS * repeat, [3.5; 3]);
            let ratings: Vec<[u8; 3]> = (0..REPEATS).map(of).collect();
            for d in 0..3 {
                let all = ratings.iter().map(|r| r[d]);
                let range = all.clone().max().unwrap() - all.min().unwrap();
                assert!((1..=6).contains(&ratings[0][d]));
                within[usize::from(range > 1)] += 1;
            }
        }
    }
    // "Deviations were typically within one rating."
    assert!(within[0] > 4 * within[1], "{within:?}");
}

/// Over many seeds the mean follows what is felt, and friction spreads most.
#[test]
fn ratings_follow_what_is_felt() {
    let mean = |part: f64| -> [f64; 2] {
        let between = |low: Option<f64>, high: Option<f64>| {
            low.zip(high).map(|(low, high)| low + part * (high - low))
        };
        let (smooth, rough) = (ends().smooth, ends().rough);
        let felt = Sensation {
            coarseness: between(smooth.coarseness, rough.coarseness),
            slowness: between(smooth.slowness, rough.slowness),
        };
        let mut sums = [0.0; 2];
        for seed in 0..200 {
            let rated = Panel::new(seed).display("a", 0, felt, &ends());
            sums = [sums[0] + f64::from(rated[0]), sums[1] + f64::from(rated[1])];
        }
        sums.map(|s| s / 200.0)
    };
    let (smooth, middle, rough) = (mean(0.0), mean(0.5), mean(1.0));
    for d in 0..2 {
        assert!(smooth[d] < 1.8 && rough[d] > 5.2, "{smooth:?} {rough:?}");
        assert!((middle[d] - 3.5).abs() < 0.3, "{middle:?}");
    }
}

#[test]
fn what_is_not_felt_is_rated_in_the_middle() {
    let nothing = Sensation::default();
    let mean: f64 = (0..400)
        .map(|seed| f64::from(Panel::new(seed).display("a", 0, nothing, &ends())[0]))
        .sum();
    assert!((mean / 400.0 - 3.5).abs() < 0.15);
}

#[test]
fn pulses_of_a_wire_are_as_far_apart_as_they_are() {
    let at =
        |all: &[f64]| -> Vec<Kick> { all.iter().map(|&at_s| Kick { at_s, um: 1.0 }).collect() };
    let found = apart_s(&[at(&[0.0, 0.01, 0.05]), at(&[0.0, 0.9])]).unwrap();
    assert!((found - 0.02).abs() < 1e-12, "{found}");
    assert_eq!(apart_s(&[at(&[0.3]), Vec::new()]), None);
}

#[test]
fn the_delay_from_wire_to_wire_is_found() {
    for delta_s in [0.06, 0.1, 0.16] {
        let bump = |wire: usize| -> Vec<Kick> {
            let middle = 0.1 + delta_s * wire as f64;
            let at = |n: usize| middle + (n as f64 - 4.0) * 0.005;
            (0..9)
                .map(|n| Kick {
                    at_s: at(n),
                    um: 1.0,
                })
                .collect()
        };
        let found = step_s(&[bump(0), bump(1), bump(2)], 1.0).unwrap();
        assert!((found - delta_s).abs() < 0.0051, "{delta_s} {found}");
    }
    assert_eq!(step_s(&[Vec::new(), Vec::new()], 1.0), None);
    assert_eq!(step_s(&[], 1.0), None);
}

/// At the ends of each scale, in the middle of it by ratios (by differences for friction), and past them.
#[test]
fn a_bare_finger_feels_the_surfaces_own_properties() {
    let surface = |stiffness: f64, [relief, wavelength]: [f64; 2], friction: f64| SurfaceTexture {
        name: "a".to_owned(),
        stiffness_n_per_mm: stiffness,
        relief_mm: relief,
        wavelength_mm: wavelength,
        octaves: 1.0,
        friction,
    };
    let near = |surface: SurfaceTexture, wanted: [f64; 3]| {
        for (felt, wanted) in bare_finger(&surface).into_iter().zip(wanted) {
            assert!((felt - wanted).abs() < 1e-9, "{surface:?}: {felt} {wanted}");
        }
    };
    near(surface(1.0, [0.005, 5.0], 0.3), [1.0; 3]);
    near(surface(100.0, [0.35, 5.0], 1.5), [6.0; 3]);
    let ends = (felt_roughness(0.005, 5.0), felt_roughness(0.35, 5.0));
    // Skin touches the ground of this relief, and it is in the middle of the scale.
    let middle = (ends.0 * ends.1).sqrt();
    near(surface(10.0, [middle, 1.0], 0.9), [3.5; 3]);
    near(surface(1e9, [0.0, 1.0], f64::INFINITY), [6.0, 1.0, 6.0]);
}

#[test]
fn coarser_waves_are_rougher_where_skin_cannot_reach_the_ground_and_smoother_where_it_does() {
    let of = felt_roughness;
    let low = [0.5, 1.0, 2.0, 5.0].map(|wavelength| of(0.01, wavelength));
    assert!(low.is_sorted_by(|a, b| a > b), "{low:?}");
    let high = [0.5, 1.0, 2.0, 5.0].map(|wavelength| of(0.3, wavelength));
    assert!(high.is_sorted(), "{high:?}");
    // Between them an inverted U: the peak is where the skin begins to touch.
    let peak = 0.05 / of(1.0, 1.0);
    for wavelength in [0.5 * peak, 0.9 * peak, 1.1 * peak, 2.0 * peak] {
        assert!(of(0.05, wavelength) < of(0.05, peak), "{wavelength}");
    }
    // Deeper than skin reaches, a higher relief is no rougher; else it is, in proportion.
    assert_eq!(of(0.2, 1.0).to_bits(), of(0.3, 1.0).to_bits());
    assert!((of(0.02, 1.0) / of(0.01, 1.0) - 2.0).abs() < 1e-12);
}
