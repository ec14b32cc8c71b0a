//! `hil run`.

use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::Arc;

use palpate_records::verdict::Verdict;

use crate::cli::{Color, RunArgs, Switch};
use crate::clock;
use crate::host::{Onlooker, Records};
use crate::output::{Outputs, make_folder, note, print, write_file};
use crate::real::{self, Told};
use crate::recording::{Reading, ReadingStream, read_joints, recorded};
use crate::serve::Live;
use crate::trial::{Trial, TrialEnd, judge, junit};
use crate::views::Wanted;
use palpate_files::{
    DRIFT_S, Loaded, Overrides, Scene, Setup, THRESHOLD_FLOOR, Timing, load_scene,
};
use palpate_run::{Failure, Input, Keep, KeptReadings, Outcome, attachments, run_with};

use crate::record::Kind as LiveKind;

use super::devices::bench_with;
use super::explain;
use super::rate::rate_of;
use super::run_files::{Format, split, wanted};

/// The scene of `hil run` without a name.
pub(super) const DEFAULT_SCENE: &str = "sphere-along";

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
        band: told || args.serve.is_some(),
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
            && args.serve.is_none()
            && !args.explain,
    };
    let written = files
        .iter()
        .flat_map(|(format, path)| format.paths(path, &setup));
    let written: Vec<PathBuf> = written.collect();
    let is_real = setup.bench.value.is_hardware();
    let mut growing = Vec::new();
    if is_real || keep.summary {
        (growing, files) = split(files);
    }
    let reading = Reading {
        timing,
        prefix: args.columns.clone(),
        rest_rows: setup.scene.value.reference_frames as usize + 1,
    };
    let live = args.serve.map(Live::open).transpose()?;
    if let Some(live) = &live {
        let pace = match is_real {
            true => "",
            false => "; the run keeps to the wall clock",
        };
        note(&format!("live view: {}{pace}", live.url));
    }
    let views = Wanted {
        watch: args.watch,
        live: live.as_ref(),
        desk: None,
    };
    let ran = if is_real {
        on_hardware(args, &setup, &reading, (views, &growing))
    } else {
        emulated(args, &setup, &reading, views, (keep, growing))
    };
    if let Some(live) = &live {
        live.over(&match &ran {
            Ok(outcome) => outcome.summary.conclusion.line(),
            Err(failure) => failure.to_string(),
        });
    }
    let mut outcome = ran?;
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
    views: Wanted<'_>,
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
    let mut host = Onlooker::new(views, records);
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

/// A scene or recording on hardware, with the records that grow while it runs.
fn on_hardware(
    args: &RunArgs,
    setup: &Setup,
    reading: &Reading,
    (views, growing): (Wanted<'_>, &[(LiveKind, PathBuf)]),
) -> Result<Outcome, Failure> {
    let sensor = &setup.sensor.value;
    let (input, notes) = match (&args.stream, args.replay.as_slice()) {
        (Some(address), _) => (
            Input::Stream(ReadingStream::open(address, sensor)? as _),
            Vec::new(),
        ),
        (None, []) => (Input::Scene, Vec::new()),
        (None, paths) => recorded(paths, sensor, reading)?,
    };
    if let Some(folder) = &args.out {
        make_folder(folder)?;
    }
    let told = Told {
        quiet: args.voice.quiet,
        views,
    };
    let outputs = Outputs {
        force: args.force,
        ..Outputs::NEW
    };
    let wanted = real::Wanted {
        files: growing,
        outputs,
        told,
    };
    let outcome = real::run(setup, &input, args.on.seed, wanted)?;
    Ok(Outcome { notes, ..outcome })
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
    let on = |switch| (switch == Switch::On).to_string();
    for (option, key, value) in [
        ("--layout", "layout", args.layout.clone()),
        ("--illusion", "illusion.model", args.illusion.clone()),
        ("--render", "illusion.render", args.render.clone()),
        ("--wearer", "illusion.wearer", args.wearer.clone()),
        ("--felt", "illusion.person", args.felt.clone()),
        ("--intensity", "illusion.intensity", args.intensity.map(on)),
    ] {
        if let Some(value) = value {
            overrides.scene(option, key, value);
        }
    }
    for text in &args.set {
        overrides.set("--set", text)?;
    }
    args.unit.change(&mut overrides);
    Ok(overrides)
}
