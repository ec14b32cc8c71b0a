//! Verdicts of whole runs: of a scene that passes limits, of silent boards, of touches that meet nothing.

use super::*;
use crate::{Input, run};
use palpate_files::{Overrides, Setup, load_bench, load_scene};

fn concluded(scene: &str, set: &[&str]) -> Conclusion {
    on("emulated", scene, set)
}

fn on(bench: &str, scene: &str, set: &[&str]) -> Conclusion {
    let mut overrides = Overrides::default();
    for text in set {
        overrides.set("--set", text).unwrap();
    }
    let scene = load_scene(scene).unwrap().with(&overrides).unwrap();
    let bench = load_bench(bench).unwrap();
    let setup = Setup::join(scene, bench).unwrap();
    run(&setup, &Input::Scene, 1).unwrap().summary.conclusion
}

#[test]
fn a_burn_is_beyond_the_model_and_an_exceeded_limit() {
    let found = concluded("stuck-amplifier", &[]);
    assert_eq!(found.verdict, Verdict::BeyondTheModel);
    let first = "a wire passed 400 C, skin passed 100 C by ";
    assert!(found.why[0].starts_with(first), "{found:?}");
    assert!(
        found.why[1].contains("rows of the limit table"),
        "{found:?}"
    );
}

/// Skin so soft that it lets a flat bow be pulled straight.
#[test]
fn a_bow_that_is_pulled_straight_is_beyond_the_model() {
    let conclusion = |sag_um: f64| {
        let mut bench = load_bench("emulated").unwrap();
        bench.value.mount.sag_um = sag_um;
        bench.value.tissue.modulus_kpa = 1.0;
        let mut setup = Setup::join(load_scene("sphere-along").unwrap(), bench).unwrap();
        crate::pass::set_passed(&mut setup);
        run(&setup, &Input::Scene, 1).unwrap().summary.conclusion
    };
    let found = conclusion(25.0);
    assert_eq!(found.verdict, Verdict::BeyondTheModel);
    assert_eq!(
        found.why[0],
        "a wire's bow passed 90 % of its sag: mount.sag_um is too small"
    );
    assert_ne!(conclusion(250.0).verdict, Verdict::BeyondTheModel);
}

/// A touch that rests at a place with a force, as a line of a file.
fn resting(x_mm: f64, force_n: f64) -> String {
    format!(
        "touches=[{{ start_s = 0.8, path = {{ kind = \"hold\", points_mm = [[{x_mm:?}, 0.0]] }}, force_n = {{ mean = {force_n:?} }} }}]"
    )
}

#[test]
fn what_is_touched_beside_the_pad_is_off_it_and_no_failure_to_feel() {
    let found = concluded("sphere-along", &[&resting(60.0, 0.7)]);
    assert_eq!(found.verdict, Verdict::OffThePad, "{found:?}");
    assert!(found.why[0].contains("beyond what the display shows"));
    assert_eq!(found.why.len(), 1, "{found:?}");
    // A line that is on the pad for a tenth of its way.
    let line = resting(0.0, 0.7).replace(
        "kind = \"hold\", points_mm = [[0.0, 0.0]]",
        "kind = \"line\", points_mm = [[0.0, -60.0], [0.0, 60.0]], period_s = 4.0",
    );
    assert_eq!(
        concluded("sphere-along", &[&line]).verdict,
        Verdict::OffThePad
    );
}

#[test]
fn a_touch_that_no_reading_shows_is_not_felt() {
    let found = concluded("sphere-along", &[&resting(0.0, 0.001)]);
    assert_eq!(found.verdict, Verdict::NotFelt, "{found:?}");
    assert!(found.why[0].contains("rose above the contact threshold"));
}

#[test]
fn a_person_who_feels_less_than_half_decides() {
    let found = concluded(
        "sphere-along",
        &[
            "length_s=4",
            "illusion.person=dull",
            "illusion.model=phantom",
        ],
    );
    assert_eq!(found.verdict, Verdict::NotFelt, "{found:?}");
    assert!(
        found.why[0].starts_with("person `dull` feels "),
        "{found:?}"
    );
}

#[test]
fn pulses_of_a_texture_that_are_too_weak_are_not_felt() {
    let mut scene = load_scene("texture-sponge1").unwrap();
    scene.value.illusion.person = "dull".into();
    let setup = Setup::join(scene, load_bench("emulated").unwrap()).unwrap();
    let summary = run(&setup, &Input::Scene, 1).unwrap().summary;
    assert_eq!(summary.conclusion.verdict, Verdict::NotFelt);
    assert_eq!(summary.felt.breaks, None, "no onset had a contact");
    assert!(summary.onsets.meant > 10, "{:?}", summary.onsets);
}

#[test]
fn a_run_within_its_limits_is_ok_without_a_word() {
    assert_eq!(concluded("sphere-along", &[]), Conclusion::default());
}

#[test]
fn a_run_without_a_stimulus_says_why() {
    let idle = concluded("idle", &[]);
    assert_eq!(idle.line(), "OK: no stimulus: the scene touches nothing");
}

/// On one bus the boards of a hand overwrite what waits: a scripted shortage, so a remark.
#[test]
fn taxels_that_a_scripted_overload_starves_are_a_remark() {
    let scene = "allegro-one-bus-overwrite";
    let found = concluded(scene, &[]);
    assert_eq!(found.verdict, Verdict::Ok, "{found:?}");
    let starved = "taxels never spoke, and no frame was foreign";
    assert!(found.why.iter().any(|w| w.contains(starved)), "{found:?}");
    // The same want in a recording is one.
    let setup = Setup::join(load_scene(scene).unwrap(), load_bench("emulated").unwrap()).unwrap();
    let mut outcome = run(&setup, &Input::Scene, 1).unwrap();
    outcome.summary.conclusion = Conclusion::default();
    let replayed = outcome.concluded(&setup, true).summary.conclusion;
    assert_eq!(replayed.verdict, Verdict::Incomplete, "{replayed:?}");
}
