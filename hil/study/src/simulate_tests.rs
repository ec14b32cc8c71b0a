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
    let outcome = simulate(&protocol, of).unwrap();
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

#[test]
fn no_difference_is_found_as_rarely_as_stated_and_one_that_is_there_by_enough_people() {
    let protocol = load_protocol("roughness").unwrap().value;
    let of = Simulation {
        people: 20,
        seed: 1,
    };
    let found = simulate(&protocol, of).unwrap().ratings.unwrap();
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
    assert!(simulate(&protocol, more).unwrap().ratings.unwrap().power >= POWER);
}

#[test]
fn a_seed_is_one_outcome() {
    let protocol = load_protocol("roughness").unwrap().value;
    let of = |seed| Simulation { people: 8, seed };
    let first = simulate(&protocol, of(3)).unwrap();
    assert_eq!(first, simulate(&protocol, of(3)).unwrap());
    assert_ne!(first, simulate(&protocol, of(4)).unwrap());
}

#[test]
fn a_group_needs_two_people() {
    let protocol = load_protocol("roughness").unwrap().value;
    let of = Simulation { people: 3, seed: 1 };
    assert_eq!(simulate(&protocol, of), Err(StudyError::FewPeople(3)));
}
