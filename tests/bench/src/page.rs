//! The measurements as one HTML page that needs nothing else.

use palpate_records::report::STYLE;
use palpate_records::report::svg::escape;
use std::fmt::Write;

use crate::findings::Findings;
use crate::table;

/// All families on a page.
pub fn html(found: &[Findings]) -> String {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>benchmarks \u{b7} palpate</title>\n<style>\n{STYLE}</style></head>\n<body><main>\
         <header><h1>Benchmarks</h1></header>\n"
    );
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
    let _ = writeln!(
        page,
        "<footer>palpate {}. Medians of many calls, methods of a case in turn, in one run on this machine.</footer>\n\
         </main></body></html>",
        env!("CARGO_PKG_VERSION")
    );
    page
}

/// A drawing with the page's colours inside, to stand as a file of its own.
pub fn styled(svg: &str) -> String {
    let style = format!(
        "<style>{STYLE}svg{{background:var(--card);font-family:system-ui,sans-serif}}</style>\n<"
    );
    svg.replacen("\n<", &format!("\n{style}"), 1)
}
