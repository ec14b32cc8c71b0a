//! Tests of the hot pass: what is planned for a wire, what it comes to on an emulated bench, and what a refusal leaves.

use palpate_core::schedule::Entry;
use palpate_records::trace::event;

use super::plan::plan;
use super::*;
use crate::{Input, Keep, run, run_with};

/// The thin wires as nobody has passed them.
fn cold(scene: &str) -> Setup {
    let mut setup = Setup::load(scene, "emulated").unwrap();
    setup.wire.value.state = WireState::Cold;
    setup
}

fn notes(outcome: &Outcome) -> Vec<String> {
    let notes = outcome.trace.each::<event::Note>();
    notes.map(|note| note.text.clone()).collect()
}

#[test]
fn passed_wires_and_benches_that_forbid_it_have_none() {
    assert!(is_due(&cold("sphere-along")));
    let mut passed = cold("sphere-along");
    set_passed(&mut passed);
    assert!(!is_due(&passed));
    assert!(!is_due(&Setup::load("sphere-along", "thesis").unwrap()));
    let mut left = cold("sphere-along");
    left.pass = Pass::LeftOut;
    assert!(!is_due(&left));
}

#[test]
fn a_plan_passes_the_wire_that_takes_the_most_heat() {
    let planned = plan(&cold("sphere-along")).unwrap().unwrap();
    let pass = planned.pass;
    assert!(planned.left_at_worst.unwrap() < heated::PASSED);
    // 148 ticks are what 200 us are at the slowest clock.
    assert_eq!((pass.width.get(), planned.prescale.get()), (148, 30));
    assert!(pass.bursts >= 1 && pass.apart.as_micros() >= 1_000_000);
    assert!(planned.burst_nj < 10_000_000);
    // A pulse less, and a burst less, leave more there than may be left.
    let less = |bursts: u8, half_periods: u64| {
        let half_ns = planned.prescale.period_ns() / 2;
        let pulses = 2 * heated::pulses(&pass, planned.prescale) - half_periods;
        let burst = palpate_core::units::Duration::from_micros((pulses - 1) * half_ns / 1000);
        palpate_core::projector::HotPass {
            bursts,
            burst,
            ..pass
        }
    };
    let heated = heated::Heated::new(&cold("sphere-along"), planned.prescale);
    assert!(heated.left_at_worst(&less(pass.bursts, 2)).unwrap() >= heated::PASSED);
    if pass.bursts > 1 {
        assert!(heated.left_at_worst(&less(pass.bursts - 1, 0)).unwrap() >= heated::PASSED);
    }
}

#[test]
fn a_run_on_cold_wires_passes_them_before_its_first_moment() {
    let outcome = run(&cold("sphere-along"), &Input::Scene, 1).unwrap();
    let pass = outcome.summary.pass.as_ref().unwrap();
    assert_eq!(
        (pass.state, pass.passed, pass.wires),
        ("assumed passed", 8, 8)
    );
    // On a finger of 30 C stress brings a little back.
    assert!(pass.martensite.unwrap() < 0.4 * heated::KEPT);
    assert!((33.0..43.0).contains(&pass.hottest_skin_c.unwrap()));
    assert_eq!(pass.schedule.len(), 8 * usize::from(pass.bursts));
    assert!(
        pass.schedule
            .iter()
            .all(|burst| burst.at_s < 0.0 && burst.pulses == pass.pulses)
    );
    assert!(
        notes(&outcome)[0].starts_with("hot pass: "),
        "{:?}",
        notes(&outcome)
    );

    // The scene's onsets stand where they stand on wires that begin passed, and are felt as there.
    let mut given = cold("sphere-along");
    set_passed(&mut given);
    let given = run(&given, &Input::Scene, 1).unwrap();
    assert!(given.summary.pass.is_none());
    let starts = |outcome: &Outcome| -> Vec<u64> {
        outcome
            .trace
            .each::<Entry>()
            .map(|e| e.at.as_micros())
            .collect()
    };
    assert_eq!(starts(&outcome), starts(&given));
    let level = |outcome: &Outcome| outcome.summary.felt.level_db.unwrap().median;
    assert!((level(&outcome) - level(&given)).abs() < 0.2);
}

#[test]
fn level_and_error_are_given_for_both_states() {
    let keep = Keep {
        spread: true,
        ..Keep::default()
    };
    let outcome = run_with(&cold("sphere-along"), &Input::Scene, 1, keep, &mut ()).unwrap();
    let felt = &outcome.summary.felt;
    assert_eq!(felt.state, Some("assumed passed"));
    let [passed, cold] = &felt.states[..] else {
        panic!("{:?}", felt.states)
    };
    assert_eq!([passed.state, cold.state], ["passed", "cold"]);
    // The headline is the run in the state that is assumed.
    let headline = felt.level_db.unwrap().median;
    assert!((passed.level_db - headline).abs() < 2e-3);
    assert_eq!(passed.error_energy_mm, felt.error_energy_mm);
    // Wires that are not passed lose the place: they pass one by one in use.
    let error = |state: &crate::states::FeltState| state.error_energy_mm.unwrap().rmse;
    assert!(error(cold) > error(passed) + 0.2, "{:?}", felt.states);
}

#[test]
fn what_the_guard_refuses_leaves_cold_wires_and_a_note() {
    let mut setup = cold("sphere-along");
    setup.limits.value.limits.burst_energy_nj = 2_000_000;
    let outcome = run(&setup, &Input::Scene, 1).unwrap();
    let pass = outcome.summary.pass.as_ref().unwrap();
    assert_eq!((pass.state, pass.passed), ("cold", 0));
    assert_eq!(pass.why.as_deref(), Some("the guard refused wire 0: burst"));
    let notes = notes(&outcome);
    assert!(
        notes[0].contains("NOT PASSED: the guard refused wire 0: burst. The wires count as cold"),
        "{notes:?}"
    );
}

#[test]
fn a_bow_that_a_pass_would_pull_tight_is_left_cold() {
    let mut setup = cold("sphere-along");
    let wire = &mut setup.wire.value;
    wire.mechanical.bias_stress_mpa = 0.0;
    wire.mechanical.transformation_strain = 0.06;
    wire.r_phase.as_mut().unwrap().strain = 0.0;
    setup.bench.value.mount.sag_um = 20.0;
    setup.bench.value.tissue.modulus_kpa = 1.0;
    let (after, report) = before(&setup, |_| unreachable!()).unwrap();
    assert!(report.is_none() && after.told.as_ref().unwrap().starts_with("none: "));
    assert_eq!(after.wire.value.state, WireState::Cold);
}
