//! Tests of `simulate.rs`.

use palpate_files::{ThresholdMethod, load_protocol};

use super::*;

fn thresholds_by(method: ThresholdMethod) -> Thresholds {
    let mut protocol = load_protocol("thresholds").unwrap().value;
    protocol.absolute_threshold.as_mut().unwrap().method = method;
    let of = Simulation {
        people: 200,
        seed: 1,
    };
    let outcome = simulate(&protocol, of, &Known::default()).unwrap();
    assert_eq!(outcome.ratings, None);
    outcome.thresholds.unwrap()
}

#[test]
fn thresholds_come_back_and_their_intervals_hold_them() {
    for method in [ThresholdMethod::QuestPlus, ThresholdMethod::Staircase] {
        let found = thresholds_by(method);
        println!("{method:?}: {found:?}");
        assert_eq!(found.thresholds, 1600);
        assert!(found.threshold_error_median < 0.1, "{method:?}: {found:?}");
        assert!(
            (0.90..=0.98).contains(&found.coverage),
            "{method:?}: {found:?}"
        );
        assert!(found.interval_db_median > 1.0, "{method:?}: {found:?}");
    }
}

/// The session that a wearer's file is made of is the shorter one.
#[test]
fn thresholds_of_a_wearer_come_back_as_well() {
    let mut protocol = load_protocol("wearer").unwrap().value;
    (protocol.localisation, protocol.difference) = (None, None);
    let of = Simulation {
        people: 200,
        seed: 1,
    };
    let outcome = simulate(&protocol, of, &Known::default()).unwrap();
    let found = outcome.thresholds.unwrap();
    println!("{found:?}");
    assert!(found.threshold_error_median < 0.1, "{found:?}");
    assert!((0.90..=0.98).contains(&found.coverage), "{found:?}");
}

#[test]
fn no_difference_is_found_as_rarely_as_stated_and_one_that_is_there_by_enough_people() {
    let protocol = load_protocol("roughness").unwrap().value;
    let of = Simulation {
        people: 20,
        seed: 1,
    };
    let found = simulate(&protocol, of, &Known::default())
        .unwrap()
        .ratings
        .unwrap();
    println!("{found:?}");
    assert!(
        (0.03..=0.065).contains(&found.false_positive_rate),
        "{found:?}"
    );
    // Two means of ten people with a standard deviation of 0.85 each: a difference of 1.0 is found by some 70 %.
    assert!((0.55..0.85).contains(&found.power), "{found:?}");
    let enough = found.people_for_power.unwrap();
    assert!((20..40).contains(&enough), "{found:?}");
    let more = Simulation {
        people: enough + 6,
        ..of
    };
    assert!(
        simulate(&protocol, more, &Known::default())
            .unwrap()
            .ratings
            .unwrap()
            .power
            >= POWER
    );
}

#[test]
fn a_seed_is_one_outcome() {
    let protocol = load_protocol("roughness").unwrap().value;
    let of = |seed| Simulation { people: 8, seed };
    let first = simulate(&protocol, of(3), &Known::default()).unwrap();
    assert_eq!(
        first,
        simulate(&protocol, of(3), &Known::default()).unwrap()
    );
    assert_ne!(
        first,
        simulate(&protocol, of(4), &Known::default()).unwrap()
    );
}

#[test]
fn a_group_needs_two_people() {
    let protocol = load_protocol("roughness").unwrap().value;
    let of = Simulation { people: 3, seed: 1 };
    assert_eq!(
        simulate(&protocol, of, &Known::default()),
        Err(StudyError::FewPeople(3))
    );
}

