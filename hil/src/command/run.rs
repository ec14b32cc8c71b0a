//! `hil run`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use palpate_records::contacts_csv::write_table;
use palpate_records::mcap::{BusTraffic, write_mcap};
use palpate_records::schedule::write_schedule;
use palpate_records::story::schedule_golden;
use palpate_records::vcd::write_vcd;
use palpate_records::verdict::Verdict;

use crate::cli::{Color, RunArgs, Switch};
use crate::clock;
use crate::host::{Onlooker, Records};
use crate::output::{Outputs, make_folder, note, print, write_file, write_sidecar};
use crate::real::{self, Told};
use crate::recording::{Reading, ReadingStream, read_joints, recorded, write_can_log};
use crate::trial::{Trial, TrialEnd, judge, junit};
use palpate_files::{
    BenchKind, DRIFT_S, Format as FileFormat, Loaded, Overrides, Scene, Setup, THRESHOLD_FLOOR,
    Timing, load_scene,
};
use palpate_run::{Failure, Input, Keep, KeptReadings, Outcome, attachments, run_with};

use crate::record::{Kind as LiveKind, path_of};

use super::devices::bench_with;
use super::explain;
use super::rate::rate_of;
use super::report::{hand, report};

/// The scene of `hil run` without a name.
pub(super) const DEFAULT_SCENE: &str = "sphere-along";

