//! The table of many runs: a row per run, with the key that says what ran, its verdict and its figures.
//!
//! Numbers are written to the billionth and never depend on who wrote or read them before, so that a table that was
//! interrupted, joined or computed elsewhere has the same bytes.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;
use serde_json::Value;

use crate::damage::Damage;
use crate::table::as_csv;
use crate::verdict::Verdict;

/// A figure of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Measured {
    /// Column of the figure.
    pub key: &'static str,
    /// Name for people.
    pub words: &'static str,
    /// Unit of the figure; empty for a count.
    pub unit: &'static str,
    /// The place in a summary; at a list of margins the figure is that of the most used one.
    place: &'static str,
}

const fn measured(
    key: &'static str,
    words: &'static str,
    unit: &'static str,
    place: &'static str,
) -> Measured {
    Measured {
        key,
        words,
        unit,
        place,
    }
}

/// The figures of a row, in the order of the columns.
#[rustfmt::skip]
pub const MEASURED: [Measured; 22] = [
    measured("path_error_rmse_mm", "path error RMSE", "mm", "/path_error_mm/rmse"),
    measured("path_error_max_mm", "path error at most", "mm", "/path_error_mm/max"),
    measured("felt_error_all_rmse_mm", "felt error RMSE, all onsets", "mm", "/felt_error_mm/everywhere/rmse"),
    measured("felt_error_all_max_mm", "felt error at most, all onsets", "mm", "/felt_error_mm/everywhere/max"),
    measured("felt_onsets_all", "onsets, all", "", "/felt_error_mm/everywhere/onsets"),
    measured("felt_error_rmse_mm", "felt error RMSE inside the wires", "mm", "/felt_error_mm/rmse"),
    measured("felt_error_max_mm", "felt error at most inside the wires", "mm", "/felt_error_mm/max"),
    measured("felt_onsets_inside", "onsets inside the wires", "", "/felt_error_mm/onsets"),
    measured("felt_level_db", "felt level over threshold", "dB", "/felt/level_db/median"),
    measured("felt_skin_um", "displacement of the skin, median", "um", "/felt/skin_um/median"),
    measured("felt_breaks", "breaks", "", "/felt_error_mm/breaks"),
    measured("felt_jumps", "jumps", "", "/felt_error_mm/jumps"),
    measured("hottest_skin_c", "hottest skin", "\u{b0}C", "/hottest_skin_c"),
    measured("hottest_wire_c", "hottest wire", "\u{b0}C", "/hottest_wire_c"),
    measured("energy_mj", "energy", "mJ", "/energy_mj"),
    measured("peak_supply_a", "supply current", "A", "/peak_supply_a"),
    measured("limit_used_percent", "most used limit", "%", "/margins"),
    measured("limiter_events", "limiter events", "", "/limiter_events"),
    measured("contacts", "contacts", "", "/contacts"),
    measured("stimuli", "stimuli", "", "/stimuli"),
    measured("roughness", "roughness", "", "/texture/roughness"),
    measured("taxel_hz", "taxel refresh, median", "Hz", "/taxels/refresh_hz/median"),
];

/// The figures that tell two results apart, the weightiest first: felt levels and places, margins of heat, and costs.
pub const WEIGHTIEST: [&str; 16] = [
    "felt_level_db",
    "felt_skin_um",
    "felt_breaks",
    "felt_error_all_rmse_mm",
    "felt_error_rmse_mm",
    "felt_jumps",
    "path_error_rmse_mm",
    "hottest_skin_c",
    "limit_used_percent",
    "limiter_events",
    "roughness",
    "contacts",
    "stimuli",
    "energy_mj",
    "peak_supply_a",
    "hottest_wire_c",
];

/// [`MEASURED`] by weight: [`WEIGHTIEST`], then what is left.
pub fn by_weight() -> impl Iterator<Item = &'static Measured> {
    let of = |key: &&str| MEASURED.iter().find(|m| m.key == *key);
    let rest = MEASURED.iter().filter(|m| !WEIGHTIEST.contains(&m.key));
    WEIGHTIEST.iter().filter_map(of).chain(rest)
}

