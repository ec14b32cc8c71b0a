//! Tests of `bound.rs`.

use palpate_core::contact::Levels;
use palpate_files::Setup;
use palpate_run::{Input, build, run};

use super::*;

#[test]
fn the_path_is_as_far_off_as_the_display_is_wider_than_the_pad() {
    let setup = Setup::load("sphere-along", "emulated").unwrap();
    let map = *build(&setup, 1, Levels::Off).unwrap().map();
    let outcome = run(&setup, &Input::Scene, 1).unwrap();
    let on_pad = outcome.summary.path_error_mm.unwrap().rmse;
    let at = |x, y| map.apply(Point::new(x, y));
    let (origin, x, y) = (at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0));
    let scales = [f64::from(x.x - origin.x), f64::from(y.y - origin.y)];
    let most = scales[0].max(scales[1]);
    let least = scales[0].min(scales[1]);
    let on_display = path_mm(&outcome.trace, &map).unwrap();
    assert!(
        on_display > least * on_pad - 1e-2 && on_display < most * on_pad + 1e-2,
        "{on_display} mm, {on_pad} mm, scales {scales:?}"
    );
}

#[test]
fn parts_add_in_squares_and_the_run_that_uses_up_more_is_kept() {
    let bound = |path_mm, felt_mm| Bound {
        path_mm,
        most_mm: Some(0.8_f64.hypot(path_mm)),
        felt_mm,
    };
    let (good, bad) = (bound(0.6, 1.0), bound(0.3, 0.99));
    assert_eq!((good.is_met(), bad.is_met()), (Some(true), Some(false)));
    assert_eq!(good.worse(bad), bad);
    assert_eq!(bad.worse(good), bad);
    let nothing_felt = bound(0.3, f64::NAN);
    assert!(bad.worse(nothing_felt).felt_mm.is_nan());
    assert_eq!(nothing_felt.is_met(), Some(false));
}
