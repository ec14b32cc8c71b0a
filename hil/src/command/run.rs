//! `hil run`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use palpate_core::illusion::Model;
use palpate_records::contacts_csv::write_contacts;
use palpate_records::golden::schedule_golden;
use palpate_records::mcap::{Traffic, write_mcap};
use palpate_records::report::{ReportExtras, SummaryRow, Thermal, report_html};
use palpate_records::schedule::write_schedule;
use palpate_records::vcd::write_vcd;

use crate::cli::{RunArgs, Switch};
use crate::failure::Failure;
use crate::output::{make_folder, note, print, write_file, write_sidecar};
use crate::plan;
use crate::recording::write_can_log;
use crate::run::real::Told;
use crate::run::{self, Input, Keep, Outcome};
use crate::trial::{Trial, Verdict, judge, junit};
use palpate_files::{BenchKind, IllusionModel, Kind, Scene, Setup, load_layout, load_scene};

use crate::record::Kind as LiveKind;

use super::devices::bench;
use super::explain;
use super::rate::rate_of;

/// The scene of `hil run` without a name.
pub(super) const DEFAULT_SCENE: &str = "sphere-along";

/// What to write, by the ending of a file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Contacts,
    Schedule,
    Can,
    Golden,
    Mcap,
    Vcd,
    Report,
    Summary,
}

impl Format {
    fn of(path: &Path) -> Result<Self, Failure> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("csv") => Ok(Self::Contacts),
            Some("jsonl") => Ok(Self::Schedule),
            Some("log") => Ok(Self::Can),
            Some("mcap") => Ok(Self::Mcap),
            Some("vcd") => Ok(Self::Vcd),
            Some("snap") => Ok(Self::Golden),
            _ => Err(Failure::Input(format!(
                "--record {}: expected a name that ends in .csv (contacts), .jsonl (schedule), .log (candump), .mcap (everything), .vcd (pins, ticks, temperatures) or .snap (golden)",
                path.display()
            ))),
        }
    }

    fn write(self, path: &Path, setup: &Setup, outcome: &Outcome) -> Result<(), Failure> {
        if self == Self::Contacts {
            write_sidecar(path, Some(&outcome.trace.header))?;
        }
        write_file(path, |out| match self {
            Self::Contacts => write_contacts(&outcome.trace, out),
            Self::Mcap => {
                let traffic = Traffic {
                    can: &outcome.can,
                    i2c: &outcome.i2c,
                };
                write_mcap(&outcome.trace, traffic, &run::attachments(setup), out)
            }
            Self::Vcd => write_vcd(&outcome.trace, out),
            Self::Schedule => write_schedule(&outcome.trace, out),
            Self::Can => write_can_log(&outcome.can, &[], out),
            Self::Golden => out.write_all(schedule_golden(&outcome.trace).as_bytes()),
            Self::Report => out.write_all(report(outcome).as_bytes()),
            Self::Summary => {
                serde_json::to_writer_pretty(&mut *out, &outcome.summary)?;
                writeln!(out)
            }
        })
    }
}

