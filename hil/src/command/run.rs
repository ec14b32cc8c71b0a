//! `hil run`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use palpate_records::verdict::Verdict;

use crate::cli::{Color, RunArgs, Switch};
use crate::trial::{Trial, TrialEnd, Try, judge, junit};
use palpate_files::{
    DRIFT_S, Format, Loaded, Overrides, REFERENCE_ROWS, Scene, Setup, THRESHOLD_FLOOR, Timing,
    format_of, load_scene,
};
use palpate_live::output::{make_folder, note, print, write_text};
use palpate_live::recording::{Reading, ReadingStream, Recorded, read_joints, recorded};
use palpate_live::serve::Foxglove;
use palpate_live::views::Wanted;
use palpate_live::{clock, host};
use palpate_run::{Failure, Input, Keep, KeptReadings, Outcome};

use super::devices::bench_with;
use super::explain;
use super::rate::rate_of;
use super::run_files;
use super::served::{Served, foxglove};

/// The scene of `hil run` without a name.
pub(super) const DEFAULT_SCENE: &str = "sphere-along";

/// Runs a scene or a recording and writes what was asked for.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &RunArgs, color: Color) -> Result<(), Failure> {
    let args = &by_stdout(by_recipe(args)?)?;
    let timing = timing(args)?;
    let setup = setup(args)?;
    let plan = prepare(args, &setup)?;
    if args.explain {
        explained(args, |out| explain::plan(&setup, out))?;
    }
    let paced = !setup.bench.value.is_hardware();
    if args.again && !paced {
        let bench = &setup.bench.value.name;
        return Err(Failure::Input(format!(
            "--loop: expected an emulated bench, found `{bench}`: on hardware a person begins each run"
        )));
    }
    if args.foxglove.is_some() && !setup.fingers.is_empty() {
        return Err(Failure::Input(format!(
            "--foxglove: expected a bench with one display, found {} displays in `{}`; --serve shows them all",
            setup.fingers.len(),
            setup.bench.value.name
        )));
    }
    let foxglove = args.foxglove.map(|port| foxglove(port, paced));
    let foxglove = foxglove.transpose()?;
    let served = args.serve.map(|at| Served::open(at, args.open, paced));
    let served = served.transpose()?;
    let lookers = (served.as_ref(), foxglove.as_ref());
    let mut outcome = play(args, &setup, timing, (&plan, lookers))?;
    let tried = args.junit.is_some().then(|| judge(&setup, &outcome));
    let failure = outcome.failure.take();
    outcome.summary.date = Some(clock::date(clock::unix_us()));
    remark(args, &outcome)?;
    let failed = write(args, &setup, &outcome, (&plan, tried))?;
    if args.explain {
        explained(args, |out| explain::done(&outcome, out))?;
    }
    tell(args, &outcome, &plan.paths, color)?;
    let conclusion = &outcome.summary.conclusion;
    // Who stopped the run has seen how it ended.
    if let Some(served) = served.filter(|_| !args.again && conclusion.verdict != Verdict::Stopped) {
        served.stay();
    }
    match conclusion.verdict {
        Verdict::BeyondTheModel | Verdict::LimitExceeded | Verdict::Incomplete => {
            Err(Failure::Check(conclusion.line()))
        }
        Verdict::Failed
        | Verdict::Stopped
        | Verdict::NotFelt
        | Verdict::OffThePad
        | Verdict::Ok => failure.or(failed).map_or(Ok(()), Err),
    }
}

/// The command line with standard output for `--wav -` alone.
fn by_stdout(mut args: RunArgs) -> Result<RunArgs, Failure> {
    if args.wav.as_deref() == Some(Path::new("-")) {
        if args.voice.json || args.long || args.explain {
            return Err(Failure::Input(
                "--wav -: expected a file, or no --json, --long or --explain: samples have standard output to themselves".into(),
            ));
        }
        args.wav = Some("/dev/stdout".into());
        args.voice.quiet = true;
    }
    Ok(args)
}

/// The command line with what the recipe of its only recording says in place of what was left out.
fn by_recipe(args: &RunArgs) -> Result<RunArgs, Failure> {
    let mut args = args.clone();
    let [file] = args.replay.as_slice() else {
        return match &args.recipe {
            Some(_) => Err(Failure::Input(
                "--recipe: expected one recording of the whole skin (--replay)".into(),
            )),
            None => Ok(args),
        };
    };
    let recorded = Recorded::find(args.recipe.as_deref(), file)?;
    if let (Some(text), false) = (recorded.note(), args.voice.quiet) {
        note(&text);
    }
    args.layout = args.layout.or_else(|| recorded.layout());
    args.time = args.time.or_else(|| recorded.time(args.rate));
    if args.time.is_none() {
        args.rate = args.rate.or_else(|| recorded.rate_hz());
    }
    args.topic = args.topic.or_else(|| recorded.topic());
    args.recipe = recorded.recipe();
    args.replay = vec![recorded.file];
    Ok(args)
}

