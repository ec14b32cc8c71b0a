//! Trials as one page: a line each, and what was measured behind it.

use std::fmt::Write;

use palpate_records::report::page::{self, foot, head, table};
use palpate_records::report::svg::escape;
use palpate_records::verdict::Verdict;

use super::{Measure, Trial};

/// The page of all trials, by bench. `counts` says how many there were.
pub fn page(verdict: Verdict, counts: &str, suites: &[(String, Vec<Trial>)]) -> String {
    let mut out = head("trials");
    out.push_str("<header><h1>Trials</h1></header>\n");
    out.push_str(&page::verdict(verdict, &[counts.to_owned()]));
    for (bench, trials) in suites {
        let _ = writeln!(out, "<section><h2>On {}</h2>", escape(bench));
        trials.iter().for_each(|trial| line(&mut out, trial));
        out.push_str("</section>\n");
    }
    out + &foot("", "")
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
    for text in trial.end.why().iter().chain(&trial.remark) {
        let _ = write!(out, "<p class=\"sub\">{}</p>", escape(text));
    }
    if !trial.measures.is_empty() {
        let row = |measure: &Measure| {
            let words = measure.words();
            let value = words.strip_prefix(&measure.name).unwrap_or(&words);
            let value = value.trim_start_matches(':').trim();
            (
                !measure.good(),
                vec![measure.name.clone(), value.to_owned()],
            )
        };
        let columns = [("", "measured"), ("", "value and limit")];
        out.push_str(&table(&columns, trial.measures.iter().map(row)));
    }
    out.push_str("</details>\n");
}
