//! Tables of text: what every command writes as CSV.

use serde::Serialize;

/// Rows as CSV, a line each; a field stands in quotes where it needs them. Rows may be tuples, arrays and lists, in one another
/// too.
pub fn as_csv(rows: impl IntoIterator<Item = impl Serialize>) -> String {
    let mut table = csv::WriterBuilder::new()
        .has_headers(false)
        .flexible(true)
        .from_writer(Vec::new());
    for row in rows {
        // Writing to memory does not fail.
        let _ = table.serialize(row);
    }
    let text = table.into_inner().unwrap_or_default();
    String::from_utf8(text).unwrap_or_default()
}

/// A text as a cell or a line of a terminal may have it: what moves a cursor, ends a line or turns letters round stands
/// escaped, such as `\r` or `\u{1b}`.
pub fn plain(text: &str) -> String {
    let moves =
        |c: char| c.is_control() || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let mut plain = String::with_capacity(text.len());
    for c in text.chars() {
        match moves(c) {
            true => plain.extend(c.escape_default()),
            false => plain.push(c),
        }
    }
    plain
}

#[cfg(test)]
#[path = "table_tests.rs"]
mod tests;
