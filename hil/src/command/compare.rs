//! `hil compare`: two summaries, tables of sweeps or other JSON results, figure by figure; or a folder of earlier
//! summaries over time.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use palpate_files::{FileError, Format, read_text};
use palpate_records::runs::RunTable;
use palpate_records::verdict::{Conclusion, Verdict};
use palpate_run::Failure;
use serde_json::{Value, json};

use crate::cli::{Color, CompareArgs};
use crate::history::{
    Compared, Named, Tolerance, Trend, compare_objects, compare_tables, page, page_of_two, trends,
};
use crate::sweep::read_table;
use palpate_live::output::Outputs;
use palpate_live::progress::Progress;

/// Longest result that is read as a whole.
const MOST: u64 = 64 << 20;
/// The summary in a folder of `hil run --out`.
const SUMMARY: &str = "summary.json";

/// Compares two files, or shows a folder's trends.
///
/// # Errors
/// [`Failure::Input`] for a file of another kind, [`Failure::Check`] where a figure differs or runs lack.
pub fn compare(args: &CompareArgs, color: Color) -> Result<(), Failure> {
    let outputs = Outputs::new(args.force);
    outputs.check_some(args.html.as_deref(), Format::Html)?;
    let tolerance = Tolerance(args.tolerance_percent / 100.0);
    let (compared, all) = match &args.b {
        Some(b) => (two(&args.a, b, tolerance)?, Vec::new()),
        None if args.a.is_dir() => {
            let _shown = Progress::endless("reading summaries");
            let all = trends(&args.a)?;
            (newest(&all, tolerance), all)
        }
        None if args.a.exists() => {
            return Err(Failure::Input(format!(
                "{}: expected a second result to compare it with, or a folder of earlier summaries, found one file",
                args.a.display()
            )));
        }
        None => return Err(gone(&args.a).into()),
    };
    let b = args.b.as_deref().unwrap_or(Path::new(""));
    let names = [&*args.a, b].map(|path| path.display().to_string());
    let names = [&*names[0], &names[1]];
    outputs.write_some(args.html.as_deref(), Format::Html, || match &args.b {
        Some(_) => page_of_two(&compared, names),
        None => page(&all, &compared),
    })?;
    let object = || object(&compared, &all);
    args.voice.tell(object, |out| {
        compared.conclusion.write(out, color.on(&io::stdout()))?;
        match compared.named.is_empty() {
            false => figures(&compared, names, args.long, out)?,
            true => differences(&compared, out)?,
        }
        let mut trends = all.iter().flat_map(Trend::table);
        trends.try_for_each(|line| writeln!(out, "{line}"))
    })?;
    match compared.conclusion.verdict {
        Verdict::Ok => Ok(()),
        _ => Err(Failure::Check(String::new())),
    }
}

/// A result in a file.
enum Kept {
    Table(RunTable),
    Object(Value),
}

/// Kinds of results, as errors name them.
const EXPECTED: &str = "a summary (`hil run --json`), a folder of `hil run --out`, a table of `hil sweep`, or another result in JSON";

fn gone(path: &Path) -> FileError {
    let label = path.display().to_string();
    FileError::whole(label, EXPECTED, "no such file or folder")
}

/// File of the result at a path: in a folder its summary.
fn result_at(path: &Path) -> Result<PathBuf, FileError> {
    let inside = path.join(SUMMARY);
    match (path.is_dir(), inside.is_file()) {
        (false, _) if path.exists() => Ok(path.to_path_buf()),
        (false, _) => Err(gone(path)),
        (true, true) => Ok(inside),
        (true, false) => {
            let label = path.display().to_string();
            let expected = "a folder of `hil run --out`, with summary.json in it";
            Err(FileError::whole(label, expected, "a folder without one"))
        }
    }
}

fn two(a: &Path, b: &Path, tolerance: Tolerance) -> Result<Compared, Failure> {
    match (read(&result_at(a)?)?, read(&result_at(b)?)?) {
        (Kept::Table(a), Kept::Table(b)) => Ok(compare_tables(&a, &b, tolerance)),
        (Kept::Object(a), Kept::Object(b)) => Ok(compare_objects(&a, &b, tolerance)),
        (of_a, of_b) => Err(Failure::Input(format!(
            "{}: expected {} like {}, found {}",
            b.display(),
            of_a.noun(),
            a.display(),
            of_b.noun()
        ))),
    }
}

impl Kept {
    const fn noun(&self) -> &'static str {
        match self {
            Self::Table(_) => "a table of a sweep",
            Self::Object(_) => "a summary (JSON)",
        }
    }
}