/// Runs a scene or a recording and writes what was asked for.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &RunArgs) -> Result<(), Failure> {
    let setup = setup(args)?;
    let rate = rate_of(args.rate, &args.replay)?;
    let input = match args.replay.as_slice() {
        [] => Input::Scene,
        paths => Input::Replay {
            paths: paths.to_vec(),
            rate_hz: rate.hz,
        },
    };
    let mut files = wanted(args)?;
    if args.explain {
        explained(args, |out| explain::plan(&setup, out))?;
    }
    let wants = |wanted| files.iter().any(|(format, _)| *format == wanted);
    let keep = Keep {
        can: wants(Format::Can) || wants(Format::Mcap),
        i2c: wants(Format::Mcap),
        watch: args.watch,
    };
    let is_real = setup.bench.value.kind == BenchKind::Real;
    let mut outcome = match (is_real, args.replay.is_empty()) {
        (false, _) => run::run_keeping(&setup, &input, args.seed, keep)?,
        (true, true) => {
            if let Some(folder) = &args.out {
                make_folder(folder)?;
            }
            let (live, later) = split(files);
            files = later;
            let told = Told {
                quiet: args.quiet,
                watched: args.watch,
            };
            run::real::run(&setup, args.seed, &live, told)?
        }
        (true, false) => {
            return Err(Failure::Input(
                "--replay: a recording drives an emulated bench only".into(),
            ));
        }
    };
    let checks = args
        .junit
        .as_ref()
        .map(|path| (path, judge(&setup, &outcome)));
    let failure = outcome.failure.take();
    outcome.notes.iter().for_each(|text| note(text));
    if let (Some(hz), Some(meta), false) = (rate.hz, &rate.found_in, args.quiet) {
        note(&format!("{hz} rows a second, from {}", meta.display()));
    }
    // Only now: bad input leaves no empty folder behind.
    if let Some(folder) = &args.out {
        make_folder(folder)?;
    }
    for (format, path) in &files {
        format.write(path, &setup, &outcome)?;
    }
    let mut failed = None;
    if let Some((path, tried)) = checks {
        let took = std::time::Duration::from_secs_f64(outcome.summary.wall_s);
        let trial = Trial::of(&setup.scene.value.name, tried, took);
        let text = junit(&setup.bench.value.name, std::slice::from_ref(&trial));
        write_file(path, |out| out.write_all(text.as_bytes()))?;
        if let Verdict::Failed(wrong) = trial.verdict {
            failed = Some(Failure::Check(wrong.join("; ")));
        }
    }
    if args.json {
        print(|out| {
            serde_json::to_writer(&mut *out, &outcome.summary)?;
            writeln!(out)
        })
    } else if args.quiet {
        Ok(())
    } else {
        print(|out| {
            outcome.summary.write(out)?;
            files
                .iter()
                .try_for_each(|(_, path)| writeln!(out, "  wrote           {}", path.display()))
        })
    }?;
    if args.explain {
        explained(args, |out| explain::done(&outcome.effort, out))?;
    }
    failure.or(failed).map_or(Ok(()), Err)
}

/// The files that a real run writes while it runs, and those that come after it.
#[allow(clippy::type_complexity)] // two lists of what `wanted` returns
fn split(files: Vec<(Format, PathBuf)>) -> (Vec<(LiveKind, PathBuf)>, Vec<(Format, PathBuf)>) {
    let (mut live, mut later) = (Vec::new(), Vec::new());
    for (format, path) in files {
        match format {
            Format::Contacts => live.push((LiveKind::Contacts, path)),
            Format::Schedule => live.push((LiveKind::Schedule, path)),
            Format::Can => live.push((LiveKind::Can, path)),
            Format::Mcap => live.push((LiveKind::Mcap, path)),
            Format::Vcd => live.push((LiveKind::Vcd, path)),
            Format::Golden | Format::Report | Format::Summary => later.push((format, path)),
        }
    }
    (live, later)
}

/// Prints an explanation: on standard output, or beside the object or silence that is asked for there.
fn explained(
    args: &RunArgs,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    if !(args.json || args.quiet) {
        return print(write);
    }
    let mut text = Vec::new();
    // Writing to memory does not fail.
    let _ = write(&mut text);
    note(String::from_utf8_lossy(&text).trim_end());
    Ok(())
}

/// The files to write, checked before anything runs.
fn wanted(args: &RunArgs) -> Result<Vec<(Format, PathBuf)>, Failure> {
    let mut files = Vec::new();
    if let Some(folder) = &args.out {
        for (format, name) in [
            (Format::Summary, "summary.json"),
            (Format::Schedule, "schedule.jsonl"),
            (Format::Contacts, "contacts.csv"),
            (Format::Report, "report.html"),
        ] {
            files.push((format, folder.join(name)));
        }
    }
    files.extend(args.schedule.iter().map(|p| (Format::Schedule, p.clone())));
    files.extend(args.report.iter().map(|p| (Format::Report, p.clone())));
    for path in &args.record {
        files.push((Format::of(path)?, path.clone()));
    }
    Ok(files)
}

