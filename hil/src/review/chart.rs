//! Two strip charts one above the other: every row that differs as it was and, below it, as it is.

use palpate_records::story::Story;

/// Stretches of a chart shown unless all are asked for.
pub const BLOCKS: usize = 2;

/// A stretch of time: its ruler and its rows.
type Block<'a> = Vec<&'a str>;

/// Heading and stretches of a chart.
fn blocks(chart: &[String]) -> (Vec<&str>, Vec<Block<'_>>) {
    let is_ruler = |line: &str| {
        line.trim_start().starts_with(|c: char| c.is_ascii_digit()) && line.contains('|')
    };
    let mut lines = chart.iter().map(String::as_str).peekable();
    let mut heading = Vec::new();
    while let Some(line) = lines.next_if(|l| !is_ruler(l)) {
        heading.push(line);
    }
    let mut all: Vec<Block<'_>> = Vec::new();
    for line in lines {
        if is_ruler(line) {
            all.push(vec![line]);
        } else if let (Some(block), false) = (all.last_mut(), line.is_empty()) {
            block.push(line);
        }
    }
    (heading, all)
}

/// The stretches that differ, at most `most`: a ruler, then each row; one that changed stands there twice, `-` as
/// it was and `+` as it is.
pub fn stacked(old: &Story, new: &Story, most: usize) -> Vec<String> {
    let ((heading_a, a), (heading_b, b)) = (blocks(&old.chart), blocks(&new.chart));
    let mut out = Vec::new();
    let mut differing = 0;
    for index in 0..a.len().max(b.len()) {
        let none = Vec::new();
        let (x, y) = (a.get(index).unwrap_or(&none), b.get(index).unwrap_or(&none));
        if x == y && heading_a == heading_b {
            continue;
        }
        differing += 1;
        if differing > most {
            continue;
        }
        if differing == 1 {
            if heading_a == heading_b {
                out.extend(heading_b.iter().map(|l| format!("  {}", l.trim_start())));
            } else {
                out.extend(heading_a.iter().map(|l| format!("- {}", l.trim_start())));
                out.extend(heading_b.iter().map(|l| format!("+ {}", l.trim_start())));
            }
        }
        if differing > 1 {
            out.push(String::new());
        }
        for row in 0..x.len().max(y.len()) {
            let (was, is) = (x.get(row), y.get(row));
            if was == is {
                out.extend(is.map(|l| format!("  {l}")));
            } else {
                out.extend(was.map(|l| format!("- {l}")));
                out.extend(is.map(|l| format!("+ {l}")));
            }
        }
    }
    if differing > most {
        out.push(format!("  .. and {} stretches more", differing - most));
    }
    out
}

#[cfg(test)]
#[path = "chart_tests.rs"]
mod tests;
