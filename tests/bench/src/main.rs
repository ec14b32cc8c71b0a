//! `palpate-bench`: run time against error, the project's methods beside those of other projects.
//!
//! A family is a module with one function that measures and returns [`Findings`]; its name stands in [`FAMILIES`].
//! Methods of one case are timed in turn in one run, so that their ratios hold on a noisy machine.

mod compression;
mod emulators;
mod findings;
mod guard;
mod illusion;
mod null_bus;
mod page;
mod perceiver;
mod physics;
mod plot;
mod presses;
mod projection;
mod python;
mod records;
mod render;
mod scenes;
mod settings;
mod skins;
mod table;
mod texture;
mod timing;
mod unit;
mod units;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use palpate_live::output::{make_folder, note, print, print_json, write_file};
use palpate_records::report::svg::standalone;
use palpate_run::Failure;

use findings::{Findings, Row};

/// Measures a family, with what the command line says.
type Measure = fn(&Arguments) -> Result<Findings, Failure>;

/// Every family as the command line spells it, in the order of the page, with what it measures.
const FAMILIES: [(&str, Measure); 11] = [
    ("physics", |_| physics::measure()),
    ("perceiver", |_| perceiver::measure()),
    ("emulators", |_| emulators::measure()),
    ("compression", |_| compression::measure()),
    ("texture", |_| texture::measure()),
    ("illusion", |_| illusion::measure()),
    ("laws", |args| illusion::laws::measure(args.points)),
    ("render", |_| render::measure()),
    ("loop", |_| projection::measure()),
    ("unit", |_| unit::measure()),
    ("records", |_| records::measure()),
];

/// Run time against error: tables, JSON and plots.
#[derive(Debug, Parser)]
#[command(name = "palpate-bench", version)]
struct Arguments {
    /// Family to measure (default: every family).
    #[arg(value_parser = FAMILIES.map(|f| f.0))]
    family: Option<String>,
    /// Points at which `laws` tries each law.
    #[arg(long, value_name = "N", default_value_t = illusion::laws::POINTS,
        value_parser = clap::value_parser!(u32).range(2..=100_000))]
    points: u32,
    /// Write bench.html, bench.json and the plots (SVG) into this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Print the rows as a JSON array.
    #[arg(long)]
    json: bool,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    quiet: bool,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let _ = writeln!(std::io::stderr(), "error: {failure}");
            ExitCode::from(failure.status())
        }
    }
}

fn run(args: &Arguments) -> Result<(), Failure> {
    let mut found = Vec::new();
    for (name, measure) in FAMILIES {
        if args.family.as_deref().is_none_or(|chosen| chosen == name) {
            if !args.quiet {
                note(&format!("measuring {name}"));
            }
            found.push(measure(args)?);
        }
    }
    let rows: Vec<&Row> = found.iter().flat_map(|f| &f.rows).collect();
    if let Some(folder) = &args.out {
        write(folder, &found, &rows)?;
    }
    if args.quiet {
        return Ok(());
    }
    if args.json {
        return print_json(&rows);
    }
    print(|out| {
        let mut tables = found.iter().map(table::text);
        tables.try_for_each(|text| out.write_all(text.as_bytes()))
    })
}

/// The table, every figure and the page with all of them.
fn write(folder: &Path, found: &[Findings], rows: &[&Row]) -> Result<(), Failure> {
    make_folder(folder)?;
    write_file(&folder.join("bench.json"), |out| {
        serde_json::to_writer_pretty(&mut *out, rows)?;
        writeln!(out)
    })?;
    for findings in found {
        for figure in &findings.figures {
            let path = folder.join(format!("{}-{}.svg", findings.family, figure.name));
            write_file(&path, |out| {
                let drawing = figure.alone.as_ref().unwrap_or(&figure.svg);
                out.write_all(standalone(drawing, "").as_bytes())
            })?;
        }
    }
    write_file(&folder.join("bench.html"), |out| {
        out.write_all(page::html(found).as_bytes())
    })
}

#[cfg(test)]
mod tests;