/// The files of a run, and what the run keeps for them.
struct Plan {
    keep: Keep,
    /// Files that grow while it runs.
    growing: Vec<(Format, PathBuf)>,
    /// Files that are made when it is over.
    after: Vec<(Format, PathBuf)>,
    /// The paths of all files.
    paths: Vec<PathBuf>,
}

/// Looks at what is to be written before anything runs.
fn prepare(args: &RunArgs, setup: &Setup) -> Result<Plan, Failure> {
    let files = run_files::wanted(args, setup)?;
    let wants = |wanted| files.iter().any(|(format, _)| *format == wanted);
    let told = !args.voice.quiet || args.voice.json || wants(Format::Html) || wants(Format::Json);
    let keep = Keep {
        spread: told,
        can: wants(Format::Candump) || wants(Format::Mcap),
        i2c: wants(Format::Mcap),
        audio: wants(Format::Wav),
        readings: match (wants(Format::Mcap), wants(Format::Html)) {
            (true, _) => KeptReadings::All,
            (false, true) => KeptReadings::Sampled,
            (false, false) => KeptReadings::None,
        },
        // A recording may last a day; nothing else looks at what this leaves out.
        summary: !args.replay.is_empty()
            && setup.fingers.is_empty()
            && files.iter().all(|(format, _)| format.grows())
            && args.junit.is_none()
            && !args.watch
            && args.serve.is_none()
            && args.foxglove.is_none()
            && !args.explain,
    };
    let paths = files
        .iter()
        .flat_map(|(format, path)| run_files::paths(*format, path, setup))
        .collect();
    let grow = keep.summary || setup.bench.value.is_hardware();
    let (growing, after) = files
        .into_iter()
        .partition(|(format, _)| grow && format.grows());
    Ok(Plan {
        keep,
        growing,
        after,
        paths,
    })
}

/// Plays a scene or a recording on its bench, before those who look on; with `--loop` until one of them ends it. Then the
/// last run that was whole counts.
fn play(
    args: &RunArgs,
    setup: &Setup,
    timing: Timing,
    (plan, (served, foxglove)): (&Plan, (Option<&Served>, Option<&Foxglove>)),
) -> Result<Outcome, Failure> {
    let wanted = Wanted {
        watch: args.watch,
        live: served.map(|served| &served.live),
        foxglove,
        desk: None,
        quiet: args.voice.quiet,
        files: &plan.growing,
        outputs: run_files::outputs(args),
    };
    let mut whole = None;
    loop {
        let played = played(args, setup, timing.clone(), (plan.keep, wanted));
        if let Some(served) = served {
            served.over(&played);
        }
        if let Some(foxglove) = foxglove {
            foxglove.over(&match &played {
                Ok(outcome) => outcome.summary.conclusion.line(),
                Err(failure) => failure.to_string(),
            });
        }
        let outcome = played?;
        if outcome.summary.conclusion.verdict == Verdict::Stopped {
            return Ok(whole.unwrap_or(outcome));
        }
        let Some(served) = served.filter(|_| args.again) else {
            return Ok(outcome);
        };
        whole = Some(outcome);
        served.live.again()?;
    }
}

