//! The gravest finding is the verdict, and numbers stay short.

use super::*;
use crate::margin::Limited;

#[test]
fn the_gravest_finding_is_the_verdict_whatever_came_first() {
    let findings = [
        (Verdict::Incomplete, "a silent board"),
        (Verdict::LimitExceeded, "a burn"),
        (Verdict::Stopped, "the guard"),
        (Verdict::NotFelt, "too weak"),
        (Verdict::Ok, "no stimulus"),
        (Verdict::OffThePad, "beside it"),
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
fn every_verdict_stands_once_in_its_order_and_is_read_as_it_is_written() {
    assert!(Verdict::ALL.is_sorted_by(|a, b| a < b));
    for verdict in Verdict::ALL {
        assert_eq!(Verdict::of_key(verdict.key()), Some(verdict));
        assert_eq!(
            verdict.key().to_uppercase().replace('-', " "),
            verdict.word()
        );
    }
    assert_eq!(Verdict::of_key("fine"), None);
    let done = Verdict::ALL.into_iter().filter(|verdict| verdict.is_done());
    assert_eq!(done.max(), Some(Verdict::NotFelt));
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
    let wide =
        "no stimulus, since nothing touched the skin and nothing was wanted for all of the run";
    conclusion.add(Verdict::Ok, wide);
    let text = |colored| {
        let mut out = Vec::new();
        conclusion.write(&mut out, colored).unwrap();
        String::from_utf8(out).unwrap()
    };
    assert_eq!(
        text(false),
        "STOPPED: SIGINT\n  also: no stimulus, since nothing touched the skin and nothing was wanted for\n    all of the run\n"
    );
    assert_eq!(
        text(true),
        format!(
            "\x1b[1m\x1b[33mSTOPPED\x1b[0m{}",
            text(false).trim_start_matches("STOPPED")
        )
    );
    assert_eq!(
        serde_json::to_string(&Verdict::LimitExceeded).unwrap(),
        "\"limit-exceeded\""
    );
}

#[test]
fn the_last_line_is_the_verdict_and_no_line_is_wider_than_the_terminal() {
    let mut conclusion = Conclusion::default();
    conclusion.add(Verdict::NotFelt, "person `typical` feels 3 of 78 onsets");
    conclusion.add(
        Verdict::Ok,
        "one more reason whose words fill more than a line of forty",
    );
    let mut out = Vec::new();
    conclusion.write_last(&mut out, 40, false).unwrap();
    let text = String::from_utf8(out).unwrap();
    assert_eq!(
        text,
        "  also: one more reason whose words fill\n    more than a line of forty\nNOT FELT: person `typical` feels 3 of 78\n    onsets\n"
    );
    let mut out = Vec::new();
    Conclusion::default()
        .write_last(&mut out, 40, true)
        .unwrap();
    assert_eq!(out, b"\x1b[1m\x1b[32mOK\x1b[0m\n");
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
