//! What every law keeps, whatever the array and the contact; and what the default illusion promises.

use palpate_core::illusion::{
    Display, DisplayError, DisplayWire, Distances, IllusionError, IllusionModel, Mixer,
    ModelSettings, ShapeChoice, Sharing, Surface, Target, build,
};
use palpate_core::units::{Board, Channel, Point};
use palpate_records::trace::{Event, event};
use palpate_tests::felt::{PATHS, Worn, current, path_on, person};
use proptest::prelude::*;

/// Wires at these places, on as many boards as they need.
fn display(places: &[(f32, f32)]) -> Result<Display, DisplayError> {
    let wire = |(i, &(x, y)): (usize, &(f32, f32))| DisplayWire {
        place: Point::new(x, y),
        board: Board((i / 8) as u8),
        channel: Channel((i % 8) as u8),
    };
    Display::new(&places.iter().enumerate().map(wire).collect::<Vec<_>>())
}

const THIMBLE: [(f32, f32); 8] = [
    (0.0, -14.25),
    (0.0, -4.75),
    (0.0, 4.75),
    (0.0, 14.25),
    (-11.0, -4.75),
    (-11.0, 4.75),
    (11.0, -4.75),
    (11.0, 4.75),
];

fn grid() -> Vec<(f32, f32)> {
    (0..12)
        .map(|i| (9.0 * (i % 4) as f32 - 13.5, 9.0 * (i / 4) as f32 - 9.0))
        .collect()
}

const LINE: [(f32, f32); 3] = [(-6.5, 0.0), (0.0, 0.0), (6.5, 0.0)];

/// Every law with every kind of distance it knows.
fn settings() -> Vec<ModelSettings> {
    let kinds = [Distances::Axes, Distances::Plane, Distances::Space];
    let each = IllusionModel::ALL.into_iter().flat_map(|model| {
        kinds.map(|distances| ModelSettings {
            model,
            distances: Some(distances),
            ..ModelSettings::default()
        })
    });
    let thimble = display(&THIMBLE).unwrap();
    let known: Vec<_> = each
        .filter(|s| {
            build(&thimble, s)
                .map_err(|e| assert_eq!(e, IllusionError::Distances))
                .is_ok()
        })
        .collect();
    assert_eq!(known.len(), 17, "laws by distances");
    known
}

fn activation(display: &Display, settings: &ModelSettings, at: Point) -> Vec<f32> {
    let mut out = vec![f32::NAN; display.wires().len()];
    build(display, settings).unwrap().activate(at, &mut out);
    out
}

/// Scattered wires at least 3 mm apart, no four of them nearly on one circle by chance of rounding.
fn scattered() -> impl Strategy<Value = Vec<(f32, f32)>> {
    prop::collection::vec((-20.0f32..20.0, -20.0f32..20.0), 4..14).prop_map(|places| {
        let mut kept: Vec<(f32, f32)> = vec![(-21.0, -22.0), (22.0, -20.0), (1.0, 21.5)];
        for (x, y) in places {
            if kept.iter().all(|(u, v)| (x - u).hypot(y - v) > 3.0) {
                kept.push((x, y));
            }
        }
        kept
    })
}

fn place() -> impl Strategy<Value = Point> {
    (-25.0f32..25.0, -25.0f32..25.0).prop_map(|(x, y)| Point::new(x, y))
}

/// How far activations may move over 0.01 mm. Shares move by 0.345 a millimetre at most on these arrays: on the middle wire
/// of the line by 1 / 6.5 along it and 1 / 3.25 away from it, the margin being half a gap. A root of a share is steep where
/// the share begins, hence the power.
fn modulus(model: IllusionModel) -> Option<f32> {
    let share = (1.0f32 / 6.5).hypot(1.0 / 3.25) * 0.01;
    match model {
        IllusionModel::Phantom => Some(0.01),
        IllusionModel::Linear => Some(share + 1e-4),
        IllusionModel::Square => Some(2.0 * share + 1e-4),
        IllusionModel::Energy => Some(share.sqrt() + 4e-3),
        IllusionModel::Balanced => Some(2.0 * share.powf(0.65) + 2e-3),
        IllusionModel::Inverse => Some(3.0 * share.powf(0.65) + 2e-3),
        IllusionModel::Gaussian => Some(0.01),
        // These two jump by nature.
        IllusionModel::ThreeNearest | IllusionModel::Nearest => None,
    }
}