/// Tells whether a part of a value in this unit says something: a level,
/// a temperature and a percentage have no zero to be a part from.
pub fn has_zero(unit: &str) -> bool {
    !["dB", "\u{b0}C", "C", "%"].contains(&unit)
}

/// Values of [`MEASURED`], by their keys; none where a run does not measure it.
pub type Values = BTreeMap<&'static str, f64>;

impl Measured {
    fn read(&self, summary: &Value) -> Option<f64> {
        let margins = match summary.pointer(self.place)? {
            Value::Array(margins) => margins,
            value => return value.as_f64(),
        };
        // Of a limit at rest a summary has no number: infinitely much of it is used.
        let used = |margin: &Value| margin.get("used").and_then(Value::as_f64);
        let used = margins.iter().map(|m| used(m).unwrap_or(f64::INFINITY));
        // Beyond a million times a limit the number says nothing more.
        used.reduce(f64::max).map(|most| (most * 100.0).min(1e8))
    }
}

/// The figures of a summary, as it is written or read.
pub fn values(summary: &impl Serialize) -> Values {
    let summary = serde_json::to_value(summary).unwrap_or_default();
    let read = |m: &Measured| Some((m.key, m.read(&summary)?));
    MEASURED.iter().filter_map(read).collect()
}

/// Key that tells a run from all others.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct RunKey {
    /// The scene's name.
    pub scene: String,
    /// Digest of the scene, the bench, and every file that they name.
    pub digest: String,
    /// The bench's name.
    pub bench: String,
    /// Values in place of the files' own, by key.
    pub set: BTreeMap<String, String>,
    /// Seed of all randomness.
    pub seed: u64,
    /// Version of the program that computed it.
    pub version: String,
}

impl RunKey {
    /// Returns the key with every swept value as [`by_number`] has it.
    pub fn by_number(&self) -> Self {
        let set = self.set.iter();
        Self {
            set: set.map(|(k, v)| (k.clone(), by_number(v))).collect(),
            ..self.clone()
        }
    }

    /// A run among those of its sweep: `at a=1, b=2, seed 3`.
    pub fn place(&self) -> String {
        let mut set: Vec<String> = self
            .set
            .iter()
            .map(|(key, value)| format!("{key}={value}"))
            .collect();
        set.push(format!("seed {}", self.seed));
        format!("at {}", set.join(", "))
    }
}

/// A run in the table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunRow {
    /// Key of the run.
    pub key: RunKey,
    /// Verdict of the run.
    pub verdict: Verdict,
    /// Reason of the verdict; empty where there is nothing to say.
    pub why: String,
    /// Measured values.
    pub values: Values,
}

/// A swept value as runs are told apart by: a number is the same however it is written, so `0.020` is `0.02`.
pub fn by_number(value: &str) -> String {
    // A float would take whole numbers beyond 2^53 for one another.
    if let Ok(whole) = value.parse::<i128>() {
        return whole.to_string();
    }
    match value.replace('_', "").parse::<f64>() {
        // Minus zero is zero.
        Ok(number) if number.is_finite() => (number + 0.0).to_string(),
        _ => value.to_owned(),
    }
}

/// Form in which a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableForm {
    /// Columns between commas; each swept key is a column.
    Csv,
    /// An object per line; the swept keys are the object `set`.
    Lines,
}

/// Columns before the swept keys, and after them.
const BEFORE: [&str; 3] = ["scene", "digest", "bench"];
const AFTER: [&str; 4] = ["seed", "version", "verdict", "why"];

