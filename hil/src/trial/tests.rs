//! Tests of `mod.rs`.

use super::*;

fn failed(why: &str) -> Conclusion {
    Conclusion {
        verdict: Verdict::Failed,
        why: vec![why.to_owned()],
    }
}

fn tries(all: &[&str]) -> (Trial, Option<Halt>) {
    let mut next = all.iter();
    decide("a-scene", 1, || {
        let mut wrong = Conclusion::default();
        if let Some(why) = next.next().filter(|w| !w.is_empty()) {
            wrong.add(Verdict::Failed, *why);
        }
        Try {
            wrong,
            ..Try::default()
        }
    })
}

#[test]
fn a_pass_after_a_failure_is_unstable_and_two_failures_are_one() {
    assert_eq!(tries(&[""]).0.end, TrialEnd::Passed);
    assert_eq!(
        tries(&["late", ""]).0.end,
        TrialEnd::Unstable(vec!["late".to_owned()])
    );
    assert_eq!(
        tries(&["late", "later"]).0.end,
        TrialEnd::Failed(failed("later"))
    );
}

#[test]
fn a_bench_that_is_not_well_is_not_tried_again() {
    let mut runs = 0;
    let (trial, halt) = decide("a-scene", 5, || {
        runs += 1;
        Try {
            wrong: failed("bus gone"),
            halt: Some(Halt::Unwell("bus gone".to_owned())),
            ..Try::default()
        }
    });
    assert_eq!((runs, trial.end.word()), (1, "FAILED"));
    assert_eq!(halt, Some(Halt::Unwell("bus gone".to_owned())));
}