/// Whether activations become others by more than rounding within 0.01 mm: where a law jumps, and just beside a wire.
fn jumps_near(display: &Display, settings: &ModelSettings, at: Point) -> bool {
    let here = activation(display, settings, at);
    (0u8..8).any(|eighth| {
        let (sin, cos) = (f32::from(eighth) * std::f32::consts::FRAC_PI_4).sin_cos();
        let near = Point::new(at.x + 0.01 * cos, at.y + 0.01 * sin);
        let there = activation(display, settings, near);
        here.iter().zip(&there).any(|(a, b)| (a - b).abs() > 5e-3)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn activations_stay_within_0_and_1_and_are_1_on_a_wire(places in scattered(), at in place(), on in 0usize..3) {
        let display = display(&places).unwrap();
        for settings in settings() {
            let a = activation(&display, &settings, at);
            prop_assert!(a.iter().all(|a| (0.0..=1.0).contains(a)), "{settings:?} {a:?}");
            // On a wire the wire has everything; only the bell reaches its neighbours there, and on an
            // uneven array (5.2) over axes, whose D is the whole array's.
            let wire = display.wires()[on].place;
            let a = activation(&display, &settings, wire);
            prop_assert!((a[on] - 1.0).abs() < 1e-5, "{settings:?} on wire {on}: {a:?}");
            let alone = !matches!(settings.model, IllusionModel::Gaussian)
                && settings.distances != Some(Distances::Axes);
            if alone {
                let others = a.iter().enumerate().filter(|(i, _)| *i != on);
                prop_assert!(others.clone().all(|(_, a)| *a == 0.0), "{settings:?} on wire {on}: {a:?}");
            }
        }
    }

    #[test]
    fn no_law_but_the_two_that_jump_by_nature_jumps(x in -16.0f32..16.0, y in -16.0f32..16.0, turn in 0.0f32..6.3) {
        let at = Point::new(x, y);
        let near = Point::new(x + 0.01 * turn.cos(), y + 0.01 * turn.sin());
        for places in [&THIMBLE[..], &grid(), &LINE] {
            let display = display(places).unwrap();
            for settings in settings() {
                let Some(bound) = modulus(settings.model) else { continue };
                let (a, b) = (activation(&display, &settings, at), activation(&display, &settings, near));
                let worst = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
                prop_assert!(worst <= bound, "{settings:?} at {at:?}: {worst} > {bound}");
            }
        }
    }

    /// Mirrored contact, mirrored activations: no law prefers a side.
    #[test]
    fn laws_have_the_symmetries_of_the_array(at in place(), flip in 0usize..3) {
        let turn = |p: Point| match flip {
            0 => Point::new(-p.x, p.y),
            1 => Point::new(p.x, -p.y),
            _ => Point::new(-p.x, -p.y),
        };
        for places in [&THIMBLE[..], &grid(), &LINE] {
            let display = display(places).unwrap();
            let image = |i: usize| {
                let to = turn(display.wires()[i].place);
                display.wires().iter().position(|w| w.place.distance(to) < 1e-3).unwrap()
            };
            for settings in settings() {
                if build(&display, &settings).is_err() { continue }
                let (a, b) = (activation(&display, &settings, at), activation(&display, &settings, turn(at)));
                // There rounding decides on which side a contact is.
                if modulus(settings.model).is_none() && jumps_near(&display, &settings, at) { continue }
                for (i, a) in a.iter().enumerate() {
                    // Where a share begins, rounding moves its root by 1e-3.
                    prop_assert!((a - b[image(i)]).abs() < 5e-3, "{settings:?} {i} at {at:?}");
                }
            }
        }
    }

    #[test]
    fn the_order_of_wires_means_nothing(places in scattered(), at in place(), shift in 1usize..10) {
        let n = places.len();
        let turned: Vec<_> = (0..n).map(|i| places[(i + shift) % n]).collect();
        let (plain, turned) = (display(&places).unwrap(), display(&turned).unwrap());
        for settings in settings() {
            let (a, b) = (activation(&plain, &settings, at), activation(&turned, &settings, at));
            for (i, b) in b.iter().enumerate() {
                prop_assert!((a[(i + shift) % n] - b).abs() < 5e-3, "{settings:?}");
            }
        }
    }

    /// Whatever the rule: every wire within full drive, all together within the sum of the contacts alone.
    #[test]
    fn several_contacts_have_bounded_energy(
        contacts in prop::collection::vec((place(), 0.0f32..=1.0), 0..6),
        onset in 0u64..100,
    ) {
        let display = display(&THIMBLE).unwrap();
        let targets: Vec<Target> = contacts.iter().map(|&(place, weight)| Target { place, weight }).collect();
        let energy = |a: &[f32]| a.iter().map(|a| a * a).sum::<f32>();
        for settings in settings() {
            for sharing in Sharing::ALL {
                let mut mixer = Mixer::new(build(&display, &settings).unwrap(), sharing, 8);
                let alone: f32 = targets.iter().map(|t| energy(mixer.activate(std::slice::from_ref(t)))).sum();
                let a = mixer.activate(mixer_slice(&mixer, &targets, onset).as_slice()).to_vec();
                prop_assert!(a.iter().all(|a| (0.0..=1.0).contains(a)));
                prop_assert!(energy(&a) <= alone + 1e-4, "{settings:?} {sharing:?}");
            }
        }
    }

    #[test]
    fn a_contact_far_outside_or_nowhere_is_no_surprise(x in prop::num::f32::ANY, y in prop::num::f32::ANY) {
        for places in [&THIMBLE[..], &LINE] {
            let display = display(places).unwrap();
            for settings in settings() {
                if build(&display, &settings).is_err() { continue }
                let a = activation(&display, &settings, Point::new(x, y));
                prop_assert!(a.iter().all(|a| (0.0..=1.0).contains(a)), "{settings:?} {a:?}");
            }
        }
    }
}

fn mixer_slice(mixer: &Mixer, targets: &[Target], onset: u64) -> Vec<Target> {
    mixer.rendered(targets, onset).to_vec()
}

#[test]
fn degenerate_arrays_are_refused_by_name() {
    let one = display(&[(1.0, 2.0)]).unwrap();
    let line = display(&LINE).unwrap();
    for settings in settings() {
        let refused = build(&one, &settings).err();
        match settings.model {
            IllusionModel::Nearest => assert_eq!(refused, None),
            _ => assert_eq!(refused, Some(IllusionError::OneWire), "{settings:?}"),
        }
        let refused = build(&line, &settings).err();
        match settings.model {
            IllusionModel::ThreeNearest => assert_eq!(refused, Some(IllusionError::InLine)),
            _ => assert_eq!(refused, None, "{settings:?}"),
        }
    }
    let twice = display(&[(0.0, 0.0), (5.0, 0.0), (0.0, 0.0)]);
    assert_eq!(twice, Err(DisplayError::Coincident(0, 2)));
}

/// s_x and s_y of (5.2) act along their own axis alone.
#[test]
fn the_phantom_law_has_a_shape_for_each_axis() {
    let thimble = display(&THIMBLE).unwrap();
    let at = |shape: ShapeChoice, place: Point| {
        let settings = ModelSettings {
            model: IllusionModel::Phantom,
            shape,
            ..ModelSettings::default()
        };
        let law = build(&thimble, &settings).unwrap();
        let mut found = vec![0.0; thimble.wires().len()];
        law.activate(place, &mut found);
        found
    };
    let wire = thimble.wires()[0].place;
    let (beside, above) = (
        Point::new(wire.x + 2.0, wire.y),
        Point::new(wire.x, wire.y + 2.0),
    );
    let both = ShapeChoice::Axes(1.0, 4.0);
    assert_eq!(at(both, beside), at(ShapeChoice::Factor(1.0), beside));
    assert_eq!(at(both, above), at(ShapeChoice::Factor(4.0), above));
    assert_ne!(at(both, above), at(ShapeChoice::Factor(1.0), above));
    let settings = ModelSettings {
        model: IllusionModel::Balanced,
        shape: both,
        ..ModelSettings::default()
    };
    assert_eq!(build(&thimble, &settings).err(), Some(IllusionError::Shape));
}

#[test]
fn settings_that_no_law_knows_are_refused() {
    let thimble = display(&THIMBLE).unwrap();
    let refused = |settings: ModelSettings| build(&thimble, &settings).err();
    let of = |model: IllusionModel| ModelSettings {
        model,
        ..ModelSettings::default()
    };
    for shape in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let shape = ShapeChoice::Factor(shape);
        let settings = ModelSettings {
            shape,
            ..of(IllusionModel::Phantom)
        };
        assert_eq!(refused(settings), Some(IllusionError::Shape));
    }
    let shape = ShapeChoice::Factor(1.0);
    let settings = ModelSettings {
        shape,
        ..of(IllusionModel::Energy)
    };
    assert_eq!(refused(settings), Some(IllusionError::Shape));
    let shape = ShapeChoice::Flat;
    let settings = ModelSettings {
        shape,
        ..of(IllusionModel::Gaussian)
    };
    assert_eq!(refused(settings), Some(IllusionError::Shape));
    let settings = ModelSettings {
        margin: Some(0.0),
        ..of(IllusionModel::Linear)
    };
    assert_eq!(refused(settings), Some(IllusionError::Margin));
}

/// Around the finger a chord is shorter than the arc: a law over space reaches further than one over the plane.
#[test]
fn distances_through_space_follow_the_finger() {
    let finger = Surface::Finger {
        radius_mm: 8.0,
        tip_mm: 6.0,
    };
    let worn = display(&THIMBLE).unwrap().with_surface(finger);
    let at = Point::new(5.5, 0.0);
    let by = |distances: Distances| {
        let settings = ModelSettings {
            model: IllusionModel::Gaussian,
            distances: Some(distances),
            ..ModelSettings::default()
        };
        activation(&worn, &settings, at)[1]
    };
    assert!(by(Distances::Space) > by(Distances::Plane));
}

/// The default illusion at the published drive against (5.2) with s = 1, by the energy centroid.
#[test]
fn the_default_holds_where_the_thesis_breaks() {
    let bench = palpate_files::Setup::load("sphere-along", "thesis").unwrap();
    let thimble = palpate_run::plan::display(&bench).unwrap();
    let worn = |model: IllusionModel| {
        let settings = ModelSettings {
            model,
            ..ModelSettings::default()
        };
        Worn::new(
            &thimble,
            &settings,
            person().unwrap(),
            current("thesis").unwrap(),
        )
        .unwrap()
    };
    let (mut ours, mut theirs) = (worn(IllusionModel::default()), worn(IllusionModel::Phantom));
    for scene in PATHS {
        let path = path_on(scene, &thimble).unwrap();
        let (mine, published) = (ours.score(&path).unwrap(), theirs.score(&path).unwrap());
        assert!(
            mine.energy_db.0 > -1.0 && mine.energy_db.1 < 1.0,
            "{scene}: {:?}",
            mine.energy_db
        );
        assert!(published.energy_db.0 < -8.0, "{scene}: (5.2) dips");
        // By the amplitude centroid (5.2) is as near: no wire is cut by a threshold of its own.
        let [mine, theirs] = [&mine, &published].map(|score| score.felt[0].errors.unwrap().rmse_um);
        let ratio = mine as f64 / theirs as f64;
        assert!(ratio <= 0.7, "{scene}: {ratio:.2} of (5.2)");
    }
}

/// Strokes take the display at their planned onsets, off the grid, and move it from end to end.
#[test]
fn planned_strokes_are_played() {
    let outcome = super::goldens::shipped("brush-strokes");
    let felt: Vec<_> = outcome
        .trace
        .events
        .iter()
        .filter_map(|e| match *e {
            Event::Felt(event::Felt {
                t_us, target, met, ..
            }) => Some((t_us, target, met.unwrap().level_mdb)),
            _ => None,
        })
        .collect();
    let first: Vec<_> = felt.iter().filter(|f| f.0 < 2_000_000).collect();
    let places: Vec<i32> = first.iter().map(|f| f.1.y).collect();
    assert_eq!(places, [-14_250, -4_750, 4_750, 14_250]);
    assert_eq!(first[0].0, 1_000_000);
    // A stimulus alone is weaker than one in a row of them.
    assert!(felt.len() >= 7 && felt.iter().all(|f| f.2 > -8_000));
    assert_eq!(outcome.summary.limiter_events, 0);
}

#[test]
fn pulses_that_the_burst_row_cuts_are_requested_and_not_applied() {
    let mut setup = palpate_files::Setup::load("rest-on-wire", "emulated").unwrap();
    // So small a current that no row of power or heat has a say.
    setup.bench.value.drive.current_ma = 300.0;
    let illusion = &mut setup.scene.value.illusion;
    illusion.model = IllusionModel::Nearest;
    (illusion.tau_d_ms, illusion.soa_ms) = (Some(70.0), Some(117.0));
    let summary = palpate_run::run(&setup, &palpate_run::Input::Scene, 1)
        .unwrap()
        .summary;
    let requested = summary.requested_energy_db.unwrap();
    let applied = summary.applied_energy_db.unwrap();
    assert!(
        requested.min.abs() < 1e-9 && requested.max.abs() < 1e-9,
        "{requested:?}"
    );
    // 48.8 of 70 ms: ten of fourteen pulses.
    let cut = 10.0 * (10.0_f64 / 14.0).log10();
    assert!((applied.max - cut).abs() < 0.01, "{applied:?}");
    assert!(summary.limiter_events > 0);
}

/// The same promise through the whole loop on the default bench, with the guard in between.
#[test]
fn the_default_holds_on_the_default_bench() {
    for scene in PATHS {
        let summary = super::goldens::shipped(scene).summary;
        let (requested, applied) = (
            summary.requested_energy_db.unwrap(),
            summary.applied_energy_db.unwrap(),
        );
        println!("{scene}: {:?} {applied:?}", summary.felt);
        assert_eq!(requested, applied, "{scene}: no limit is met");
        let felt = &summary.felt;
        // Where the touch begins it is light, and one onset stays below the threshold.
        assert!(felt.breaks <= Some(1), "{scene}");
        assert!(felt.level_db.unwrap().p5 > 1.5, "{scene}: {felt:?}");
        for error in [felt.error_energy_mm, felt.error_amplitude_mm] {
            assert!(error.unwrap().rmse < 1.05, "{scene}: {felt:?}");
        }
        assert_eq!(summary.limiter_events, 0, "{scene}");
    }
}
