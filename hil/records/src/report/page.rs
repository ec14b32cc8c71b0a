//! Parts of every page: a head with the one style sheet, a verdict, tables, a foot.

use std::fmt::Write;

use super::svg::{STYLE, escape};
use crate::verdict::Verdict;

/// A page up to its content. It needs no other file.
pub fn head(title: &str) -> String {
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>{} \u{b7} palpate</title>\n<style>\n{STYLE}</style></head>\n<body><main>\n",
        escape(title)
    )
}

/// Verdict and its reasons.
pub fn verdict(verdict: Verdict, why: &[String]) -> String {
    let why = why
        .iter()
        .map(|why| format!("<span>{}</span>", escape(why)));
    format!(
        "<p class=\"verdict {}\" role=\"status\"><strong>{}</strong>{}</p>\n",
        verdict.key(),
        verdict.word(),
        why.collect::<String>()
    )
}

/// A table. Columns have a class, such as `num`, and a name; rows say whether they break a limit. Cells are plain text, and
/// HTML in columns of the class `html`.
pub fn table(
    columns: &[(&str, &str)],
    rows: impl IntoIterator<Item = (bool, Vec<String>)>,
) -> String {
    written(columns, rows, false)
}

/// A table of many columns. A narrow page shows each row as a list of names and values.
pub fn wide(
    columns: &[(&str, &str)],
    rows: impl IntoIterator<Item = (bool, Vec<String>)>,
) -> String {
    let table = written(columns, rows, true);
    format!("<div class=\"wide\" tabindex=\"0\">{table}</div>\n")
}

/// Writes a table; with `named` each cell repeats the name of its column.
fn written(
    columns: &[(&str, &str)],
    rows: impl IntoIterator<Item = (bool, Vec<String>)>,
    named: bool,
) -> String {
    let class = |class: &str| match class {
        "" | "html" => String::new(),
        class => format!(" class=\"{class}\""),
    };
    let mut out = String::from("<table><tr>");
    for (of, name) in columns {
        let _ = write!(out, "<th{}>{}</th>", class(of), escape(name));
    }
    out.push_str("</tr>\n");
    for (over, cells) in rows {
        let _ = write!(out, "<tr{}>", class(if over { "over" } else { "" }));
        for ((of, name), cell) in columns.iter().zip(&cells) {
            let text = match *of {
                "html" => cell.clone(),
                _ => escape(cell),
            };
            let name = match named {
                true => format!(" data-l=\"{}\"", escape(name)),
                false => String::new(),
            };
            let _ = write!(out, "<td{}{name}>{text}</td>", class(of));
        }
        out.push_str("</tr>\n");
    }
    out + "</table>\n"
}

/// The end of a page: the version that made it, followed by these words, and what comes after the content, such as a script.
pub fn foot(words: &str, after: &str) -> String {
    format!(
        "<footer>palpate {}{words}</footer>\n</main>\n{after}</body></html>\n",
        env!("CARGO_PKG_VERSION")
    )
}
