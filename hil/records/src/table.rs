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

#[cfg(test)]
#[path = "table_tests.rs"]
mod tests;
