//! Two tables of sweeps held against each other, run by run and told figure by figure.

use std::collections::BTreeMap;

use palpate_core::statistics;
use palpate_records::runs::{MEASURED, Measured, RunKey, RunRow, RunTable, by_weight};
use palpate_records::verdict::Verdict;

use super::difference::{Compared, Difference, Tolerance};

/// Key that pairs runs of two tables, values by number. Digests of
/// files and versions are left out of it, since they may differ.
fn paired(key: &RunKey) -> RunKey {
    RunKey {
        digest: String::new(),
        version: String::new(),
        ..key.by_number()
    }
}

/// Holds the runs that both tables have against each other. Runs that one of them lacks, or has in two ways, make it
/// incomplete.
pub fn compare_tables(a: &RunTable, b: &RunTable, tolerance: Tolerance) -> Compared {
    let mut compared = Compared::default();
    let mut by_key = |table: &RunTable, which: &str| {
        let mut all: BTreeMap<RunKey, RunRow> = BTreeMap::new();
        let mut twice = 0;
        for row in &table.rows {
            let other =
                |before: RunRow| before.verdict != row.verdict || before.values != row.values;
            let before = all.insert(paired(&row.key), row.clone());
            twice += usize::from(before.is_some_and(other));
        }
        if twice > 0 {
            let text = format!(
                "the {which} table has {twice} runs of another version or digest too, which differ"
            );
            compared.conclusion.add(Verdict::Incomplete, text);
        }
        all
    };
    let (of_a, of_b) = (by_key(a, "first"), by_key(b, "second"));
    let pairs: Vec<(&RunRow, &RunRow)> = of_a
        .iter()
        .filter_map(|(key, row)| Some((row, of_b.get(key)?)))
        .collect();
    for (table, other, which) in [(&of_a, &of_b, "second"), (&of_b, &of_a, "first")] {
        let lacking = table.keys().filter(|key| !other.contains_key(*key)).count();
        if lacking > 0 {
            let text = format!(
                "{lacking} of {} runs are not in the {which} table",
                table.len()
            );
            compared.conclusion.add(Verdict::Incomplete, text);
        }
    }
    if pairs.is_empty() {
        return compared.concluded();
    }
    compared.figures = MEASURED.len() + 1;
    let verdicts = pairs.iter().filter(|(a, b)| a.verdict != b.verdict);
    let mut verdicts = verdicts.peekable();
    if let Some((a, b)) = verdicts.peek().copied() {
        compared.differences.push(Difference {
            figure: "verdict".to_owned(),
            a: Some(a.verdict.word().to_owned()),
            b: Some(b.verdict.word().to_owned()),
            detail: format!(
                "{} of {} runs, first {}",
                verdicts.count(),
                pairs.len(),
                a.key.place()
            ),
            ..Difference::default()
        });
    }
    for measured in by_weight() {
        let name = format!("{} {}", measured.words, measured.unit);
        let difference = figure(&pairs, measured, tolerance);
        compared
            .differences
            .extend(difference.map(|difference| Difference {
                figure: name.trim_end().to_owned(),
                ..difference
            }));
    }
    compared.concluded()
}

/// The means of a figure, where it differs in any run, and where it does most.
fn figure(
    pairs: &[(&RunRow, &RunRow)],
    measured: &Measured,
    tolerance: Tolerance,
) -> Option<Difference> {
    let value = |row: &RunRow| row.values.get(measured.key).copied();
    let values = |(a, b): &(&RunRow, &RunRow)| (value(a), value(b));
    let differs = |pair: &&(&RunRow, &RunRow)| match values(pair) {
        (Some(x), Some(y)) => !tolerance.equal(x, y),
        (x, y) => x.is_some() != y.is_some(),
    };
    let differing: Vec<_> = pairs.iter().filter(differs).collect();
    let apart = |pair: &&&(&RunRow, &RunRow)| match values(pair) {
        (Some(x), Some(y)) => (x - y).abs(),
        _ => f64::INFINITY,
    };
    let most = differing
        .iter()
        .copied()
        .max_by(|a, b| apart(&a).total_cmp(&apart(&b)))?;
    let detail = {
        let single = Difference {
            figure: String::new(),
            detail: String::new(),
            ..difference(values(most), measured.unit)
        };
        let words = single.words();
        let runs = format!("{} of {} runs", differing.len(), pairs.len());
        format!("{runs}, most {}: {}", most.0.key.place(), words.trim())
    };
    type Pair = (Option<f64>, Option<f64>);
    let mean = |side: fn(Pair) -> Option<f64>| {
        statistics::mean(pairs.iter().filter_map(|pair| side(values(pair))))
    };
    Some(Difference {
        detail,
        ..difference((mean(|v| v.0), mean(|v| v.1)), measured.unit)
    })
}

/// The difference of two values, of which one may be missing.
fn difference((a, b): (Option<f64>, Option<f64>), unit: &str) -> Difference {
    match (a, b) {
        (Some(a), Some(b)) => Difference::of_numbers(String::new(), (a, b), unit),
        (a, b) => {
            let said = |v: Option<f64>| v.map(palpate_records::runs::number);
            Difference {
                a: said(a),
                b: said(b),
                ..Difference::default()
            }
        }
    }
}

#[cfg(test)]
#[path = "tables_tests.rs"]
mod tests;
