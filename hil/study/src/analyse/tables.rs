//! The analysis as tables, for one's own statistics.

use std::fmt::Display;

use palpate_files::TaskKind;

use super::{Analysis, Chosen, Comparison, Rated};
use crate::quest::Estimate;

/// A table of an analysis.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AnalysisTable {
    /// The name of its file.
    pub file: &'static str,
    /// The names of its columns, between commas.
    pub head: &'static str,
    /// The cells of every row.
    pub rows: Vec<Vec<String>>,
}

/// The cells of a row.
fn row(cells: &[&dyn Display]) -> Vec<String> {
    cells.iter().map(|cell| cell.to_string()).collect()
}

/// The cells of a row that ends with an estimate; its cells are empty where there is none.
fn with_estimate(cells: &[&dyn Display], of: Option<&Estimate>) -> Vec<String> {
    let estimate = of.map_or_else(Default::default, |e| {
        [e.value, e.low, e.high].map(|v| v.to_string())
    });
    row(cells).into_iter().chain(estimate).collect()
}

/// Each table that has rows.
#[must_use]
pub fn tables(of: &Analysis) -> Vec<AnalysisTable> {
    let table = |file, head, rows| AnalysisTable { file, head, rows };
    let all = [
        table(
            "levels.csv",
            "participant,task,wire,estimate_db,low_db,high_db,trials",
            levels(of),
        ),
        table(
            "drawings.csv",
            "participant,trial,condition,rmse_mm,lag,frechet_mm,breaks",
            drawings(of),
        ),
        table(
            "ratings.csv",
            "scale,condition,people,median,low,high",
            ratings(of),
        ),
        table(
            "comparisons.csv",
            "scale,first,second,people_first,people_second,u,p,effect,effect_low,effect_high,least_p",
            comparisons(of),
        ),
        table(
            "choices.csv",
            "first,second,part_second,low,high,people_second,people_first,p,least_p",
            choices(of),
        ),
        table("confusion.csv", "wire,taken_for,answers", confusion(of)),
    ];
    all.into_iter().filter(|t| !t.rows.is_empty()).collect()
}

fn levels(of: &Analysis) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for person in &of.participants {
        for (task, found) in [
            (TaskKind::AbsoluteThreshold, &person.thresholds),
            (TaskKind::Difference, &person.differences),
            (TaskKind::Matching, &person.matches),
        ] {
            rows.extend(found.iter().map(|wire| {
                let trials: u32 = wire.levels.iter().map(|(.., all)| all).sum();
                let cells: [&dyn Display; 3] = [&person.number, &task.name(), &wire.wire];
                let mut cells = with_estimate(&cells, Some(&wire.estimate));
                cells.push(trials.to_string());
                cells
            }));
        }
    }
    rows
}

fn drawings(of: &Analysis) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for person in &of.participants {
        for drawing in &person.drawings {
            let e = &drawing.error;
            let mut cells = row(&[&person.number, &drawing.trial, &drawing.condition]);
            cells.extend(row(&[&e.rmse_mm, &e.lag, &e.frechet_mm, &e.breaks]));
            rows.push(cells);
        }
    }
    rows
}

fn ratings(of: &Analysis) -> Vec<Vec<String>> {
    let cells = |r: &Rated| {
        let people = r.values.len();
        with_estimate(&[&r.scale, &r.condition, &people], r.median.as_ref())
    };
    of.ratings.iter().map(cells).collect()
}

fn comparisons(of: &Analysis) -> Vec<Vec<String>> {
    let cells = |c: &Comparison| {
        let [first, second] = &c.counts;
        let cells: [&dyn Display; 7] = [&c.of, &c.first, &c.second, first, second, &c.u, &c.p];
        let mut cells = with_estimate(&cells, Some(&c.effect));
        cells.push(c.least_p.to_string());
        cells
    };
    of.comparisons.iter().map(cells).collect()
}

fn choices(of: &Analysis) -> Vec<Vec<String>> {
    let cells = |c: &Chosen| {
        let ([first, second], [people_second, people_first]) = (&c.pair, &c.people);
        let mut cells = with_estimate(&[first, second], c.part.as_ref());
        cells.extend(row(&[people_second, people_first, &c.p, &c.least_p]));
        cells
    };
    of.choices.iter().map(cells).collect()
}

fn confusion(of: &Analysis) -> Vec<Vec<String>> {
    let wires = of.confusion.iter().enumerate();
    let all = wires.flat_map(|(wire, counts)| {
        let others = counts.iter().enumerate();
        others.map(move |(other, count)| row(&[&wire, &other, count]))
    });
    all.collect()
}
