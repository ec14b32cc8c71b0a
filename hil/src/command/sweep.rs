//! `hil sweep`: a scene over a grid of values and seeds, one row per run.

use std::io::{self, Write};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use palpate_buses::signals::Signals;
use palpate_files::{Format, Setup, load_scene};
use palpate_records::runs::{MEASURED, RunRow, short};
use palpate_records::verdict::{Conclusion, Verdict};
use palpate_run::sweep::{Axis, Grid, Variant};
use palpate_run::{Failure, Host};
use rayon::prelude::*;
use serde::Serialize;

use super::devices::bench;
use crate::cli::ranges::add;
use crate::cli::{Color, SweepArgs};
use crate::sweep::{Growing, Work, page};
use palpate_live::output::{Outputs, list_written};
use palpate_live::progress::Progress;

/// Most runs that share what is read for a combination of values.
const TOGETHER: usize = 16;

/// Runs what the table lacks, and puts it in order.
///
/// # Errors
/// [`Failure`] with the exit status of the gravest run; [`Failure::Stopped`] where a signal came first.
pub fn sweep(args: &SweepArgs, color: Color) -> Result<(), Failure> {
    let axes = args
        .set
        .iter()
        .map(|text| axis(text))
        .collect::<Result<_, _>>()?;
    let grid = Grid::new(axes, args.seeds.0.clone())?;
    let outputs = Outputs::new(args.force);
    Growing::check(&args.out, outputs)?;
    outputs.check_some(args.html.as_deref(), Format::Html)?;
    let scene = load_scene(&args.scene)?;
    let named = args.bench.as_deref();
    let named = bench(Some(named.unwrap_or(scene.value.own_bench())), &[], &[])?;
    let base = Setup::join(scene, named)?;
    let pool = pool(args.jobs)?;
    let jobs = pool.current_num_threads();
    let mut work = pool.install(|| Work::read(&base, grid, args.part))?;
    let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
    let table = work.open(&args.out, outputs)?;
    let (table, fresh) = pool.install(|| run(&work, &base, table, jobs, &signals))?;
    let caught = signals.caught();
    // From here on a signal ends the program, and what is half-written goes.
    drop(signals);
    work.take(fresh);
    work.finish(table)?;
    tell(&work, args, color, caught)
}

/// Threads for `--jobs`, as many as there are cores where it is not given.
///
/// # Errors
/// [`Failure::Device`] where the system has no such number of threads.
pub(super) fn pool(jobs: Option<usize>) -> Result<rayon::ThreadPool, Failure> {
    let cores = || std::thread::available_parallelism().map_or(1, Into::into);
    let jobs = jobs.unwrap_or_else(cores);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build();
    pool.map_err(|e| Failure::Device(format!("--jobs {jobs}: {e}")))
}

/// `KEY=VALUE,FROM..TO:STEP`; commas between brackets or quotes belong to a value.
fn axis(text: &str) -> Result<Axis, Failure> {
    let expected = || {
        Failure::Input(format!(
            "--set: expected KEY=VALUE,VALUE,.. or KEY=FROM..TO:STEP, found `{text}`"
        ))
    };
    let text_is_plain = !text.contains(char::is_control);
    let (key, rest) = text
        .split_once('=')
        .filter(|_| text_is_plain)
        .ok_or_else(expected)?;
    let (mut values, mut value) = (Vec::new(), String::new());
    let (mut depth, mut quote) = (0_i32, None);
    for c in rest.chars() {
        match (c, quote) {
            (',', None) if depth == 0 => values.push(std::mem::take(&mut value)),
            (c, Some(open)) if c == open => quote = None,
            ('"' | '\'', None) => quote = Some(c),
            ('[' | '{', None) => depth += 1,
            (']' | '}', None) => depth -= 1,
            _ => {}
        }
        if c != ',' || depth != 0 || quote.is_some() {
            value.push(c);
        }
    }
    values.push(value);
    let key = key.trim().to_owned();
    let mut all = Vec::new();
    for value in values {
        add(&mut all, &value).map_err(|e| Failure::Input(format!("--set {key}: {e}")))?;
    }
    if key.is_empty() || all.iter().any(String::is_empty) {
        return Err(expected());
    }
    Ok(Axis { key, values: all })
}

/// Ends a run when a signal came.
pub(super) struct Stopping<'a>(pub &'a Signals);

impl Host for Stopping<'_> {
    fn passed(&mut self, _part: f64) -> bool {
        self.0.caught().is_some()
    }
}