/// What to write, by the ending of a file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
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
    pub(super) fn of(path: &Path) -> Result<Self, Failure> {
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

    /// As a file of it is known again.
    pub(super) const fn on_disk(self) -> FileFormat {
        match self {
            Self::Contacts => FileFormat::Contacts,
            Self::Schedule => FileFormat::Schedule,
            Self::Can => FileFormat::Candump,
            Self::Golden => FileFormat::Golden,
            Self::Mcap => FileFormat::Mcap,
            Self::Vcd => FileFormat::Vcd,
            Self::Report => FileFormat::Html,
            Self::Summary => FileFormat::Json,
        }
    }

    /// As a file that is written while a run goes on; none of what takes all of it.
    const fn grows(self) -> Option<LiveKind> {
        match self {
            Self::Contacts => Some(LiveKind::Contacts),
            Self::Schedule => Some(LiveKind::Schedule),
            Self::Can => Some(LiveKind::Can),
            Self::Mcap => Some(LiveKind::Mcap),
            Self::Vcd => Some(LiveKind::Vcd),
            Self::Golden | Self::Report | Self::Summary => None,
        }
    }

    /// Whether several displays have a file each.
    const fn is_per_display(self) -> bool {
        matches!(self, Self::Golden | Self::Mcap | Self::Vcd | Self::Report)
    }

    /// The files that it makes of the one that was asked for.
    pub(super) fn paths(self, path: &Path, setup: &Setup) -> Vec<PathBuf> {
        let whole = || path.to_owned();
        let each = setup.fingers.iter().map(|f| path_of(path, &f.name));
        match self {
            _ if setup.fingers.is_empty() || !self.is_per_display() => vec![whole()],
            // The hand's page stands before those of its fingers.
            Self::Report => std::iter::once(whole()).chain(each).collect(),
            _ => each.collect(),
        }
    }

    /// Writes it of a run that is over.
    pub(super) fn write(
        self,
        path: &Path,
        setup: &Setup,
        outcome: &Outcome,
    ) -> Result<(), Failure> {
        if !self.is_per_display() || outcome.displays.is_empty() {
            return self.write_one(path, setup, outcome);
        }
        let mut paths = self.paths(path, setup);
        if self == Self::Report {
            let whole = paths.remove(0);
            let page = hand(setup, outcome, &paths);
            write_file(&whole, |out| out.write_all(page.as_bytes()))?;
        }
        let mut each = paths.iter().zip(&outcome.displays);
        each.try_for_each(|(path, display)| self.write_one(path, setup, &display.outcome))
    }

    fn write_one(self, path: &Path, setup: &Setup, outcome: &Outcome) -> Result<(), Failure> {
        write_file(path, |out| match self {
            Self::Contacts => write_table(&outcome.trace, out),
            Self::Mcap => {
                let traffic = BusTraffic {
                    can: &outcome.can,
                    i2c: &outcome.i2c,
                    ..BusTraffic::default()
                };
                let run = (&outcome.trace, outcome.readings.as_ref());
                write_mcap(run, traffic, &attachments(setup), out)
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
        })?;
        match self {
            Self::Contacts => write_sidecar(path, Some(&outcome.trace.header)),
            _ => Ok(()),
        }
    }
}

/// Runs a scene or a recording and writes what was asked for.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &RunArgs, color: Color) -> Result<(), Failure> {
    let timing = timing(args)?;
    let setup = setup(args)?;
    let mut files = wanted(args, &setup)?;
    if args.explain {
        explained(args, |out| explain::plan(&setup, out))?;
    }
    let wants = |wanted| files.iter().any(|(format, _)| *format == wanted);
    let told =
        !args.voice.quiet || args.voice.json || wants(Format::Report) || wants(Format::Summary);
    let keep = Keep {
        band: told,
        can: wants(Format::Can) || wants(Format::Mcap),
        i2c: wants(Format::Mcap),
        readings: match (wants(Format::Mcap), wants(Format::Report)) {
            (true, _) => KeptReadings::All,
            (false, true) => KeptReadings::Sampled,
            (false, false) => KeptReadings::None,
        },
        // A recording may last a day; nothing else looks at what this leaves out.
        summary: !args.replay.is_empty()
            && setup.fingers.is_empty()
            && files.iter().all(|(format, _)| format.grows().is_some())
            && args.junit.is_none()
            && !args.watch
            && !args.explain,
    };
    let written = files
        .iter()
        .flat_map(|(format, path)| format.paths(path, &setup));
    let written: Vec<PathBuf> = written.collect();
    let is_real = setup.bench.value.kind == BenchKind::Real;
    let mut growing = Vec::new();
    if is_real || keep.summary {
        (growing, files) = split(files);
    }
    let mut outcome = if is_real {
        on_hardware(args, &setup, &growing)?
    } else {
        let reading = Reading {
            timing,
            prefix: args.columns.clone(),
            rest_rows: setup.scene.value.reference_frames as usize + 1,
        };
        emulated(args, &setup, &reading, (keep, growing))?
    };
    let checks = args
        .junit
        .as_ref()
        .map(|path| (path, judge(&setup, &outcome)));
    outcome.summary.date = Some(clock::date(clock::unix_us()));
    let failure = outcome.failure.take();
    outcome.notes.iter().for_each(|text| note(text));
    let rate = rate_of(args.rate, unclocked(args))?;
    if let (Some(hz), Some(meta), false) = (rate.hz, &rate.found_in, args.voice.quiet) {
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
        let suites = [(setup.bench.value.name.clone(), vec![trial.clone()])];
        let text = junit(&suites);
        write_file(path, |out| out.write_all(text.as_bytes()))?;
        if let TrialEnd::Failed(wrong) = trial.end {
            failed = Some(Failure::Check(wrong.why.join("; ")));
        }
    }
    tell(args, &outcome, &written, color)?;
    if args.explain {
        explained(args, |out| explain::done(&outcome, out))?;
    }
    let conclusion = &outcome.summary.conclusion;
    match conclusion.verdict {
        Verdict::LimitExceeded | Verdict::Incomplete => Err(Failure::Check(conclusion.line())),
        Verdict::Failed | Verdict::Stopped | Verdict::Ok => failure.or(failed).map_or(Ok(()), Err),
    }
}

/// The recordings whose rate is to be looked for: none where a column says when rows came.
fn unclocked(args: &RunArgs) -> &[PathBuf] {
    match args.time {
        Some(_) => &[],
        None => &args.replay,
    }
}

