//! The measurements as one HTML page that needs nothing else.

use palpate_records::report::page::{foot, head};
use palpate_records::report::svg::escape;
use std::fmt::Write;

use crate::findings::Findings;
use crate::table;

/// All families on a page.
pub fn html(found: &[Findings]) -> String {
    let mut page = head("benchmarks") + "<header><h1>Benchmarks</h1></header>\n";
    for findings in found {
        for figure in &findings.figures {
            let _ = writeln!(
                page,
                "<section><h2>{} \u{b7} {}</h2><p class=\"sub\">{}</p>\n<div class=\"wide\">{}</div>{}</section>",
                findings.family,
                escape(&figure.title),
                escape(&figure.words),
                figure.svg,
                figure.legend
            );
        }
        page.push_str("<section><pre>");
        for line in table::text(findings).lines() {
            let _ = writeln!(page, "{}", escape(line));
        }
        page.push_str("</pre></section>\n");
    }
    let words = ". Medians of many calls, methods of a case in turn, in one run on this machine.";
    page + &foot(words, "")
}
