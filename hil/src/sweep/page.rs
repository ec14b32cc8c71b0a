//! A table of runs as a page: each swept number against the figures, with the spread over seeds.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use palpate_records::report::page;
use palpate_records::report::svg::escape;
use palpate_records::runs::{MEASURED, RunRow, number};
use palpate_records::verdict::Conclusion;

use super::chart::{LINES, Line, Spot, chart, ends, legend};

/// The begin of a page: heading and verdict.
pub fn head(title: &str, conclusion: &Conclusion) -> String {
    format!(
        "{}<header><h1>{}</h1></header>\n{}",
        page::head(title),
        escape(title),
        page::verdict(conclusion.verdict, &conclusion.why)
    )
}

/// Script that shows the values of charts under the pointer.
const SCRIPT: &str = include_str!("values.js");

/// The end of a page.
pub fn foot() -> String {
    page::foot(
        ". Every value here comes from emulated hardware and a model of the skin.",
        &format!("<script>\n{SCRIPT}</script>\n"),
    )
}

/// The page of a sweep.
pub fn page(conclusion: &Conclusion, rows: &[&RunRow]) -> String {
    let title = rows.first().map_or_else(
        || "Sweep".to_owned(),
        |row| {
            format!(
                "{} on {}, {} runs",
                row.key.scene,
                row.key.bench,
                rows.len()
            )
        },
    );
    let mut out = head(&title, conclusion);
    let swept = swept(rows);
    for key in &swept {
        section(&mut out, key, rows);
    }
    if swept.is_empty() {
        section(&mut out, SEED, rows);
    }
    constant(&mut out, rows);
    out + &foot()
}

/// Word in the place of a key where only seeds differ.
const SEED: &str = "seed";

/// The keys with several numbers among their values.
fn swept(rows: &[&RunRow]) -> Vec<String> {
    let mut values: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (key, value) in rows.iter().flat_map(|row| &row.key.set) {
        values.entry(key).or_default().insert(value);
    }
    let numbers = |all: &BTreeSet<&str>| all.len() > 1 && all.iter().all(|v| parse(v).is_some());
    values
        .into_iter()
        .filter(|(_, all)| numbers(all))
        .map(|(key, _)| key.to_owned())
        .collect()
}

fn parse(text: &str) -> Option<f64> {
    text.parse().ok().filter(|v: &f64| v.is_finite())
}

/// The unit that the name of a key ends with.
fn unit(key: &str) -> &'static str {
    let last = key.rsplit('_').next().unwrap_or_default();
    match last {
        _ if !key.contains('_') => "",
        "s" => "s",
        "ms" => "ms",
        "us" => "us",
        "mm" => "mm",
        "um" => "um",
        "ma" => "mA",
        "v" => "V",
        "hz" => "Hz",
        "n" => "N",
        "c" => "\u{b0}C",
        "ohm" => "Ohm",
        _ => "",
    }
}

/// Place of a run along a key.
fn place(row: &RunRow, key: &str) -> Option<f64> {
    match key {
        SEED => Some(row.key.seed as f64),
        key => parse(row.key.set.get(key)?),
    }
}

/// The lines of a figure over a key: one for each combination of the others' values, while these can be told apart.
fn lines(rows: &[&RunRow], key: &str, figure: &str) -> Vec<Line> {
    let mut differing: BTreeMap<&String, BTreeSet<&String>> = BTreeMap::new();
    for (other, value) in rows
        .iter()
        .flat_map(|row| &row.key.set)
        .filter(|(k, _)| *k != key)
    {
        differing.entry(other).or_default().insert(value);
    }
    differing.retain(|_, values| values.len() > 1);
    let name = |row: &RunRow| {
        let of = row
            .key
            .set
            .iter()
            .filter(|(k, _)| differing.contains_key(k));
        of.map(|(k, v)| format!("{k}={v}"))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let names: BTreeSet<String> = rows.iter().map(|row| name(row)).collect();
    let told = names.len() <= LINES;
    let mut found: BTreeMap<String, Vec<(f64, f64)>> = BTreeMap::new();
    for row in rows {
        let Some((x, y)) = place(row, key).zip(row.values.get(figure).copied()) else {
            continue;
        };
        let line = if told {
            name(row)
        } else {
            format!("all {} combinations of the other keys", names.len())
        };
        found.entry(line).or_default().push((x, y));
    }
    let line = |(name, mut points): (String, Vec<(f64, f64)>)| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        let places = points.chunk_by(|a, b| a.0.total_cmp(&b.0).is_eq());
        let spots = places.filter_map(|at| {
            let values: Vec<f64> = at.iter().map(|p| p.1).collect();
            Spot::around(at.first()?.0, &values)
        });
        Line {
            name,
            spots: spots.collect(),
        }
    };
    found.into_iter().map(line).collect()
}

/// The least and the most of a figure.
fn range(rows: &[&RunRow], figure: &str) -> Option<(f64, f64)> {
    ends(
        rows.iter()
            .filter_map(|row| row.values.get(figure).copied()),
    )
}

/// The figures over one key.
fn section(out: &mut String, key: &str, rows: &[&RunRow]) {
    let seeds: BTreeSet<u64> = rows.iter().map(|row| row.key.seed).collect();
    let over = match (key, seeds.len()) {
        (SEED, _) | (_, 1) => "Each dot is a run.".to_owned(),
        (_, n) => format!("Lines are means, bars reach from the least to the most of {n} seeds."),
    };
    let _ = writeln!(
        out,
        "<section><h2>{}</h2><p class=\"sub\">{over}</p>\n<div class=\"charts\">",
        escape(key)
    );
    let mut names = String::new();
    for measured in &MEASURED {
        if range(rows, measured.key).is_none_or(|(low, high)| low >= high) {
            continue;
        }
        let lines = lines(rows, key, measured.key);
        let y = (measured.words, measured.unit);
        out.push_str(&chart(&lines, (key, unit(key)), y));
        names = legend(&lines);
    }
    let _ = writeln!(out, "</div>{names}</section>");
}

/// The figures that are the same in every run, in words.
fn constant(out: &mut String, rows: &[&RunRow]) {
    let same = MEASURED.iter().filter_map(|measured| {
        let (low, high) = range(rows, measured.key)?;
        let text = format!("{} {} {}", measured.words, number(low), measured.unit);
        (low >= high).then(|| text.trim_end().to_owned())
    });
    let same: Vec<String> = same.collect();
    if !same.is_empty() {
        let text = escape(&same.join(", "));
        let _ = writeln!(
            out,
            "<section><h2>The same in every run</h2><p class=\"sub\">{text}</p></section>"
        );
    }
}

#[cfg(test)]
#[path = "page_tests.rs"]
mod tests;
