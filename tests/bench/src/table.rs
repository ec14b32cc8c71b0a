//! The rows as a table, one block per case.

use std::fmt::Write;

use crate::findings::Findings;
use crate::units::{error, time};

/// A family's rows and sentences.
pub fn text(findings: &Findings) -> String {
    let mut out = format!("{}\n", findings.family);
    let width = findings.rows.iter().map(|r| r.method.len()).max();
    let width = width.unwrap_or(0).max(7);
    let mut case = "";
    out.push_str(&findings.table);
    let shown = findings.rows.iter().filter(|_| findings.table.is_empty());
    for row in shown {
        if case != row.case {
            let _ = writeln!(out, "\n  {}", row.case);
            case = &row.case;
        }
        let _ = writeln!(
            out,
            "    {:width$}  {:>10}  {}{}",
            row.method,
            time(row.median_us),
            error(row.error, row.error_unit),
            if row.peer { "  (peer)" } else { "" }
        );
    }
    out.push('\n');
    for sentence in &findings.words {
        let _ = writeln!(out, "  {sentence}");
    }
    out.push('\n');
    out
}
