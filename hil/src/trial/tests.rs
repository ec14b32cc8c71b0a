//! Tests of `mod.rs`.

use super::*;

fn tries(all: &[&str]) -> (Trial, Option<Halt>) {
    let mut next = all.iter();
    decide("a-scene", 1, || Try {
        wrong: next
            .next()
            .filter(|w| !w.is_empty())
            .map(|w| (*w).to_owned())
            .into_iter()
            .collect(),
        ..Try::default()
    })
}

#[test]
fn a_pass_after_a_failure_is_unstable_and_two_failures_are_one() {
    assert_eq!(tries(&[""]).0.verdict, Verdict::Passed);
    assert_eq!(
        tries(&["late", ""]).0.verdict,
        Verdict::Unstable(vec!["late".to_owned()])
    );
    assert_eq!(
        tries(&["late", "later"]).0.verdict,
        Verdict::Failed(vec!["later".to_owned()])
    );
}

#[test]
fn a_bench_that_is_not_well_is_not_tried_again() {
    let mut runs = 0;
    let (trial, halt) = decide("a-scene", 5, || {
        runs += 1;
        Try {
            wrong: vec!["bus gone".to_owned()],
            halt: Some(Halt::Unwell("bus gone".to_owned())),
            ..Try::default()
        }
    });
    assert_eq!((runs, trial.verdict.word()), (1, "FAIL"));
    assert_eq!(halt, Some(Halt::Unwell("bus gone".to_owned())));
}
