//! Summaries in a folder as series over time: the runs of one scene on one bench with one seed.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use palpate_files::{FileError, Format, entries, read_text};
use palpate_records::report::page::wide;
use palpate_records::report::svg::escape;
use palpate_records::runs::{MEASURED, Measured, Values, short, values};
use palpate_records::verdict::Verdict;
use serde_json::Value;

use super::difference::{Compared, Tolerance};
use super::objects::compare_objects;
use crate::sweep::chart::{LINES, Line, Spot, chart, legend, with_unit};
use crate::sweep::{foot, head};
use palpate_live::clock;

/// Longest summary that is read.
const MOST: u64 = 64 << 20;
/// Depth to which folders are searched.
const DEPTH: usize = 8;
/// The figures of the table; the page has all.
const SHOWN: [&str; 6] = [
    "path_error_rmse_mm",
    "felt_error_all_rmse_mm",
    "felt_error_rmse_mm",
    "felt_level_db",
    "hottest_skin_c",
    "limit_used_percent",
];

/// A summary of an earlier run.
#[derive(Clone, Debug)]
pub struct Earlier {
    /// File of the summary.
    pub file: PathBuf,
    /// Date of the run, from the summary, else of the file.
    pub date: String,
    /// The program's version.
    pub version: String,
    /// Verdict of the run.
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
    for path in entries(folder)? {
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
    if Format::recognise(text.as_bytes()) != Some(Format::Json) {
        return Ok(None);
    }
    let text = text.trim_start_matches('\u{feff}');
    let summary: Value = serde_json::from_str(text).map_err(|e| {
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
        let columns = |cell: &dyn Fn(&Measured) -> String| {
            let cells = in_table().map(|m| format!("  {:>1$}", cell(m), label(m).chars().count()));
            cells.collect::<String>()
        };
        let mut lines = vec![self.name.clone()];
        let line = |date: &str, version: &str, verdict: &str, rest: &str| {
            format!("  {date:<21} {version:<8} {verdict:<14}{rest}")
        };
        lines.push(line("date", "version", "verdict", &columns(&label)));
        for run in &self.runs {
            let rest = format!("{}  {}", columns(&|m| run.shown(m)), run.file.display());
            lines.push(line(&run.date, &run.version, &run.verdict, &rest));
        }
        lines
    }

    /// A figure over the runs, oldest first.
    fn line(&self, figure: &str) -> Line {
        let spot =
            |(n, run): (usize, &Earlier)| Spot::around((n + 1) as f64, &[*run.values.get(figure)?]);
        Line {
            name: self.name.clone(),
            spots: self.runs.iter().enumerate().filter_map(spot).collect(),
        }
    }
}

impl Earlier {
    /// A value to the thousandth; `-` for none.
    fn shown(&self, of: &Measured) -> String {
        let value = self.values.get(of.key);
        value.map_or_else(|| "-".to_owned(), |v| short(*v))
    }
}

fn in_table() -> impl Iterator<Item = &'static Measured> {
    MEASURED.iter().filter(|m| SHOWN.contains(&m.key))
}

fn label(of: &Measured) -> String {
    with_unit(of.words, of.unit)
}

/// All trends as a page.
pub fn page(trends: &[Trend], compared: &Compared) -> String {
    let mut out = head("Trends", &compared.conclusion);
    for some in trends.chunks(LINES) {
        out.push_str("<section><h2>Figures over the runs</h2><p class=\"sub\">Oldest first; the tables below say when each was.</p>\n<div class=\"charts\">");
        let mut names = String::new();
        for measured in &MEASURED {
            let lines: Vec<Line> = some.iter().map(|trend| trend.line(measured.key)).collect();
            if lines.iter().any(|line| !line.spots.is_empty()) {
                out.push_str(&chart(&lines, ("run", ""), (measured.words, measured.unit)));
                names = legend(&lines);
            }
        }
        let _ = writeln!(out, "</div>{names}</section>");
    }
    for trend in trends {
        let figures: Vec<_> = in_table().map(label).collect();
        let mut columns = vec![
            ("num", "run"),
            ("", "date"),
            ("", "version"),
            ("", "verdict"),
        ];
        columns.extend(figures.iter().map(|name| ("num", name.as_str())));
        columns.push(("", "file"));
        let row = |(n, run): (usize, &Earlier)| {
            let mut cells = vec![(n + 1).to_string()];
            cells.extend([&run.date, &run.version, &run.verdict].map(String::clone));
            cells.extend(in_table().map(|measured| run.shown(measured)));
            cells.push(run.file.display().to_string());
            (run.verdict != Verdict::Ok.key(), cells)
        };
        let _ = writeln!(
            out,
            "<section><h2>{}</h2>{}</section>",
            escape(&trend.name),
            wide(&columns, trend.runs.iter().enumerate().map(row))
        );
    }
    out + &foot()
}
