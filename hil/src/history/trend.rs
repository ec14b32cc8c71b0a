//! Summaries in a folder as series over time: the runs of one scene on one bench with one seed.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use palpate_files::{FileError, Format, read_text};
use palpate_records::report::svg::escape;
use palpate_records::runs::{MEASURED, Values, number};
use palpate_records::verdict::Verdict;
use serde_json::Value;

use super::difference::{Compared, Tolerance};
use super::objects::compare_objects;
use crate::clock;
use crate::sweep::chart::{LINES, Line, Spot, chart, ends, legend, with_unit};
use crate::sweep::{foot, head};

/// Longest summary that is read.
const MOST: u64 = 64 << 20;
/// How deep folders are searched.
const DEPTH: usize = 8;
/// Where a summary has each of [`MEASURED`]; the used part of the limits is in a list.
const PLACES: [&str; MEASURED.len()] = [
    "/path_error_mm/rmse",
    "/path_error_mm/max",
    "/felt_error_mm/rmse",
    "/felt_error_mm/max",
    "/felt/level_db/median",
    "/felt_error_mm/breaks",
    "/felt_error_mm/jumps",
    "/hottest_skin_c",
    "/hottest_wire_c",
    "/energy_mj",
    "/peak_supply_a",
    "/margins",
    "/limiter_events",
    "/contacts",
    "/stimuli",
    "/texture/roughness",
    "/taxels/refresh_hz/median",
];
/// The figures of the table; the page has all.
const SHOWN: [usize; 5] = [0, 2, 4, 7, 11];

/// A summary of an earlier run.
#[derive(Clone, Debug)]
pub struct Earlier {
    /// Its file.
    pub file: PathBuf,
    /// When it was made, as the summary says, else as the file does.
    pub date: String,
    /// The program's version.
    pub version: String,
    /// How the run ended.
    pub verdict: String,
    values: Values,
    summary: Value,
}

/// The runs of one scene on one bench with one seed, oldest first.
#[derive(Clone, Debug)]
pub struct Trend {
    /// Scene, bench and seed.
    pub name: String,
    /// The runs.
    pub runs: Vec<Earlier>,
}

/// Every summary in a folder and those below it, as trends in the order of their names.
///
/// # Errors
/// A folder that cannot be read, JSON that is broken, and a folder without a summary.
pub fn trends(folder: &Path) -> Result<Vec<Trend>, FileError> {
    let mut found: BTreeMap<String, Vec<Earlier>> = BTreeMap::new();
    search(folder, DEPTH, &mut found)?;
    if found.is_empty() {
        let label = folder.display().to_string();
        let expected =
            "summaries (`hil run --out DIR`, `hil run --json`) in files that end in .json";
        return Err(FileError::whole(label, expected, "none"));
    }
    let trend = |(name, mut runs): (String, Vec<Earlier>)| {
        runs.sort_by(|a, b| (&a.date, &a.file).cmp(&(&b.date, &b.file)));
        Trend { name, runs }
    };
    Ok(found.into_iter().map(trend).collect())
}

fn search(
    folder: &Path,
    depth: usize,
    found: &mut BTreeMap<String, Vec<Earlier>>,
) -> Result<(), FileError> {
    let label = folder.display().to_string();
    let bad = |e: std::io::Error| FileError::whole(&label, "a readable folder", e.to_string());
    for entry in fs::read_dir(folder).map_err(bad)? {
        let path = entry.map_err(bad)?.path();
        let hidden = path
            .file_name()
            .is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if path.is_dir() && !hidden && !path.is_symlink() && depth > 0 {
            search(&path, depth - 1, found)?;
        } else if path.is_file()
            && path.extension().is_some_and(|e| e == "json")
            && let Some((name, earlier)) = read(&path)?
        {
            found.entry(name).or_default().push(earlier);
        }
    }
    Ok(())
}

/// A summary with the name of its series; none for other JSON.
fn read(path: &Path) -> Result<Option<(String, Earlier)>, FileError> {
    let text = read_text(path, "a summary (JSON)", MOST)?;
    if Format::of(text.as_bytes()) != Some(Format::Json) {
        return Ok(None);
    }
    let summary: Value = serde_json::from_str(&text).map_err(|e| {
        FileError::whole(
            path.display().to_string(),
            "a summary (JSON)",
            e.to_string(),
        )
    })?;
    let text = |key: &str| summary.get(key).and_then(Value::as_str).map(str::to_owned);
    let known = text("verdict")
        .zip(text("scene"))
        .zip(text("bench"))
        .zip(summary.get("seed"));
    let Some((((verdict, scene), bench), seed)) =
        known.filter(|_| summary.get("margins").is_some())
    else {
        return Ok(None);
    };
    let name = format!("{scene} on {bench}, seed {seed}");
    let written = || {
        let modified = fs::metadata(path).and_then(|there| there.modified()).ok();
        let since = modified.and_then(|at| at.duration_since(std::time::UNIX_EPOCH).ok());
        since.map_or_else(String::new, |since| clock::date(since.as_micros() as u64))
    };
    let earlier = Earlier {
        file: path.to_path_buf(),
        date: text("date").unwrap_or_else(written),
        version: text("version").unwrap_or_else(|| "-".to_owned()),
        verdict,
        values: values(&summary),
        summary,
    };
    Ok(Some((name, earlier)))
}

