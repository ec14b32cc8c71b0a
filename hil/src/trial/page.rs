//! Trials as one page: a line each, and what was measured behind it.

use std::fmt::Write;

use palpate_records::report::STYLE;
use palpate_records::report::svg::escape;
use palpate_records::verdict::Verdict;

use super::{Trial, TrialEnd};

/// The page of all trials, by bench. `counts` says how many there were.
pub fn page(verdict: Verdict, counts: &str, suites: &[(String, Vec<Trial>)]) -> String {
    let mut out = String::with_capacity(64 * 1024);
    let _ = write!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>trials \u{b7} palpate</title>\n<style>\n{STYLE}</style></head>\n<body><main>\n\
         <header><h1>Trials</h1></header>\n\
         <p class=\"verdict {}\" role=\"status\"><strong>{}</strong><span>{}</span></p>\n",
        verdict.key(),
        verdict.word(),
        escape(counts)
    );
    for (bench, trials) in suites {
        let _ = writeln!(out, "<section><h2>On {}</h2>", escape(bench));
        trials.iter().for_each(|trial| line(&mut out, trial));
        out.push_str("</section>\n");
    }
    let _ = writeln!(
        out,
        "<footer>palpate {}</footer>\n</main></body></html>",
        env!("CARGO_PKG_VERSION")
    );
    out
}

fn line(out: &mut String, trial: &Trial) {
    let over = if trial.end.verdict() == Verdict::Ok {
        ""
    } else {
        " open"
    };
    let _ = write!(
        out,
        "<details{over}><summary><strong>{}</strong> {} ({:.2} s)</summary>",
        trial.end.word(),
        escape(&trial.scene),
        trial.took.as_secs_f64()
    );
    let why: &[String] = match &trial.end {
        TrialEnd::Passed => &[],
        TrialEnd::Skipped(why) => std::slice::from_ref(why),
        TrialEnd::Unstable(before) => before,
        TrialEnd::Failed(wrong) | TrialEnd::Quarantined(wrong, _) => &wrong.why,
    };
    for text in why.iter().chain(&trial.remark) {
        let _ = write!(out, "<p class=\"sub\">{}</p>", escape(text));
    }
    if !trial.measures.is_empty() {
        out.push_str("<table><tr><th>measured</th><th>value and limit</th></tr>\n");
        for measure in &trial.measures {
            let class = if measure.good() {
                ""
            } else {
                " class=\"over\""
            };
            let words = measure.words();
            let value = words.strip_prefix(&measure.name).unwrap_or(&words);
            let _ = writeln!(
                out,
                "<tr{class}><td>{}</td><td>{}</td></tr>",
                escape(&measure.name),
                escape(value.trim_start_matches(':').trim())
            );
        }
        out.push_str("</table>");
    }
    out.push_str("</details>\n");
}
