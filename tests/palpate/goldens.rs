//! Goldens a person can read: contact paths and schedules of every scene with a sphere, in
//! `fixtures/goldens`. They change only with a reason in the commit message.

use insta::Settings;
use palpate_hil::files::Setup;
use palpate_hil::run::{Input, Outcome, run};
use palpate_records::golden::{COLUMNS, contacts_golden, schedule_golden};

/// A shipped scene on the default bench with the default seed.
pub fn shipped(scene: &str) -> Outcome {
    run(&Setup::load(scene, "emulated").unwrap(), &Input::Scene, 1).unwrap()
}

fn check(scene: &str) {
    let trace = shipped(scene).trace;
    let mut settings = Settings::clone_current();
    settings.set_snapshot_path("../../fixtures/goldens");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        for (kind, text) in [
            ("contacts", contacts_golden(&trace)),
            ("schedule", schedule_golden(&trace)),
        ] {
            assert!(text.is_ascii(), "{scene} {kind}: goldens are ASCII");
            assert!(text.lines().count() <= 200 && text.lines().all(|l| l.len() <= COLUMNS));
            insta::assert_snapshot!(format!("{scene}.{kind}"), text);
        }
    });
}

#[test]
fn sphere_along() {
    check("sphere-along");
}

#[test]
fn sphere_across() {
    check("sphere-across");
}

#[test]
fn sphere_diagonal() {
    check("sphere-diagonal");
}

#[test]
fn sphere_circle() {
    check("sphere-circle");
}

#[test]
fn two_finger_press() {
    check("two-finger-press");
}

#[test]
fn idle() {
    check("idle");
}
