//! The analysis as tables, for one's own statistics.

use super::{Analysis, Chosen, Comparison, Rated, Within};

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

fn within(of: Option<&Within>) -> [String; 3] {
    of.map_or_else(Default::default, |w| {
        [w.value, w.low, w.high].map(|v| v.to_string())
    })
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
            "scale,first,second,people_first,people_second,u,p,effect,effect_low,effect_high",
            comparisons(of),
        ),
        table(
            "choices.csv",
            "first,second,part_second,low,high,people_second,people_first,p",
            choices(of),
        ),
        table("confusion.csv", "wire,taken_for,answers", confusion(of)),
    ];
    all.into_iter().filter(|t| !t.rows.is_empty()).collect()
}

fn levels(of: &Analysis) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for person in &of.participants {
        let tasks = [
            ("absolute_threshold", &person.thresholds),
            ("difference", &person.differences),
            ("matching", &person.matches),
        ];
        for (task, wire) in tasks
            .iter()
            .flat_map(|(task, found)| found.iter().map(move |w| (task, w)))
        {
            let e = wire.estimate;
            let trials: u32 = wire.levels.iter().map(|(.., all)| all).sum();
            rows.push(vec![
                person.number.to_string(),
                (*task).to_owned(),
                wire.wire.to_string(),
                e.value.to_string(),
                e.low.to_string(),
                e.high.to_string(),
                trials.to_string(),
            ]);
        }
    }
    rows
}

fn drawings(of: &Analysis) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for person in &of.participants {
        for d in &person.drawings {
            rows.push(vec![
                person.number.to_string(),
                d.trial.to_string(),
                d.condition.clone(),
                d.error.rmse_mm.to_string(),
                d.error.lag.to_string(),
                d.error.frechet_mm.to_string(),
                d.error.breaks.to_string(),
            ]);
        }
    }
    rows
}

fn ratings(of: &Analysis) -> Vec<Vec<String>> {
    let row = |r: &Rated| {
        let people = r.values.len().to_string();
        let mut cells = vec![r.scale.clone(), r.condition.clone(), people];
        cells.extend(within(r.median.as_ref()));
        cells
    };
    of.ratings.iter().map(row).collect()
}

fn comparisons(of: &Analysis) -> Vec<Vec<String>> {
    let row = |c: &Comparison| {
        let mut cells = vec![c.of.clone(), c.first.clone(), c.second.clone()];
        cells.extend(c.counts.map(|n| n.to_string()));
        cells.extend([c.u.to_string(), c.p.to_string()]);
        cells.extend(within(Some(&c.effect)));
        cells
    };
    of.comparisons.iter().map(row).collect()
}

fn choices(of: &Analysis) -> Vec<Vec<String>> {
    let row = |c: &Chosen| {
        let mut cells = c.pair.to_vec();
        cells.extend(within(c.part.as_ref()));
        cells.extend(c.people.map(|n| n.to_string()));
        cells.push(c.p.to_string());
        cells
    };
    of.choices.iter().map(row).collect()
}

fn confusion(of: &Analysis) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    for (wire, counts) in of.confusion.iter().enumerate() {
        for (other, count) in counts.iter().enumerate() {
            rows.push(vec![wire.to_string(), other.to_string(), count.to_string()]);
        }
    }
    rows
}