#[test]
fn every_task_comes_back_from_people_who_answer_it() {
    let mut protocol = load_protocol("wearer").unwrap().value;
    let other = load_protocol("felt-paths").unwrap().value;
    protocol.conditions = other.conditions;
    protocol.drawing = other.drawing;
    protocol.absolute_threshold = None;
    let task = protocol.difference.as_mut().unwrap();
    task.wires = vec![0, 1, 2, 3];
    task.trials = 60;
    protocol.matching.as_mut().unwrap().trials = 40;
    let circle = |n: i32| {
        let angle = f64::from(n) / 50.0 * std::f64::consts::TAU;
        [
            f64::from(n) / 50.0 * 4.0,
            8.0 * angle.cos(),
            8.0 * angle.sin(),
        ]
    };
    let path: Vec<_> = (0..=50).map(circle).collect();
    let names = protocol
        .conditions
        .iter()
        .map(|c| (c.name.clone(), path.clone()));
    let known = Known {
        paths: names.collect(),
        wires_mm: vec![
            [0.0, -14.25],
            [0.0, -4.75],
            [0.0, 4.75],
            [0.0, 14.25],
            [-11.0, -4.75],
            [-11.0, 4.75],
            [11.0, -4.75],
            [11.0, 4.75],
        ],
        ..Known::default()
    };
    let of = Simulation {
        people: 100,
        seed: 1,
    };
    let found = simulate(&protocol, of, &known).unwrap();
    println!("{found:?}");
    assert_eq!(found.thresholds, None);
    for levels in [found.difference.unwrap(), found.matching.unwrap()] {
        assert!((0.90..=0.99).contains(&levels.coverage), "{levels:?}");
        assert!(levels.error_db_median < 1.6, "{levels:?}");
    }
    // A bias of 1 mm and noise of 3 mm on each axis between wires 9.5 and 11 mm apart.
    let places = found.localisation.unwrap();
    assert!((0.75..0.95).contains(&places.correct), "{places:?}");
    assert!((3.0..4.5).contains(&places.error_mm_median), "{places:?}");
    // Noise of 1.5 mm on each axis, a bias of 1 mm, a tenth of 8 mm.
    let drawings = found.drawing.unwrap();
    assert!(
        (1.8..3.2).contains(&drawings.rmse_mm_median),
        "{drawings:?}"
    );
    assert!(
        drawings.frechet_mm_median > drawings.rmse_mm_median,
        "{drawings:?}"
    );
    assert!((0.2..0.6).contains(&drawings.breaks_mean), "{drawings:?}");
}

#[test]
fn no_preference_is_found_as_rarely_as_stated() {
    let protocol = load_protocol("illusions").unwrap().value;
    let of = Simulation {
        people: 20,
        seed: 1,
    };
    let found = simulate(&protocol, of, &Known::default())
        .unwrap()
        .choice
        .unwrap();
    println!("{found:?}");
    assert!(found.false_positive_rate <= 0.065, "{found:?}");
    assert!(found.power > 0.5, "{found:?}");
    assert!(found.people_for_power.unwrap() < 40, "{found:?}");
}

/// A drawing follows what a run lets the person feel: its place, and its breaks.
#[test]
fn drawings_follow_what_is_felt() {
    let mut protocol = load_protocol("felt-paths").unwrap().value;
    let task = protocol.drawing.as_mut().unwrap();
    task.simulated.noise_mm = 0.0;
    (task.simulated.bias_mm.sd, task.simulated.scale.sd) = (0.0, 0.0);
    let along = |n: u32, y: f64| [f64::from(n) * 0.1, f64::from(n) - 10.0, y];
    let path: Vec<_> = (0..=20).map(|n| along(n, 0.0)).collect();
    let names = || protocol.conditions.iter().map(|c| c.name.clone());
    let known = |felt: &[Option<f64>]| {
        let sensed = felt.iter().zip(0..).map(|(y, n)| {
            let [t_s, x, _] = along(n, 0.0);
            let place_mm = y.map(|y| [x, y]);
            crate::people::Sensed { t_s, place_mm }
        });
        let sensed: Vec<_> = sensed.collect();
        Known {
            wires_mm: Vec::new(),
            paths: names().map(|name| (name, path.clone())).collect(),
            felt: names()
                .map(|name| (Stimulus::Condition(name), sensed.clone()))
                .collect(),
            ..Known::default()
        }
    };
    let of = Simulation { people: 2, seed: 1 };
    let drawn = |felt: &[Option<f64>]| simulate(&protocol, of, &known(felt)).unwrap().drawing;
    // Everything is felt 2 mm beside the path, without a break.
    let beside = drawn(&[Some(2.0); 21]).unwrap();
    assert!((beside.rmse_mm_median - 2.0).abs() < 0.05, "{beside:?}");
    assert!(beside.breaks_mean.abs() < 1e-9, "{beside:?}");
    // Two onsets in the middle stay below the threshold.
    let mut felt = [Some(0.0); 21];
    (felt[7], felt[14]) = (None, None);
    let broken = drawn(&felt).unwrap();
    assert!((broken.breaks_mean - 2.0).abs() < 1e-9, "{broken:?}");
    // Nothing is felt: one point, which is no path to compare.
    assert_eq!(drawn(&[None; 21]), None);
}

