//! Tests of `measure.rs`.

use super::*;
use palpate_run::{Input, run};

#[test]
fn a_bound_without_a_value_is_wrong_and_nan_is_within_none() {
    let m = |value| Measure::new("x", value, "mm", Some(1.0));
    assert!(m(Some(1.0)).good() && !m(Some(1.001)).good());
    assert!(!m(Some(f64::NAN)).good());
    assert_eq!(
        m(None).wrong().unwrap(),
        "x: expected <= 1.000 mm, found nothing measured"
    );
    assert_eq!(m(Some(0.5)).words(), "x 0.500 mm <= 1.000 mm");
}

#[test]
fn a_run_is_measured_against_its_scene_and_the_limits() {
    let mut setup = Setup::load("sphere-along", "emulated").unwrap();
    let outcome = run(&setup, &Input::Scene, 1).unwrap();
    let all = measures(&setup, &outcome);
    assert!(all.iter().all(Measure::good), "{all:#?}");
    let bound = |name: &str| all.iter().find(|m| m.name == name).unwrap().bound;
    assert_eq!(bound("contacts in a frame"), Some(Bound::AtMost(1.0)));
    assert_eq!(bound("skin at 0.1 mm"), Some(Bound::AtMost(43.0)));
    assert_eq!(bound("energy"), None);
    setup.scene.value.expect.path_rmse_mm = Some(0.001);
    let wrong: Vec<String> = measures(&setup, &outcome)
        .iter()
        .filter_map(Measure::wrong)
        .collect();
    assert!(wrong[0].starts_with("path error RMSE: expected <= 0.001 mm, found 0.1"));
    assert_eq!(wrong.len(), 1);
}