/// A scene or a recording on an emulated bench.
fn emulated(
    args: &RunArgs,
    setup: &Setup,
    reading: &Reading,
    (keep, growing): (Keep, Vec<(LiveKind, PathBuf)>),
) -> Result<Outcome, Failure> {
    let sensor = &setup.sensor.value;
    let open = |address: &String| ReadingStream::open(address, sensor);
    let stream = args.stream.as_ref().map(open).transpose()?;
    let (input, notes) = match (&stream, args.replay.as_slice()) {
        (Some(stream), _) => (Input::Stream(Arc::clone(stream) as _), Vec::new()),
        (None, []) => (Input::Scene, Vec::new()),
        (None, paths) => recorded(paths, sensor, reading)?,
    };
    let records = (!growing.is_empty()).then(|| Records {
        files: growing,
        attachments: attachments(setup),
        force: args.force,
        inputs: args.replay.clone(),
        drives: setup.scene.value.drives,
    });
    let mut host = Onlooker::new(args.watch, records);
    let outcome = run_with(setup, &input, args.on.seed, keep, &mut host);
    if let Some(error) = stream.and_then(|stream| stream.wrong()) {
        return Err(error.into());
    }
    let outcome = outcome.map_err(|failure| match (failure, args.replay.first()) {
        // The room for runs knows no files.
        (Failure::Input(text), Some(path)) if text.starts_with("the recording") => {
            Failure::Input(format!("{}: {text}", path.display()))
        }
        (failure, _) => failure,
    })?;
    host.finish()?;
    Ok(Outcome { notes, ..outcome })
}

/// A scene on hardware, with the records that grow while it runs.
fn on_hardware(
    args: &RunArgs,
    setup: &Setup,
    live: &[(LiveKind, PathBuf)],
) -> Result<Outcome, Failure> {
    if !args.replay.is_empty() || args.stream.is_some() {
        let expected = "--replay, --stream: readings from elsewhere drive an emulated bench only";
        return Err(Failure::Input(expected.into()));
    }
    if let Some(folder) = &args.out {
        make_folder(folder)?;
    }
    let told = Told {
        quiet: args.voice.quiet,
        watched: args.watch,
    };
    let outputs = Outputs {
        force: args.force,
        ..Outputs::NEW
    };
    real::run(setup, args.on.seed, (live, outputs), told)
}

/// Says what a run came to, in the form that the command line chose.
fn tell(
    args: &RunArgs,
    outcome: &Outcome,
    written: &[PathBuf],
    color: Color,
) -> Result<(), Failure> {
    if args.voice.json {
        print(|out| {
            serde_json::to_writer(&mut *out, &outcome.summary)?;
            writeln!(out)
        })
    } else if args.voice.quiet {
        Ok(())
    } else {
        print(|out| {
            outcome.summary.write(out, color.on(&io::stdout()))?;
            written
                .iter()
                .try_for_each(|path| writeln!(out, "  wrote           {}", path.display()))
        })
    }
}

/// The files that a real run or a replay writes while it runs, and those that come after it.
#[allow(clippy::type_complexity)] // two lists of what `wanted` returns
fn split(files: Vec<(Format, PathBuf)>) -> (Vec<(LiveKind, PathBuf)>, Vec<(Format, PathBuf)>) {
    let (mut live, mut later) = (Vec::new(), Vec::new());
    for (format, path) in files {
        match format.grows() {
            Some(kind) => live.push((kind, path)),
            None => later.push((format, path)),
        }
    }
    (live, later)
}