/// Scene and bench with the command line's changes, checked like a file of that content.
fn setup(args: &RunArgs) -> Result<Setup, Failure> {
    let mut scene = load_scene(args.scene.as_deref().unwrap_or(DEFAULT_SCENE))?;
    let bench = bench(args.bench.as_deref(), &args.can, &args.i2c)?;
    if let Some(name) = &args.layout {
        // The name is checked here so that the error speaks of the option.
        let found = load_layout(name)?;
        if !matches!(found.value, palpate_files::LayoutFile::Sensor(_)) {
            return Err(Failure::Input(format!(
                "--layout {name}: expected a layout of kind \"sensor\", found a display"
            )));
        }
        // Typed here, so it starts from here, not from the scene's folder.
        scene.value.layout = if Kind::Layout.names().contains(&name.as_str()) {
            name.clone()
        } else {
            std::path::absolute(name).map_or_else(|_| name.clone(), |p| p.display().to_string())
        };
    }
    if !args.replay.is_empty() {
        if args.scene.is_none() {
            // Real boards are noisy, drift, and differ: the scene's own rule is for emulated ones.
            scene.value.threshold = palpate_files::ThresholdRule::PerTaxel;
            scene.value.threshold_margin = palpate_files::THRESHOLD_FLOOR;
            scene.value.drift_s = Some(palpate_files::DRIFT_S);
        }
        scene.value.touches.clear();
        scene.value.name = format!("replay of {}", args.replay[0].display());
    }
    change(&mut scene.value, args)?;
    Ok(Setup::join(scene, bench)?)
}

fn change(scene: &mut Scene, args: &RunArgs) -> Result<(), Failure> {
    let illusion = &mut scene.illusion;
    if let Some(name) = args.illusion.as_deref() {
        let Some(model) = IllusionModel::named(name) else {
            return Err(Failure::Input(format!(
                "--illusion {name}: expected one of {}",
                Model::ALL.map(Model::name).join(", ")
            )));
        };
        if model != illusion.model {
            // Shape and distances were meant for the scene's own model.
            (illusion.shape, illusion.flat, illusion.distances) = (None, false, None);
        }
        illusion.model = model;
    }
    if let Some(switch) = args.intensity {
        illusion.intensity = switch == Switch::On;
    }
    let within = |option: &str, value: Option<f64>, low: f64, high: f64| match value {
        Some(v) if !(low..=high).contains(&v) => Err(Failure::Input(format!(
            "--{option} {v}: expected {low} to {high}"
        ))),
        value => Ok(value),
    };
    if let Some(shape) = within("shape", args.shape, 0.01, 100.0)? {
        let model = plan::model(illusion.model);
        if model.shape().is_none() {
            let name = model.name();
            return Err(Failure::Input(format!(
                "--shape {shape}: expected no shape, {name} has none"
            )));
        }
        (illusion.shape, illusion.flat) = (Some(shape), false);
    }
    illusion.alpha = within("alpha", args.alpha, 0.0, 1.0)?.unwrap_or(illusion.alpha);
    illusion.beta = within("beta", args.beta, 0.0, 1.0)?.unwrap_or(illusion.beta);
    let tau_d = within("tau-d-ms", args.tau_d_ms, 1.0, 10_000.0)?;
    illusion.tau_d_ms = tau_d.or(illusion.tau_d_ms);
    let soa = within("soa-ms", args.soa_ms, 1.0, 10_000.0)?;
    illusion.soa_ms = soa.or(illusion.soa_ms);
    if illusion.alpha + illusion.beta >= 1.0 {
        return Err(Failure::Input(format!(
            "--alpha {} --beta {}: expected a sum below 1",
            illusion.alpha, illusion.beta
        )));
    }
    if let Some(tau_d) = illusion.tau_d_ms.filter(|t| *t > illusion.onset_ms()) {
        return Err(Failure::Input(format!(
            "--tau-d-ms {tau_d}: expected at most the onset asynchrony, {:.1} ms",
            illusion.onset_ms()
        )));
    }
    Ok(())
}

fn report(outcome: &Outcome) -> String {
    let s = &outcome.summary;
    let row = |name: &str, value: String, unit: &str| SummaryRow {
        name: name.into(),
        value,
        unit: unit.into(),
        ..SummaryRow::default()
    };
    let rows = [
        row(
            "taxel refresh, median",
            format!("{:.1}", s.taxels.refresh_hz.median),
            "Hz",
        ),
        row(
            "taxel refresh, slowest",
            format!("{:.1}", s.taxels.refresh_hz.min),
            "Hz",
        ),
        row("frozen taxels", s.taxels.frozen.to_string(), ""),
        row("dead taxels", s.taxels.dead.to_string(), ""),
        row("computed in", format!("{:.3}", s.wall_s), "s"),
    ];
    report_html(
        &outcome.trace,
        &ReportExtras {
            frame_us: &outcome.frame_us,
            summary: &rows,
            thermal: (!outcome.warmth.is_empty()).then(|| Thermal {
                samples: &outcome.warmth,
                margins: &outcome.summary.margins,
                limits: outcome.skin_limits,
            }),
        },
    )
}