/// A place is where a run lets the person feel the wire, and any wire's where nothing is felt.
#[test]
fn people_point_at_what_is_felt() {
    let mut protocol = load_protocol("wearer").unwrap().value;
    (protocol.absolute_threshold, protocol.difference) = (None, None);
    protocol.matching = None;
    let task = protocol.localisation.as_mut().unwrap();
    (task.simulated.noise_mm, task.simulated.slips) = (0.0, 0.0);
    (task.simulated.bias_mm.mean, task.simulated.bias_mm.sd) = (0.0, 0.0);
    let level_db = task.level_db;
    let wires_mm: Vec<_> = (0..8).map(|n| [10.0 * f64::from(n), 0.0]).collect();
    let places = |place: &dyn Fn([f64; 2]) -> Option<[f64; 2]>| {
        let felt = (0..).zip(&wires_mm).map(|(wire, at)| {
            let onset = |n| crate::people::Sensed {
                t_s: 0.1 * f64::from(n),
                place_mm: place(*at),
            };
            let stimulus = Stimulus::Wire { wire, level_db };
            (stimulus, (0..3).map(onset).collect())
        });
        let known = Known {
            wires_mm: wires_mm.clone(),
            felt: felt.collect(),
            ..Known::default()
        };
        let of = Simulation {
            people: 40,
            seed: 1,
        };
        simulate(&protocol, of, &known)
            .unwrap()
            .localisation
            .unwrap()
    };
    let there = places(&Some);
    assert_eq!((there.correct, there.error_mm_median), (1.0, 0.0));
    let beside = places(&|[x, y]| Some([x + 3.0, y + 4.0]));
    assert_eq!((beside.correct, beside.error_mm_median), (1.0, 5.0));
    // 960 guesses among eight wires: a share of 1/8 with a deviation of 0.011.
    let nowhere = places(&|_| None);
    assert!((nowhere.correct - 0.125).abs() < 0.045, "{nowhere:?}");
}

/// Thresholds and matches follow what a run's person feels of each wire: a wire that is felt 4 dB less has both 4 dB higher.
#[test]
fn levels_follow_what_the_person_of_the_run_feels() {
    let mut protocol = load_protocol("wearer").unwrap().value;
    let task = protocol.absolute_threshold.as_mut().unwrap();
    (task.simulated.threshold_db.sd, task.simulated.wire_sd_db) = (0.0, 0.0);
    let task = protocol.matching.as_mut().unwrap();
    task.simulated.level_db.sd = 0.0;
    let growth = |weaker: f64| {
        let over = |level: f64, off: f64| [level, 1.5 * level + 18.0 - off];
        let wire = |n: u16| {
            let off = if n == 5 { weaker } else { 0.0 };
            (
                n,
                (0..=20)
                    .map(|n| over(2.0 * f64::from(n) - 40.0, off))
                    .collect(),
            )
        };
        Known {
            growth: (0..8).map(wire).collect(),
            ..Known::default()
        }
    };
    let levels = |known: &Known| {
        let person = Person::new(&protocol, 1, 1, known);
        let of = |task| {
            person.felt[&task]
                .iter()
                .map(|f| f.threshold)
                .collect::<Vec<f64>>()
        };
        (of(TaskKind::AbsoluteThreshold), of(TaskKind::Matching))
    };
    let (thresholds, matches) = levels(&growth(0.0));
    assert!(
        thresholds.iter().all(|t| (t + 12.0).abs() < 1e-9),
        "{thresholds:?}"
    );
    assert!(
        matches.iter().all(|t| (t + 8.0).abs() < 1e-9),
        "{matches:?}"
    );
    // 6 dB less over threshold are 4 dB of drive where 1 dB of drive makes 1.5 dB.
    let (thresholds, matches) = levels(&growth(6.0));
    let weak: Vec<f64> = thresholds.iter().map(|t| t + 12.0).collect();
    assert!(
        (weak[5] - 4.0).abs() < 1e-9 && weak[4].abs() < 1e-9,
        "{weak:?}"
    );
    // Wire 5 is the fifth that is matched with wire 3.
    assert!(
        (matches[4] + 4.0).abs() < 1e-9 && (matches[0] + 8.0).abs() < 1e-9,
        "{matches:?}"
    );
    // Beyond what was played levels go on, and a threshold that no level reaches stays at the end of the range.
    let (silent, _) = levels(&growth(200.0));
    assert!((silent[5] + 2.0).abs() < 1e-9, "{silent:?}");
}
