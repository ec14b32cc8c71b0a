//! Trials as JUnit XML: measurements as properties with unit and limit, tries that failed before one passed as
//! `flakyFailure`, as Maven's Surefire writes them and Jenkins and GitLab read them.

use std::fmt::Write;

use palpate_records::report::svg::escape;

use super::{Trial, TrialEnd};

/// The trials of some benches as a document, a suite a bench.
pub fn junit(suites: &[(String, Vec<Trial>)]) -> String {
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let all: Vec<&Trial> = suites.iter().flat_map(|(_, trials)| trials).collect();
    let _ = writeln!(out, "<testsuites name=\"hil\" {}>", totals(&all));
    for (bench, trials) in suites {
        let bench = escape(bench);
        let totals = totals(&trials.iter().collect::<Vec<_>>());
        let _ = writeln!(out, "<testsuite name=\"{bench}\" {totals}>");
        trials
            .iter()
            .for_each(|trial| case(&mut out, &bench, trial));
        out.push_str("</testsuite>\n");
    }
    out.push_str("</testsuites>\n");
    out
}

fn totals(trials: &[&Trial]) -> String {
    let count = |f: fn(&TrialEnd) -> bool| trials.iter().filter(|t| f(&t.end)).count();
    let failures = count(|e| matches!(e, TrialEnd::Failed(_)));
    let errors = count(|e| matches!(e, TrialEnd::Broken(_)));
    let skipped = count(|e| !e.is_tried() || matches!(e, TrialEnd::Quarantined(..)));
    let seconds: f64 = trials.iter().map(|t| t.took.as_secs_f64()).sum();
    format!(
        "tests=\"{}\" failures=\"{failures}\" errors=\"{errors}\" skipped=\"{skipped}\" time=\"{seconds:.3}\"",
        trials.len()
    )
}

fn case(out: &mut String, bench: &str, trial: &Trial) {
    let _ = writeln!(
        out,
        "<testcase classname=\"{bench}\" name=\"{}\" time=\"{:.3}\">",
        escape(&trial.scene),
        trial.took.as_secs_f64()
    );
    if !trial.measures.is_empty() {
        out.push_str("<properties>\n");
        for m in &trial.measures {
            let mut property = |name: &str, value: &str| {
                let (name, value) = (escape(name), escape(value));
                let _ = writeln!(out, "<property name=\"{name}\" value=\"{value}\"/>");
            };
            let value = match (m.lacking, m.value) {
                (Some(lacking), _) => format!("bench lacks {lacking}"),
                (None, Some(value)) => value.to_string(),
                (None, None) => "nothing measured".to_owned(),
            };
            property(&m.name, &value);
            if !m.unit.is_empty() {
                property(&format!("{} unit", m.name), m.unit);
            }
            if let Some(bound) = m.bound_text() {
                property(&format!("{} limit", m.name), &bound);
            }
        }
        out.push_str("</properties>\n");
    }
    let mut told = |tag: &str, why: &str| {
        let why = escape(why);
        // Jenkins lists the message, GitLab shows the text alone.
        let _ = match tag {
            "failure" | "error" => {
                writeln!(out, "<{tag} message=\"{why}\">{why}</{tag}>")
            }
            _ => writeln!(out, "<{tag} message=\"{why}\"/>"),
        };
    };
    match &trial.end {
        TrialEnd::Passed | TrialEnd::Noted(_) => {}
        TrialEnd::Unstable(before) => before.iter().for_each(|w| told("flakyFailure", w)),
        TrialEnd::Failed(wrong) => told("failure", &wrong.why.join("; ")),
        TrialEnd::Quarantined(wrong, reason) => {
            let wrong = wrong.why.join("; ");
            told(
                "skipped",
                &format!("quarantined: {reason}; failed: {wrong}"),
            );
        }
        TrialEnd::Refused(why) => told("skipped", &format!("refused: {why}")),
        TrialEnd::Skipped(why) => told("skipped", why),
        TrialEnd::Broken(why) => told("error", why),
    }
    let noted = match &trial.end {
        TrialEnd::Noted(run) => Some(run.line()),
        _ => None,
    };
    let said: Vec<String> = noted.into_iter().chain(trial.remark.clone()).collect();
    if !said.is_empty() {
        let said = escape(&said.join("\n"));
        let _ = writeln!(out, "<system-out>{said}</system-out>");
    }
    out.push_str("</testcase>\n");
}

#[cfg(test)]
#[path = "junit_tests.rs"]
mod tests;
