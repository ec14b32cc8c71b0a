//! Verdicts of whole runs: of a scene that passes limits, of silent boards, of touches that meet nothing.

use super::*;
use crate::{Input, run};
use palpate_files::{Overrides, Setup, load_bench, load_scene};

fn of(scene: &str, set: &[&str]) -> Conclusion {
    let mut overrides = Overrides::default();
    for text in set {
        overrides.set("--set", text).unwrap();
    }
    let scene = load_scene(scene).unwrap().with(&overrides).unwrap();
    let bench = load_bench("emulated").unwrap();
    let setup = Setup::join(scene, bench).unwrap();
    run(&setup, &Input::Scene, 1).unwrap().summary.conclusion
}

#[test]
fn a_burn_is_an_exceeded_limit() {
    let found = of("stuck-amplifier", &[]);
    assert_eq!(found.verdict, Verdict::LimitExceeded);
    assert!(
        found.why[0].contains("rows of the limit table"),
        "{found:?}"
    );
}

#[test]
fn a_run_within_its_limits_is_ok_without_a_word() {
    assert_eq!(of("sphere-along", &[]), Conclusion::default());
}

#[test]
fn a_run_without_a_stimulus_says_why() {
    let idle = of("idle", &[]);
    assert_eq!(idle.line(), "OK: no stimulus: the scene touches nothing");
}
