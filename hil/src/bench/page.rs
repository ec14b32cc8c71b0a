//! The measurements as one HTML page that needs nothing else.

use palpate_records::report::STYLE;
use palpate_records::report::svg::escape;
use std::fmt::Write;

use super::{Findings, table};

/// All families on a page.
pub fn html(found: &[(&'static str, Findings)]) -> String {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>benchmarks \u{b7} palpate</title>\n<style>\n{STYLE}</style></head>\n<body><main>\
         <header><h1>Benchmarks</h1></header>\n"
    );
    for (family, findings) in found {
        for plot in &findings.plots {
            let _ = writeln!(
                page,
                "<section><h2>{} \u{b7} {}</h2><p class=\"sub\">{}</p>\n<div class=\"wide\">{}</div>{}</section>",
                escape(family),
                escape(&plot.title),
                escape(&plot.words),
                plot.svg(),
                plot.legend()
            );
        }
        for figure in &findings.figures {
            let _ = writeln!(
                page,
                "<section><h2>{} \u{b7} {}</h2><p class=\"sub\">{}</p>\n<div class=\"wide\">{}</div></section>",
                escape(family),
                escape(&figure.title),
                escape(&figure.words),
                figure.svg
            );
        }
        rows(&mut page, family, findings);
    }
    let _ = writeln!(
        page,
        "<footer>palpate {}. Medians of many calls, methods of a case in turn, in one run on this machine.</footer>\n\
         </main></body></html>",
        env!("CARGO_PKG_VERSION")
    );
    page
}

fn rows(page: &mut String, family: &str, findings: &Findings) {
    let _ = writeln!(
        page,
        "<section><h2>{} \u{b7} table</h2><table><tr><th>case</th><th>method</th>\
         <th class=\"num\">median</th><th class=\"num\">error</th><th></th></tr>",
        escape(family)
    );
    let mut case = "";
    for row in &findings.rows {
        let _ = writeln!(
            page,
            "<tr><td>{}</td><td>{}</td><td class=\"num\">{}</td><td class=\"num\">{}</td><td class=\"kind\">{}</td></tr>",
            if row.case == case {
                String::new()
            } else {
                escape(&row.case)
            },
            escape(&row.method),
            table::time(row.median_us),
            escape(&table::error(row.error, row.error_unit)),
            if row.peer { "peer" } else { "" }
        );
        case = &row.case;
    }
    page.push_str("</table>");
    for sentence in &findings.words {
        let _ = writeln!(page, "<p class=\"sub words\">{}</p>", escape(sentence));
    }
    page.push_str("</section>\n");
}