/// A number as tables have it: to the billionth, without zeros at the end.
pub fn number(value: f64) -> String {
    let text = format!("{value:.9}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.to_owned()
}

/// A number as people read it: to the thousandth.
pub fn short(value: f64) -> String {
    number((value * 1e3).round() / 1e3)
}

impl TableForm {
    /// Heading of a table with these swept keys, in their order; empty where lines name their keys.
    pub fn head<'a>(self, swept: impl Iterator<Item = &'a str>) -> String {
        if self == Self::Lines {
            return String::new();
        }
        let measured = MEASURED.iter().map(|m| m.key);
        let all = BEFORE.into_iter().chain(swept).chain(AFTER).chain(measured);
        as_csv([all.collect::<Vec<_>>()])
    }

    /// A row as a line.
    pub fn line(self, row: &RunRow) -> String {
        let key = &row.key;
        let seed = key.seed.to_string();
        let values = MEASURED.map(|m| (m.key, row.values.get(m.key).map(|v| number(*v))));
        if self == Self::Csv {
            let before = [&*key.scene, &key.digest, &key.bench].into_iter();
            let swept = key.set.values().map(String::as_str);
            let after = [&*seed, &key.version, row.verdict.key(), &row.why];
            let values = values.iter().map(|v| v.1.as_deref().unwrap_or_default());
            let all = before.chain(swept).chain(after).chain(values);
            return as_csv([all.collect::<Vec<_>>()]);
        }
        let text = |text: &str| Value::from(text).to_string();
        let set: Vec<String> = key
            .set
            .iter()
            .map(|(k, v)| format!("{}:{}", text(k), text(v)))
            .collect();
        let mut line = format!(
            "{{\"scene\":{},\"digest\":{},\"bench\":{},\"set\":{{{}}},\"seed\":{seed},\"version\":{},\"verdict\":{},\"why\":{}",
            text(&key.scene),
            text(&key.digest),
            text(&key.bench),
            set.join(","),
            text(&key.version),
            text(row.verdict.key()),
            text(&row.why)
        );
        for (key, value) in &values {
            let value = value.as_deref().unwrap_or("null");
            let _ = write!(line, ",\"{key}\":{value}");
        }
        line + "}\n"
    }
}

/// The fields of a line of CSV; none where a quote stays open.
fn csv_fields(line: &str) -> Option<Vec<String>> {
    let line = format!("{line}\n");
    let (mut text, mut ends) = (vec![0; line.len()], vec![0; line.len()]);
    let (result, _, _, count) =
        csv_core::Reader::new().read_record(line.as_bytes(), &mut text, &mut ends);
    if result != csv_core::ReadRecordResult::Record {
        return None;
    }
    let starts = std::iter::once(0).chain(ends.iter().copied());
    let fields = starts
        .zip(&ends[..count])
        .map(|(start, &end)| &text[start..end]);
    fields
        .map(|field| String::from_utf8(field.to_vec()).ok())
        .collect()
}

/// A table that was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunTable {
    /// The rows, in the order of the file.
    pub rows: Vec<RunRow>,
    /// Bytes of its whole lines: what comes after them was cut off while it was written.
    pub whole: usize,
}

impl RunTable {
    /// Tells whether a text is such a table, by its begin.
    pub fn is_one(text: &str) -> bool {
        text.starts_with("scene,digest,bench,")
            || text.starts_with("{\"scene\":") && text.contains("\"digest\":")
    }

    /// Reads a table in either form. Tables may follow one another (`cat`), each with its heading. A last line that
    /// does not end is left out.
    ///
    /// # Errors
    /// The first line that is no row, or that contradicts an earlier one: both are of one key, and differ.
    pub fn read(text: &str) -> Result<Self, Damage> {
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let mut table = Self {
            rows: Vec::new(),
            whole,
        };
        let mut swept: Option<Vec<String>> = None;
        let mut numbers = Vec::new();
        let lines = text[..whole].trim_start_matches('\u{feff}').lines();
        for (number, line) in (1..).zip(lines) {
            let bad = |expected: &str| Damage::of_line(number, expected, line);
            if line.is_empty() {
                continue;
            }
            if line.starts_with('{') {
                let row = of_object(line).ok_or_else(|| bad("a row of a sweep (JSON)"))?;
                table.rows.push(row);
                numbers.push(number);
            } else if line.starts_with("scene,") {
                let keys = of_head(line).ok_or_else(|| bad("the heading of a sweep's table"))?;
                swept = Some(keys);
            } else {
                let keys = swept
                    .as_ref()
                    .ok_or_else(|| bad("the heading of a sweep's table"))?;
                let row = of_fields(line, keys).ok_or_else(|| bad("a row of a sweep (CSV)"))?;
                table.rows.push(row);
                numbers.push(number);
            }
        }
        match table.contradiction() {
            None => Ok(table),
            Some((first, second)) => {
                let place = table.rows[second].key.place();
                let expected = format!("what line {} says {place}", numbers[first]);
                let line = text.lines().nth(numbers[second] - 1).unwrap_or_default();
                Err(Damage::of_line(numbers[second], &expected, line))
            }
        }
    }

