//! Tests of `psychometric.rs`.

use super::*;

#[test]
fn it_runs_from_guessing_to_all_but_slips() {
    let felt = Psychometric {
        threshold: -12.0,
        slope: 3.5,
        guess: 0.5,
        lapse: 0.02,
    };
    assert!((felt.correct(-80.0) - 0.5).abs() < 1e-4);
    assert!((felt.correct(20.0) - 0.98).abs() < 1e-9);
    // At the threshold: 1 - 1/e of the way.
    let way = (felt.correct(-12.0) - 0.5) / 0.48;
    assert!((way - (1.0 - (-1.0f64).exp())).abs() < 1e-12);
}