/// Runs what is wanted and not there. A signal ends it; runs under way are then as if they had not begun.
fn run(
    work: &Work,
    base: &Setup,
    table: Growing,
    jobs: usize,
    signals: &Signals,
) -> Result<(Growing, Vec<RunRow>), Failure> {
    let lacking = work.lacking();
    // Enough pieces that no core waits long for the last one.
    let together = (lacking.len() / (jobs * 4)).clamp(1, TOGETHER);
    let mut pieces: Vec<&[(usize, u64)]> = Vec::new();
    for of_one in lacking.chunk_by(|a, b| a.0 == b.0) {
        pieces.extend(of_one.chunks(together));
    }
    let grown = Mutex::new((table, Vec::new()));
    let next = AtomicUsize::new(0);
    let progress = Progress::counted("sweep", lacking.len() as u64, "runs");
    let worker = || -> Result<(), Failure> {
        while let Some(piece) = pieces.get(next.fetch_add(1, Ordering::Relaxed)) {
            let variant = Variant::new(base, work.grid().set(piece[0].0))?;
            for (_, seed) in *piece {
                let row = variant.row(*seed, &mut Stopping(signals))?;
                if signals.caught().is_some() {
                    return Ok(());
                }
                let mut grown = grown.lock().unwrap_or_else(|broken| broken.into_inner());
                grown.0.add(&row)?;
                grown.1.push(row);
                progress.step();
            }
        }
        Ok(())
    };
    // In the order of the grid, so that an interrupted table is its beginning.
    let ended: Vec<Result<(), Failure>> = (0..jobs).into_par_iter().map(|_| worker()).collect();
    ended.into_iter().collect::<Result<(), _>>()?;
    Ok(grown
        .into_inner()
        .unwrap_or_else(|broken| broken.into_inner()))
}

/// The gravest of the rows, each verdict with its first one.
fn conclusion(rows: &[&RunRow], wanted: usize, caught: Option<&str>) -> Conclusion {
    let mut conclusion = Conclusion::default();
    for verdict in Verdict::ALL.into_iter().rev().filter(|v| *v != Verdict::Ok) {
        let mut of = rows.iter().filter(|row| row.verdict == verdict);
        if let Some(first) = of.next() {
            let (count, at) = (1 + of.count(), first.key.place());
            conclusion.add(
                verdict,
                format!("{count} of {}, first {at}: {}", runs(wanted), first.why),
            );
        }
    }
    if let Some(signal) = caught {
        let there = rows.len();
        let text =
            format!("by {signal}: {there} of {wanted} rows are there, the same command goes on");
        conclusion.add(Verdict::Stopped, text);
    }
    conclusion
}

/// Prints the result of the sweep.
fn tell(work: &Work, args: &SweepArgs, color: Color, caught: Option<&str>) -> Result<(), Failure> {
    let wanted = work.wanted_count();
    let rows = work.there();
    let conclusion = conclusion(&rows, wanted, caught);
    let outputs = Outputs::new(args.force);
    outputs.write_some(args.html.as_deref(), Format::Html, || {
        page(&conclusion, &rows)
    })?;
    let names = work.names();
    #[derive(Serialize)]
    struct All<'a> {
        #[serde(flatten)]
        conclusion: &'a Conclusion,
        scene: Option<&'a str>,
        bench: Option<&'a str>,
        rows: usize,
        wanted: usize,
        there_before: usize,
        table: String,
    }
    let all = || All {
        conclusion: &conclusion,
        scene: names.map(|names| names.0),
        bench: names.map(|names| names.1),
        rows: rows.len(),
        wanted,
        there_before: work.before(),
        table: args.out.display().to_string(),
    };
    args.voice.tell(all, |out| {
        conclusion.write(out, color.on(&io::stdout()))?;
        let before = match work.before() {
            0 => String::new(),
            n => format!(", {n} of them in the table before"),
        };
        let (scene, bench) = names.unwrap_or_default();
        writeln!(
            out,
            "{scene} on {bench} (emulated): {}{before}; least to most, and where",
            runs(rows.len())
        )?;
        spread(&rows, out)?;
        list_written(args.html.iter().chain([&args.out]), out)
    })?;
    match conclusion.verdict {
        _ if caught.is_some() => Err(Failure::Stopped(conclusion.line())),
        verdict if verdict.is_done() => Ok(()),
        Verdict::Stopped => Err(Failure::Guard(conclusion.line())),
        _ => Err(Failure::Check(conclusion.line())),
    }
}

/// `1 run`, `12 runs`.
fn runs(count: usize) -> String {
    let s = if count == 1 { "" } else { "s" };
    format!("{count} run{s}")
}

/// The figures that differ between runs: the least, the most, and where they are.
fn spread(rows: &[&RunRow], out: &mut dyn Write) -> io::Result<()> {
    for measured in &MEASURED {
        let found = || {
            rows.iter()
                .filter_map(|row| Some((*row.values.get(measured.key)?, &row.key)))
        };
        let least = found().min_by(|a, b| a.0.total_cmp(&b.0));
        let most = found().max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((least, most)) = least.zip(most).filter(|(least, most)| least.0 < most.0) else {
            continue;
        };
        let range = format!("{} to {} {}", short(least.0), short(most.0), measured.unit);
        writeln!(
            out,
            "  {:<35} {:<21} {}, {}",
            measured.words,
            range.trim_end(),
            least.1.place(),
            most.1.place()
        )?;
    }
    Ok(())
}

#[cfg(test)]
#[path = "sweep_tests.rs"]
mod tests;
