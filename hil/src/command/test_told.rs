//! Output of `hil test`: a line per trial, the slowest, counts, one object for programs.

use std::io::{self, Write};

use palpate_live::output::print_json;
use palpate_records::verdict::Verdict;
use palpate_run::Failure;
use serde::Serialize;

use crate::trial::{Trial, TrialEnd};

/// Measurements on the line of a trial that passed, and trials that are named for their time.
const SHOWN: usize = 3;
/// Heading in place of a bench for files that hold nothing or cannot be read.
pub(super) const FILES: &str = "files";

/// Prints a line for the trial, and more where something is wrong.
pub(super) fn tell(trial: &Trial, colored: bool, out: &mut dyn Write) -> io::Result<()> {
    // Padded first: the codes of a colour have no width.
    let word = format!("{:<14}", trial.end.word());
    let word = trial.end.verdict().paint(&word, colored);
    let detail = match &trial.end {
        TrialEnd::Passed | TrialEnd::Noted(_) | TrialEnd::Unstable(_) => {
            let bound = trial.measures.iter().filter(|m| m.bound.is_some());
            let mut words: Vec<String> = bound.take(SHOWN).map(|m| m.words()).collect();
            let kinds = &trial.goldens.kinds;
            words.extend((!kinds.is_empty()).then(|| format!("golden {}", kinds.join(" and "))));
            words.join(", ")
        }
        TrialEnd::Refused(why) | TrialEnd::Skipped(why) => why.clone(),
        TrialEnd::Failed(_) | TrialEnd::Broken(_) => String::new(),
        TrialEnd::Quarantined(_, reason) => reason.clone(),
    };
    let took = format!("{:.2} s", trial.took.as_secs_f64());
    writeln!(out, "{word}  {:<26} {took:>8}  {detail}", trial.scene)?;
    let more = match trial.end.is_tried() {
        true => trial.end.why(),
        false => &[],
    };
    for line in more.iter().chain(&trial.remark) {
        writeln!(out, "                {line}")?;
    }
    for path in &trial.goldens.wrote {
        writeln!(out, "                wrote {}", path.display())?;
    }
    Ok(())
}

/// Prints the trials that took longest, where there are enough that it says something.
pub(super) fn slowest(trials: &[&Trial], out: &mut dyn Write) -> io::Result<()> {
    let mut ran: Vec<&&Trial> = trials.iter().filter(|t| !t.took.is_zero()).collect();
    if ran.len() <= SHOWN {
        return Ok(());
    }
    ran.sort_by_key(|t| std::cmp::Reverse(t.took));
    let words = ran.iter().take(SHOWN);
    let words = words.map(|t| format!("{} {:.2} s", t.scene, t.took.as_secs_f64()));
    writeln!(out, "slowest: {}", words.collect::<Vec<_>>().join(", "))
}

/// Number of trials by the way they ended.
pub(super) fn counts(trials: &[&Trial]) -> String {
    let count = |counts: fn(&TrialEnd) -> bool| trials.iter().filter(|t| counts(&t.end)).count();
    let (passed, failed) = (
        count(|e| matches!(e, TrialEnd::Passed)),
        count(|e| matches!(e, TrialEnd::Failed(_) | TrialEnd::Broken(_))),
    );
    let others = [
        (count(|e| matches!(e, TrialEnd::Unstable(_))), "unstable"),
        (
            count(|e| matches!(e, TrialEnd::Quarantined(..))),
            "quarantined",
        ),
        (count(|e| e.verdict() == Verdict::NotFelt), "not felt"),
        (count(|e| e.verdict() == Verdict::OffThePad), "off the pad"),
        (count(|e| matches!(e, TrialEnd::Refused(_))), "refused"),
        (count(|e| matches!(e, TrialEnd::Skipped(_))), "skipped"),
    ];
    let mut words = format!("{passed} passed, {failed} failed");
    for (n, word) in others.into_iter().filter(|(n, _)| *n > 0) {
        words += &format!(", {n} {word}");
    }
    words
}

/// Prints the trials as one object.
///
/// # Errors
/// The errors of [`print_json`].
pub(super) fn json(
    verdict: Verdict,
    source: &str,
    suites: &[(String, Vec<Trial>)],
) -> Result<(), Failure> {
    let trial = |bench: &str, t: &Trial| {
        let measures: Vec<serde_json::Value> = t
            .measures
            .iter()
            .map(|m| {
                serde_json::json!({
                    "name": m.name, "value": m.value, "unit": m.unit,
                    "limit": m.bound_text(), "good": m.good(),
                })
            })
            .collect();
        serde_json::json!({
            "trial": t.scene, "bench": bench, "verdict": t.end.key(), "why": t.end.why(),
            "took_s": t.took.as_secs_f64(), "measures": measures,
            "goldens": t.goldens.kinds, "wrote": t.goldens.wrote,
        })
    };
    let of = |(bench, trials): &(String, Vec<Trial>)| -> Vec<_> {
        trials.iter().map(|t| trial(bench, t)).collect()
    };
    let trials: Vec<serde_json::Value> = suites.iter().flat_map(of).collect();
    let benches = suites.iter().map(|(bench, _)| bench.as_str());
    let benches: Vec<&str> = benches.filter(|bench| *bench != FILES).collect();
    /// Keys in this order: the verdict first.
    #[derive(Serialize)]
    struct All<'a> {
        verdict: Verdict,
        bench: String,
        source: &'a str,
        trials: Vec<serde_json::Value>,
    }
    let all = All {
        verdict,
        bench: benches.join(", "),
        source,
        trials,
    };
    print_json(&all)
}