fn read(path: &Path) -> Result<Kept, FileError> {
    let label = path.display().to_string();
    let expected = EXPECTED;
    // A table may be longer than any other result.
    if matches!(
        path.extension().and_then(|e| e.to_str()),
        Some("csv" | "jsonl")
    ) {
        let _shown = Progress::reading(path);
        return table(path).map(Kept::Table);
    }
    let text = read_text(path, expected, MOST)?;
    let text = text.trim_start_matches('\u{feff}');
    if RunTable::is_one(text) {
        return table(path).map(Kept::Table);
    }
    match Format::recognise(text.as_bytes()) {
        Some(Format::Json) => {}
        found => {
            return Err(FileError::whole(
                label,
                expected,
                found.map_or("something else", Format::noun),
            ));
        }
    }
    let read = serde_json::from_str(text);
    read.map(Kept::Object).map_err(|e| FileError {
        line: Some(e.line()),
        ..FileError::whole(label, "JSON", e.to_string())
    })
}

/// Reads a table to compare: one without a row has nothing to say.
fn table(path: &Path) -> Result<RunTable, FileError> {
    let table = read_table(path)?;
    match table.rows.is_empty() {
        false => Ok(table),
        true => Err(FileError::whole(
            path.display().to_string(),
            "a table of `hil sweep` with at least one whole row",
            "none",
        )),
    }
}

/// The newest run of each series against the one before.
fn newest(all: &[Trend], tolerance: Tolerance) -> Compared {
    let mut whole = Compared::default();
    let mut conclusion = Conclusion::default();
    for (trend, compared) in all.iter().filter_map(|t| Some((t, t.newest(tolerance)?))) {
        whole.figures += compared.figures;
        let detail = format!("{}, newest against the one before", trend.name);
        whole
            .differences
            .extend(compared.differences.into_iter().map(|mut d| {
                d.detail.clone_from(&detail);
                d
            }));
        if let Some(why) = compared.conclusion.why.first() {
            conclusion.add(
                compared.conclusion.verdict,
                format!("{}: {why}", trend.name),
            );
        }
    }
    Compared {
        conclusion,
        ..whole
    }
}

fn object(compared: &Compared, all: &[Trend]) -> Value {
    let run = |trend: &Trend| -> Vec<Value> {
        let runs = trend.runs.iter();
        runs.map(|run| json!({"date": run.date, "version": run.version, "verdict": run.verdict, "file": run.file}))
            .collect()
    };
    let mut object = json!(compared);
    if !all.is_empty() {
        let series: Vec<Value> = all
            .iter()
            .map(|t| json!({"series": t.name, "runs": run(t)}))
            .collect();
        object["trends"] = series.into();
    }
    object
}

/// Prints the figures that have a name, side by side; behind them the other differences, in full if that is wanted.
fn figures(
    compared: &Compared,
    names: [&str; 2],
    long: bool,
    out: &mut dyn Write,
) -> io::Result<()> {
    let row = |named: &Named| {
        let figure = format!("{} {}", named.figure, named.unit);
        let values = [named.a, named.b].map(Named::value);
        (figure.trim_end().to_owned(), values, named.grown())
    };
    let rows: Vec<_> = compared.named.iter().map(row).collect();
    let width = |n: usize| {
        let cells = rows.iter().map(|(_, values, _)| values[n].chars().count());
        cells.max().unwrap_or(0).max(names[n].chars().count())
    };
    let widths = [width(0), width(1)];
    writeln!(
        out,
        "  {:<28}{:>3$}  {:>4$}  change",
        "", names[0], names[1], widths[0], widths[1]
    )?;
    for (figure, [a, b], grown) in &rows {
        let line = format!(
            "  {figure:<28}{a:>0$}  {b:>1$}  {grown}",
            widths[0], widths[1]
        );
        writeln!(out, "{}", line.trim_end())?;
    }
    if long {
        return differences(compared, out);
    }
    writeln!(
        out,
        "{} of {} values differ; --long lists them",
        compared.differences.len(),
        compared.figures
    )
}

/// Prints every value that differs, a line each.
fn differences(compared: &Compared, out: &mut dyn Write) -> io::Result<()> {
    let (figures, differ) = (compared.figures, compared.differences.len());
    writeln!(out, "{figures} figures compared, {differ} differ")?;
    let mut all = compared.differences.iter();
    all.try_for_each(|d| writeln!(out, "  {}", d.words()))
}
