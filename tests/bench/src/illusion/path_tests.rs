//! Tests of `path.rs`.

use palpate_run::{Input, run};

use super::*;

#[test]
fn the_error_is_that_of_the_summary_times_the_scale() {
    let setup = Setup::load("sphere-circle", "emulated").unwrap();
    let map = map(&setup).unwrap();
    let outcome = run(&setup, &Input::Scene, 1).unwrap();
    let sensor = outcome.summary.path_error_mm.unwrap().rmse;
    let at = |x, y| map.apply(Point::new(x, y));
    let scales = [at(1.0, 0.0), at(0.0, 1.0)].map(|p| f64::from(p.distance(at(0.0, 0.0))));
    let [least, most] = [scales[0].min(scales[1]), scales[0].max(scales[1])];
    assert!(least > 1.2, "{scales:?}");
    let display = error_mm(&outcome.trace, &map);
    // The summary rounds down to a micrometre.
    assert!(
        display > least * sensor - 1e-4 && display < most * (sensor + 1e-3),
        "{display} mm, {sensor} mm by {scales:?}"
    );
}

#[test]
fn a_run_without_a_touch_has_no_error() {
    let setup = Setup::load("idle", "emulated").unwrap();
    let outcome = run(&setup, &Input::Scene, 1).unwrap();
    assert!(error_mm(&outcome.trace, &map(&setup).unwrap()).is_nan());
}
