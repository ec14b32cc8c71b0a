//! Tests of `laws.rs`.

use palpate_core::contact::Levels;
use palpate_run::build;

use super::*;

#[test]
fn points_differ_and_lie_within_their_ranges() {
    assert_eq!(space::point(0), None);
    let drawn: Vec<Knobs> = (1..200).filter_map(space::point).collect();
    assert_eq!(drawn.len(), 199);
    for (n, knobs) in drawn.iter().enumerate() {
        for (value, range) in knobs.values.iter().zip(space::RANGES) {
            assert!((range.least..=range.most).contains(value), "{n} {knobs:?}");
        }
        assert!(!drawn[..n].contains(knobs), "{n}");
    }
}

#[test]
fn every_law_takes_the_points_that_are_given() {
    for law in IllusionModel::ALL {
        for point in 0..4 {
            let knobs = space::point(point);
            let overrides = space::overrides(law, knobs.as_ref());
            let setup = Setup::load(PATHS[0], BENCH).unwrap().with(&overrides);
            let built = build(&setup.unwrap(), 1, Levels::Off);
            assert!(built.is_ok(), "{} {point}: {:?}", law.name(), built.err());
        }
    }
}

#[test]
fn silence_inside_the_hull_costs_as_much_as_it_is_long() {
    let count = |onsets, unfelt| Count { onsets, unfelt };
    let felt = Felt {
        level_db: 3.0,
        inside_mm: [0.5, 0.75],
        everywhere_mm: 4.0,
        inside: count(80, 20),
        everywhere: count(90, 30),
        taps: 3,
        limited: 0,
    };
    assert!((felt.cost() - 0.75 - UNFELT_MM / 4.0).abs() < 1e-12);
    let still = Felt {
        inside_mm: [f64::INFINITY; 2],
        ..felt
    };
    assert!(still.cost().is_infinite());
    let both = felt.with(Felt {
        level_db: -1.0,
        inside_mm: [1.0, 0.25],
        everywhere_mm: 2.0,
        limited: 2,
        ..felt
    });
    assert_eq!((both.level_db, both.inside_mm), (-1.0, [1.0, 0.75]));
    assert_eq!(
        (both.inside, both.everywhere),
        (count(160, 40), count(180, 60))
    );
    assert_eq!((both.everywhere_mm, both.taps, both.limited), (4.0, 6, 2));
}

/// The contact at rest is inside the hull, so its error counts.
#[test]
fn the_objective_has_a_contact_at_rest() {
    let rest = felt(&setup(REST).unwrap(), CHOOSING[0]).unwrap();
    assert!(
        rest.inside.onsets > 0 && rest.inside == rest.everywhere,
        "{rest:?}"
    );
    assert!(rest.cost().is_finite());
}

/// A search that stops a point early finds what the whole sums find.
#[test]
fn a_point_is_left_early_only_where_it_has_lost() {
    let law = IllusionModel::Nearest;
    let whole = cost(law, 1, f64::INFINITY).unwrap().unwrap();
    assert!(whole.is_finite());
    assert_eq!(cost(law, 1, whole).unwrap(), None);
    assert_eq!(cost(law, 1, whole + 1e-9).unwrap(), Some(whole));
}