fn values(summary: &Value) -> Values {
    PLACES.map(|place| match summary.pointer(place)? {
        Value::Array(margins) => {
            let used = margins
                .iter()
                .filter_map(|margin| margin.get("used")?.as_f64());
            ends(used).map(|(_, most)| most * 100.0)
        }
        value => value.as_f64(),
    })
}

impl Trend {
    /// The newest run held against the one before; of a single one there is nothing to say.
    pub fn newest(&self, tolerance: Tolerance) -> Option<Compared> {
        match self.runs.as_slice() {
            [.., before, newest] => {
                Some(compare_objects(&before.summary, &newest.summary, tolerance))
            }
            _ => None,
        }
    }

    /// The runs as lines of text under a heading.
    pub fn table(&self) -> Vec<String> {
        let heading = SHOWN.map(|n| with_unit(MEASURED[n].words, MEASURED[n].unit));
        let columns = |cells: [String; SHOWN.len()]| {
            let cells = cells.iter().zip(&heading);
            let cells =
                cells.map(|(cell, heading)| format!("  {cell:>0$}", heading.chars().count()));
            cells.collect::<String>()
        };
        let mut lines = vec![self.name.clone()];
        let line = |date: &str, version: &str, verdict: &str, rest: &str| {
            format!("  {date:<21} {version:<8} {verdict:<14}{rest}")
        };
        lines.push(line(
            "date",
            "version",
            "verdict",
            &columns(heading.clone()),
        ));
        for run in &self.runs {
            let values = SHOWN.map(|n| shown(run.values[n]));
            let rest = format!("{}  {}", columns(values), run.file.display());
            lines.push(line(&run.date, &run.version, &run.verdict, &rest));
        }
        lines
    }

    /// A figure over the runs, oldest first.
    fn line(&self, figure: usize) -> Line {
        let spot = |(n, run): (usize, &Earlier)| Spot::of((n + 1) as f64, &[run.values[figure]?]);
        Line {
            name: self.name.clone(),
            spots: self.runs.iter().enumerate().filter_map(spot).collect(),
        }
    }
}

/// A value to the thousandth; `-` for none.
fn shown(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), |v| number((v * 1e3).round() / 1e3))
}

/// All trends as a page.
pub fn page(trends: &[Trend], compared: &Compared) -> String {
    let mut out = head("Trends", &compared.conclusion);
    for some in trends.chunks(LINES) {
        out.push_str("<section><h2>Figures over the runs</h2><p class=\"sub\">Oldest first; the tables below say when each was.</p>\n<div class=\"charts\">");
        let mut names = String::new();
        for (n, measured) in MEASURED.iter().enumerate() {
            let lines: Vec<Line> = some.iter().map(|trend| trend.line(n)).collect();
            if lines.iter().any(|line| !line.spots.is_empty()) {
                out.push_str(&chart(
                    &lines,
                    "run",
                    &with_unit(measured.words, measured.unit),
                ));
                names = legend(&lines);
            }
        }
        let _ = writeln!(out, "</div>{names}</section>");
    }
    for trend in trends {
        let _ = write!(
            out,
            "<section><h2>{}</h2><div class=\"wide\"><table><tr><th class=\"num\">run</th><th>date</th><th>version</th><th>verdict</th>",
            escape(&trend.name)
        );
        for n in SHOWN {
            let _ = write!(
                out,
                "<th class=\"num\">{}</th>",
                escape(&with_unit(MEASURED[n].words, MEASURED[n].unit))
            );
        }
        out.push_str("<th>file</th></tr>\n");
        for (n, run) in trend.runs.iter().enumerate() {
            let over = if run.verdict == Verdict::Ok.key() {
                ""
            } else {
                " class=\"over\""
            };
            let (date, version, verdict) = (
                escape(&run.date),
                escape(&run.version),
                escape(&run.verdict),
            );
            let _ = write!(
                out,
                "<tr{over}><td class=\"num\">{}</td><td>{date}</td><td>{version}</td><td>{verdict}</td>",
                n + 1
            );
            for n in SHOWN {
                let _ = write!(out, "<td class=\"num\">{}</td>", shown(run.values[n]));
            }
            let _ = writeln!(
                out,
                "<td>{}</td></tr>",
                escape(&run.file.display().to_string())
            );
        }
        out.push_str("</table></div></section>\n");
    }
    out + &foot()
}