/// Prints an explanation: on standard output, or beside the object or silence that is asked for there.
fn explained(
    args: &RunArgs,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Failure> {
    if !(args.voice.json || args.voice.quiet) {
        return print(write);
    }
    let mut text = Vec::new();
    // Writing to memory does not fail.
    let _ = write(&mut text);
    note(String::from_utf8_lossy(&text).trim_end());
    Ok(())
}

/// The files to write, checked before anything runs.
fn wanted(args: &RunArgs, setup: &Setup) -> Result<Vec<(Format, PathBuf)>, Failure> {
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
    let outputs = Outputs {
        force: args.force,
        inputs: &args.replay,
    };
    for (n, (format, path)) in files.iter().enumerate() {
        match format {
            Format::Contacts => outputs.check_table(path)?,
            format => {
                let paths = format.paths(path, setup);
                let mut each = paths.iter();
                each.try_for_each(|path| outputs.check(path, format.on_disk()))?;
            }
        }
        if files[..n].iter().any(|(_, before)| before == path) {
            return Err(Failure::Input(format!(
                "{}: expected one output per file, found two",
                path.display()
            )));
        }
    }
    if let Some(path) = &args.junit {
        outputs.check(path, FileFormat::Junit)?;
    }
    Ok(files)
}

/// How rows of a recording are timed.
fn timing(args: &RunArgs) -> Result<Timing, Failure> {
    Ok(Timing {
        column: args.time.clone(),
        rate_hz: rate_of(args.rate, unclocked(args))?.hz,
        split_jumps: args.split_jumps,
    })
}

/// Scene and bench with the command line's changes, checked like a file of that content.
fn setup(args: &RunArgs) -> Result<Setup, Failure> {
    setup_of(
        load_scene(args.scene.as_deref().unwrap_or(DEFAULT_SCENE))?,
        args,
    )
}

/// The same with a scene that is read already.
///
/// # Errors
/// [`Failure`] for what cannot be in the files, or does not fit together.
pub fn setup_of(scene: Loaded<Scene>, args: &RunArgs) -> Result<Setup, Failure> {
    let overrides = overrides(args)?;
    let mut scene = scene.with(&overrides)?;
    let bench = bench_with(
        args.on.bench.as_deref(),
        &overrides,
        &args.on.can,
        &args.on.i2c,
    )?;
    let replayed = args.replay.first();
    let replayed = replayed.map(|first| format!("replay of {}", first.display()));
    let streamed = args.stream.as_ref();
    let streamed = streamed.map(|address| format!("stream of {address}"));
    if let Some(name) = replayed.or(streamed) {
        scene.value.touches.clear();
        scene.value.name = name;
    }
    let recorded = read_joints(&args.replay, &timing(args)?)?;
    if !recorded.is_empty() {
        scene.value.joints = recorded;
    }
    let setup = Setup::join(scene, bench)?;
    Ok(match args.observe {
        true => setup.observed()?,
        false => setup,
    })
}

/// The options that stand for keys of the files.
fn overrides(args: &RunArgs) -> Result<Overrides, Failure> {
    let mut overrides = Overrides::default();
    if args.scene.is_none() && (args.stream.is_some() || !args.replay.is_empty()) {
        // Real boards are noisy, drift, and differ: the scene's own rule is for emulated ones.
        let mut recorded = |key, value: &str| overrides.scene("--replay", key, value);
        recorded("threshold", "per-taxel");
        recorded("threshold_margin", &THRESHOLD_FLOOR.to_string());
        recorded("drift_s", &DRIFT_S.to_string());
    }
    let number = |value: Option<f64>| value.map(|v| v.to_string());
    let on = |switch| (switch == Switch::On).to_string();
    for (option, key, value) in [
        ("--layout", "layout", args.layout.clone()),
        ("--illusion", "illusion.model", args.illusion.clone()),
        ("--render", "illusion.render", args.render.clone()),
        ("--felt", "illusion.person", args.felt.clone()),
        ("--shape", "illusion.shape", number(args.shape)),
        ("--alpha", "illusion.alpha", number(args.alpha)),
        ("--beta", "illusion.beta", number(args.beta)),
        ("--tau-d-ms", "illusion.tau_d_ms", number(args.tau_d_ms)),
        ("--soa-ms", "illusion.soa_ms", number(args.soa_ms)),
        ("--intensity", "illusion.intensity", args.intensity.map(on)),
    ] {
        if let Some(value) = value {
            overrides.scene(option, key, value);
        }
    }
    for text in &args.set {
        overrides.set("--set", text)?;
    }
    Ok(overrides)
}
