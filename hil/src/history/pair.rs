//! Two results as a page: figures beside each other.

use std::fmt::Write;

use palpate_records::report::page::table;
use palpate_records::report::svg::escape;

use super::difference::{Compared, Difference, Named};
use crate::sweep::chart::with_unit;
use crate::sweep::{foot, head};

/// The page of two results under the names of their files.
pub fn page_of_two(compared: &Compared, names: [&str; 2]) -> String {
    let mut out = head("Comparison", &compared.conclusion);
    if !compared.named.is_empty() {
        let row = |named: &Named| {
            let cells = vec![
                with_unit(named.figure, named.unit),
                Named::value(named.a),
                Named::value(named.b),
                named.grown(),
            ];
            (named.differs, cells)
        };
        let columns = [
            ("", "figure"),
            ("num", names[0]),
            ("num", names[1]),
            ("num", "change"),
        ];
        section(
            &mut out,
            "Figures, the weightiest first",
            &table(&columns, compared.named.iter().map(row)),
        );
    }
    if !compared.differences.is_empty() {
        let said = |text: &Option<String>| text.clone().unwrap_or_else(|| "-".into());
        let row = |d: &Difference| {
            let cells = vec![
                d.figure.clone(),
                said(&d.a),
                said(&d.b),
                d.grown(),
                d.detail.clone(),
            ];
            (false, cells)
        };
        let columns = [
            ("", "value"),
            ("num", names[0]),
            ("num", names[1]),
            ("num", "change"),
            ("", "where"),
        ];
        section(
            &mut out,
            &format!(
                "{} of {} values differ",
                compared.differences.len(),
                compared.figures
            ),
            &table(&columns, compared.differences.iter().map(row)),
        );
    }
    out + &foot()
}

fn section(out: &mut String, title: &str, table: &str) {
    let _ = writeln!(
        out,
        "<section><h2>{}</h2><div class=\"wide\" tabindex=\"0\">{table}</div></section>",
        escape(title)
    );
}
