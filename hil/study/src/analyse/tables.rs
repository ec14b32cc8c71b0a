//! The analysis as tables, for one's own statistics.

use super::{Analysis, Within};

fn row(cells: &[String]) -> String {
    let quoted = cells
        .iter()
        .map(|cell| match cell.contains([',', '"', '\n']) {
            true => format!("\"{}\"", cell.replace('"', "\"\"")),
            false => cell.clone(),
        });
    let cells: Vec<String> = quoted.collect();
    format!("{}\n", cells.join(","))
}

fn within(of: Option<&Within>) -> [String; 3] {
    of.map_or_else(Default::default, |w| {
        [w.value, w.low, w.high].map(|v| v.to_string())
    })
}

/// Each table that has rows, by the name of its file.
#[must_use]
pub fn tables(of: &Analysis) -> Vec<(String, String)> {
    [
        ("levels.csv", levels(of)),
        ("drawings.csv", drawings(of)),
        ("ratings.csv", ratings(of)),
        ("comparisons.csv", comparisons(of)),
        ("choices.csv", choices(of)),
        ("confusion.csv", confusion(of)),
    ]
    .into_iter()
    .filter(|(_, text)| text.lines().count() > 1)
    .map(|(name, text)| (name.into(), text))
    .collect()
}

fn levels(of: &Analysis) -> String {
    let mut text = String::from("participant,task,wire,estimate_db,low_db,high_db,trials\n");
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
            text += &row(&[
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
    text
}

fn drawings(of: &Analysis) -> String {
    let mut text = String::from("participant,trial,condition,rmse_mm,lag,frechet_mm,breaks\n");
    for person in &of.participants {
        for d in &person.drawings {
            text += &row(&[
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
    text
}

fn ratings(of: &Analysis) -> String {
    let mut text = String::from("scale,condition,people,median,low,high\n");
    for r in &of.ratings {
        let people = r.values.len().to_string();
        let mut cells = vec![r.scale.clone(), r.condition.clone(), people];
        cells.extend(within(r.median.as_ref()));
        text += &row(&cells);
    }
    text
}

fn comparisons(of: &Analysis) -> String {
    let mut text = String::from(
        "scale,first,second,people_first,people_second,u,p,effect,effect_low,effect_high\n",
    );
    for c in &of.comparisons {
        let mut cells = vec![c.of.clone(), c.first.clone(), c.second.clone()];
        cells.extend(c.counts.map(|n| n.to_string()));
        cells.extend([c.u.to_string(), c.p.to_string()]);
        cells.extend(within(Some(&c.effect)));
        text += &row(&cells);
    }
    text
}

fn choices(of: &Analysis) -> String {
    let mut text = String::from("first,second,part_second,low,high,people_second,people_first,p\n");
    for c in &of.choices {
        let mut cells = c.pair.to_vec();
        cells.extend(within(c.part.as_ref()));
        cells.extend(c.people.map(|n| n.to_string()));
        cells.push(c.p.to_string());
        text += &row(&cells);
    }
    text
}

fn confusion(of: &Analysis) -> String {
    let mut text = String::from("wire,taken_for,answers\n");
    for (wire, counts) in of.confusion.iter().enumerate() {
        for (other, count) in counts.iter().enumerate() {
            text += &row(&[wire.to_string(), other.to_string(), count.to_string()]);
        }
    }
    text
}