fn played(
    args: &RunArgs,
    setup: &Setup,
    timing: Timing,
    (keep, wanted): (Keep, Wanted<'_>),
) -> Result<Outcome, Failure> {
    let sensor = &setup.sensor.value;
    let recipe = match (&args.recipe, args.replay.as_slice()) {
        (Some(recipe), [file]) => Recorded::find(Some(recipe), file)?.plan(sensor)?,
        _ => None,
    };
    let reading = Reading {
        timing: Timing {
            rest_rows: setup.scene.value.reference_frames as usize + 1,
            ..timing
        },
        prefix: args.columns.clone(),
        recipe,
    };
    let (input, notes) = match (&args.stream, args.replay.as_slice()) {
        (Some(address), _) => {
            let stream = ReadingStream::open(address, sensor)?;
            (Input::Stream(stream), Vec::new())
        }
        (None, []) => (Input::Scene, Vec::new()),
        (None, paths) => recorded(paths, sensor, &reading)?,
    };
    // What grows has to be somewhere.
    if let (Some(folder), false) = (&args.out, wanted.files.is_empty()) {
        make_folder(folder)?;
    }
    let outcome = host::run(setup, &input, args.on.seed, keep, wanted);
    let outcome = outcome.map_err(|failure| match (failure, args.replay.first()) {
        // The room for runs knows no files.
        (Failure::Input(text), Some(path)) if text.starts_with("the recording") => {
            Failure::Input(format!("{}: {text}", path.display()))
        }
        (failure, _) => failure,
    })?;
    Ok(Outcome { notes, ..outcome })
}

/// Prints notes on the recordings.
fn remark(args: &RunArgs, outcome: &Outcome) -> Result<(), Failure> {
    outcome.notes.iter().for_each(|text| note(text));
    let rate = rate_of(args.rate, unclocked(args))?;
    if let (Some(hz), Some(meta), false) = (rate.hz, &rate.found_in, args.voice.quiet) {
        note(&format!("{hz} rows a second, from {}", meta.display()));
    }
    Ok(())
}

/// Writes the files of a run that is over, and its result as a trial. Returns the failure of that trial.
fn write(
    args: &RunArgs,
    setup: &Setup,
    outcome: &Outcome,
    (plan, tried): (&Plan, Option<Try>),
) -> Result<Option<Failure>, Failure> {
    // Only now: bad input leaves no empty folder behind.
    if let Some(folder) = &args.out {
        make_folder(folder)?;
    }
    for (format, path) in &plan.after {
        run_files::write(*format, path, setup, outcome)?;
    }
    let (Some(path), Some(tried)) = (&args.junit, tried) else {
        return Ok(None);
    };
    let took = std::time::Duration::from_secs_f64(outcome.summary.wall_s);
    let trial = Trial::new(&setup.scene.value.name, tried, took);
    let failed = match &trial.end {
        TrialEnd::Failed(wrong) => Some(Failure::Check(wrong.why.join("; "))),
        _ => None,
    };
    let text = junit(&[(setup.bench.value.name.clone(), vec![trial])]);
    write_text(path, &text)?;
    Ok(failed)
}

/// The recordings whose rate is to be looked for: none where a column says when rows came.
fn unclocked(args: &RunArgs) -> &[PathBuf] {
    match args.time {
        Some(_) => &[],
        None => &args.replay,
    }
}

/// Prints the result of a run, in the form that the command line chose.
fn tell(
    args: &RunArgs,
    outcome: &Outcome,
    written: &[PathBuf],
    color: Color,
) -> Result<(), Failure> {
    args.voice.tell(
        || &outcome.summary,
        |out| {
            let written = written.iter().map(|path| path.display().to_string());
            let written: Vec<String> = written.collect();
            let how = (args.long, color.on(&io::stdout()));
            outcome.summary.write(out, how, &written)
        },
    )
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

/// Timing of a recording's rows.
fn timing(args: &RunArgs) -> Result<Timing, Failure> {
    Ok(Timing {
        column: args.time.clone(),
        rate_hz: rate_of(args.rate, unclocked(args))?.hz,
        split_jumps: args.split_jumps,
        rest_rows: 0,
        gain: args.gain,
        topic: args.topic.clone(),
    })
}

/// Scene and bench with the command line's changes, checked like a file of that content.
fn setup(args: &RunArgs) -> Result<Setup, Failure> {
    let name = args.scene.as_deref().unwrap_or(DEFAULT_SCENE);
    if let Some(format @ (Format::Csv | Format::Candump | Format::Mcap)) = format_of(name.as_ref())
    {
        return Err(Failure::Input(format!(
            "{name}: expected a scene (TOML), found {}; `hil run --replay {name}` plays a recording",
            format.noun()
        )));
    }
    setup_of(load_scene(name)?, args)
}

/// Scene and bench with the command line's changes, checked, from a scene that is read already.
///
/// # Errors
/// [`Failure`] for what cannot be in the files, or does not fit together.
pub fn setup_of(scene: Loaded<Scene>, args: &RunArgs) -> Result<Setup, Failure> {
    let overrides = overrides(args)?;
    let mut scene = scene.with(&overrides)?;
    let named = args.on.bench.as_deref();
    let named = named.unwrap_or(scene.value.own_bench());
    let bench = bench_with(Some(named), &overrides, &args.on.can, &args.on.i2c)?;
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
        recorded("reference_frames", &REFERENCE_ROWS.to_string());
    }
    let on = |switch| (switch == Switch::On).to_string();
    for (option, key, value) in [
        ("--layout", "layout", args.layout.clone()),
        ("--illusion", "illusion.model", args.illusion.clone()),
        ("--render", "illusion.render", args.render.clone()),
        ("--wearer", "illusion.wearer", args.wearer.clone()),
        ("--person", "illusion.person", args.person.clone()),
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
