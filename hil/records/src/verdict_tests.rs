//! The gravest finding is the verdict, and numbers stay short.

use super::*;
use crate::margin::Limited;

#[test]
fn the_gravest_finding_is_the_verdict_whatever_came_first() {
    let findings = [
        (Verdict::Incomplete, "a silent board"),
        (Verdict::LimitExceeded, "a burn"),
        (Verdict::Stopped, "the guard"),
        (Verdict::Ok, "no stimulus"),
        (Verdict::Failed, "a bus"),
    ];
    for turn in 0..findings.len() {
        let mut order = findings;
        order.rotate_left(turn);
        let mut conclusion = Conclusion::default();
        for (verdict, why) in order {
            conclusion.add(verdict, why);
        }
        assert_eq!(conclusion.line(), "LIMIT EXCEEDED: a burn");
        assert_eq!(conclusion.why.len(), findings.len());
    }
}

#[test]
fn a_verdict_names_the_worst_of_the_limits_that_were_passed() {
    let of = |limited, worst| Margin::new(limited, worst, 10.0);
    let margins = [
        of(Limited::Pulse, 51.2),
        of(Limited::Burst, 11.0),
        of(Limited::SupplyCurrent, 10.0),
    ];
    let mut conclusion = Conclusion::default();
    conclusion.add_margins(&margins);
    assert_eq!(
        conclusion.line(),
        "LIMIT EXCEEDED: 2 of 3 rows of the limit table, most of all pulse (512 % used)"
    );
    let mut within = Conclusion::default();
    within.add_margins(&margins[2..]);
    assert_eq!((within.line(), within.why.len()), ("OK".to_owned(), 0));
}

#[test]
fn a_terminal_sees_colour_and_a_pipe_does_not() {
    let mut conclusion = Conclusion::default();
    conclusion.add(Verdict::Stopped, "SIGINT");
    conclusion.add(Verdict::Ok, "no stimulus");
    let text = |colored| {
        let mut out = Vec::new();
        conclusion.write(&mut out, colored).unwrap();
        String::from_utf8(out).unwrap()
    };
    assert_eq!(text(false), "STOPPED: SIGINT\n  also: no stimulus\n");
    assert_eq!(
        text(true),
        "\x1b[1m\x1b[33mSTOPPED\x1b[0m: SIGINT\n  also: no stimulus\n"
    );
    assert_eq!(
        serde_json::to_string(&Verdict::LimitExceeded).unwrap(),
        "\"limit-exceeded\""
    );
}

#[test]
fn a_used_share_has_a_bounded_width() {
    let words = |worst| Margin::new(Limited::Henriques, worst, 1e-3).used_words();
    assert_eq!(words(0.0), "0 %");
    assert_eq!(words(9.99e-4), "100 %");
    assert_eq!(words(0.0099), "990 %");
    assert_eq!(words(0.5), "500 x");
    assert_eq!(words(1e9), "> 1e6 x");
    assert_eq!(words(f64::NAN), "> 1e6 x");
    assert_eq!(
        Margin::new(Limited::Henriques, 1.0, 0.0).used_words(),
        "> 1e6 x"
    );
}