    /// The first row that differs from one of its key, behind that one.
    fn contradiction(&self) -> Option<(usize, usize)> {
        let rows = self.rows.iter().enumerate();
        let mut keys: Vec<(RunKey, usize)> =
            rows.map(|(n, row)| (row.key.by_number(), n)).collect();
        keys.sort_unstable();
        let of_one = keys.windows(2).filter(|pair| pair[0].0 == pair[1].0);
        let pairs = of_one.map(|pair| (pair[0].1, pair[1].1));
        let differ = pairs.filter(|&(before, row)| {
            let (before, row) = (&self.rows[before], &self.rows[row]);
            (before.verdict, &before.why, &before.values) != (row.verdict, &row.why, &row.values)
        });
        differ.min_by_key(|pair| pair.1)
    }
}

/// The swept keys of a heading.
fn of_head(line: &str) -> Option<Vec<String>> {
    let fields = csv_fields(line)?;
    let swept = fields
        .len()
        .checked_sub(BEFORE.len() + AFTER.len() + MEASURED.len())?;
    let keys = fields.get(BEFORE.len()..BEFORE.len() + swept)?;
    let expected = TableForm::Csv.head(keys.iter().map(String::as_str));
    (expected.trim_end() == line).then(|| keys.to_vec())
}

fn of_fields(line: &str, swept: &[String]) -> Option<RunRow> {
    let fields = csv_fields(line)?;
    let mut fields = fields.into_iter();
    let mut text = || fields.next();
    let (scene, digest, bench) = (text()?, text()?, text()?);
    let mut set = BTreeMap::new();
    for key in swept {
        set.insert(key.clone(), text()?);
    }
    let (seed, version, verdict, why) = (text()?, text()?, text()?, text()?);
    let mut values = Values::default();
    for measured in MEASURED {
        let value = text()?;
        if !value.is_empty() {
            let value = value.parse().ok().filter(|v: &f64| v.is_finite())?;
            values.insert(measured.key, value);
        }
    }
    let key = RunKey {
        scene,
        digest,
        bench,
        set,
        seed: seed.parse().ok()?,
        version,
    };
    let verdict = Verdict::of_key(&verdict)?;
    fields.next().is_none().then_some(RunRow {
        key,
        verdict,
        why,
        values,
    })
}

fn of_object(line: &str) -> Option<RunRow> {
    let object: Value = serde_json::from_str(line).ok()?;
    let text = |key: &str| object.get(key)?.as_str().map(str::to_owned);
    let mut set = BTreeMap::new();
    for (key, value) in object.get("set")?.as_object()? {
        set.insert(key.clone(), value.as_str()?.to_owned());
    }
    let mut values = Values::default();
    for measured in MEASURED {
        let value = object.get(measured.key)?;
        if !value.is_null() {
            values.insert(measured.key, value.as_f64()?);
        }
    }
    Some(RunRow {
        key: RunKey {
            scene: text("scene")?,
            digest: text("digest")?,
            bench: text("bench")?,
            set,
            seed: object.get("seed")?.as_u64()?,
            version: text("version")?,
        },
        verdict: Verdict::of_key(&text("verdict")?)?,
        why: text("why")?,
        values,
    })
}

#[cfg(test)]
#[path = "runs_tests.rs"]
mod tests;
