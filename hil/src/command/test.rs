//! `hil test`: every scene with expectations, as a trial on a bench.

use std::io::{self, Write};
use std::path::Path;

use crate::cli::{Color, TestArgs};
use crate::output::{print, write_file};
use crate::trial::{Halt, Trial, TrialEnd, attempt, decide, expects_anything, junit, lacks};
use palpate_files::{
    Bench, BenchKind, FileError, Loaded, Overrides, Quarantine, Scene, Setup, Source, did_you_mean,
    load_scene, sensor_of,
};
use palpate_records::verdict::Verdict;
use palpate_run::Failure;

use super::devices::bench_with;

/// Measurements on the line of a trial that passed.
const SHOWN: usize = 3;

/// Runs the trials and says how they ended.
///
/// # Errors
/// [`Failure::Check`] where one failed; [`Failure::Device`] where the bench is not well; [`Failure::Input`] for a filter that fits none, or a file that cannot be.
pub fn test(args: &TestArgs, color: Color) -> Result<(), Failure> {
    let mut overrides = Overrides::default();
    for text in &args.set {
        overrides.set("--set", text)?;
    }
    let bench = bench_with(
        args.on.bench.as_deref(),
        &overrides,
        &args.on.can,
        &args.on.i2c,
    )?;
    let scenes = chosen(args.filter.as_deref())?.into_iter();
    let scenes: Result<Vec<_>, _> = scenes.map(|scene| scene.with(&overrides)).collect();
    let scenes = scenes?;
    let quarantine = quarantine(args, &scenes)?;
    let name = bench.value.name.clone();
    let kind = match bench.value.kind {
        BenchKind::Emulated => "emulated",
        BenchKind::Real => "real",
    };
    let told = !args.voice.quiet && !args.voice.json;
    if told {
        print(|out| {
            let (n, seed) = (scenes.len(), args.on.seed);
            let s = if n == 1 { "" } else { "s" };
            writeln!(out, "{n} trial{s} on {name} ({kind}), seed {seed}")
        })?;
    }
    let mut trials = Vec::new();
    let mut halt: Option<Halt> = None;
    for scene in scenes {
        let mut trial = match &halt {
            Some(why) => Trial::skipped(&scene.value.name, why.to_string()),
            None => {
                let (trial, found) = one(scene, &bench, args)?;
                halt = found;
                trial
            }
        };
        if let Some(reason) = quarantine.reason(&trial.scene, &name) {
            trial = quarantined(trial, reason);
        }
        if told {
            print(|out| tell(&trial, color.on(&io::stdout()), out))?;
        }
        trials.push(trial);
    }
    if let Some(path) = &args.junit {
        let text = junit(&name, &trials);
        write_file(path, |out| out.write_all(text.as_bytes()))?;
    }
    let gravest = trials.iter().map(|t| t.end.verdict()).max();
    let verdict = match gravest.unwrap_or_default() {
        // That a limit was passed is the trial's verdict; of all trials it is that one failed.
        Verdict::Ok => Verdict::Ok,
        _ => Verdict::Failed,
    };
    let counts = counts(&trials);
    if args.voice.json {
        print(|out| json(verdict, (&name, kind), &trials, out))?;
    } else if told {
        print(|out| {
            let word = verdict.paint(verdict.word(), color.on(&io::stdout()));
            writeln!(out, "{word}: {counts}")
        })?;
    }
    match (halt, verdict == Verdict::Failed) {
        (Some(halt @ Halt::Unwell(_)), _) => Err(Failure::Device(halt.to_string())),
        (Some(halt @ Halt::Stopped(_)), _) => Err(Failure::Check(halt.to_string())),
        (None, true) => Err(Failure::Check(counts)),
        (None, false) => Ok(()),
    }
}

/// The built-in scenes whose names contain the filter, or the scene in a file of that name.
fn chosen(filter: Option<&str>) -> Result<Vec<Loaded<Scene>>, Failure> {
    let filter = filter.unwrap_or("");
    if filter.ends_with(".toml") || Path::new(filter).is_file() {
        return Ok(vec![load_scene(filter)?]);
    }
    let names: Vec<&str> = palpate_fixtures::scene_names()
        .filter(|name| name.contains(filter))
        .collect();
    if names.is_empty() {
        let all: Vec<&str> = palpate_fixtures::scene_names().collect();
        let meant = did_you_mean(filter, all.iter().copied());
        return Err(Failure::Input(format!(
            "{filter}: expected part of a scene's name ({}) or a scene file, found neither{meant}",
            all.join(", ")
        )));
    }
    let mut scenes = Vec::new();
    for name in names {
        scenes.push(load_scene(name)?);
    }
    Ok(scenes)
}

fn quarantine(args: &TestArgs, scenes: &[Loaded<Scene>]) -> Result<Quarantine, FileError> {
    let Some(path) = &args.quarantine else {
        return Ok(Quarantine::default());
    };
    let mut names: Vec<String> = palpate_fixtures::scene_names().map(str::to_owned).collect();
    names.extend(scenes.iter().map(|s| s.value.name.clone()));
    Quarantine::read(&Source::open(path)?, &names)
}

/// One trial: skipped for what the bench lacks, or run.
fn one(
    scene: Loaded<Scene>,
    bench: &Loaded<Bench>,
    args: &TestArgs,
) -> Result<(Trial, Option<Halt>), Failure> {
    let name = scene.value.name.clone();
    if !expects_anything(&scene.value.expect) {
        return Ok((
            Trial::skipped(&name, "no [expect] in the scene".into()),
            None,
        ));
    }
    // Before the two are joined, which a display that does not fit would refuse.
    let sensor = sensor_of(&scene)?;
    let missing = lacks(&scene.value, &sensor.value, &bench.value);
    if !missing.is_empty() {
        let why = format!("the bench lacks {}", missing.join(", "));
        return Ok((Trial::skipped(&name, why), None));
    }
    let setup = Setup::join(scene, bench.clone())?;
    let mut input = None;
    let decided = decide(&name, args.retries, || {
        match attempt(&setup, args.on.seed) {
            Ok(tried) => tried,
            Err(failure) => {
                input.get_or_insert(failure);
                crate::trial::Try {
                    halt: Some(Halt::Unwell("it cannot be run on".into())),
                    ..Default::default()
                }
            }
        }
    });
    match input {
        Some(failure) => Err(failure),
        None => Ok(decided),
    }
}

fn quarantined(trial: Trial, reason: &str) -> Trial {
    match trial.end {
        TrialEnd::Failed(wrong) => Trial {
            end: TrialEnd::Quarantined(wrong, reason.to_owned()),
            ..trial
        },
        TrialEnd::Passed | TrialEnd::Unstable(_) => Trial {
            remark: Some("passes although it is quarantined: take it out".to_owned()),
            ..trial
        },
        _ => trial,
    }
}

/// A line for the trial, and more where something is wrong.
fn tell(trial: &Trial, colored: bool, out: &mut dyn Write) -> io::Result<()> {
    // Padded first: the codes of a colour have no width.
    let word = format!("{:<14}", trial.end.word());
    let word = trial.end.verdict().paint(&word, colored);
    let detail = match &trial.end {
        TrialEnd::Passed | TrialEnd::Unstable(_) => {
            let held = trial.measures.iter().filter(|m| m.bound.is_some());
            let words: Vec<String> = held.take(SHOWN).map(|m| m.words()).collect();
            words.join(", ")
        }
        TrialEnd::Skipped(why) => why.clone(),
        TrialEnd::Failed(_) => String::new(),
        TrialEnd::Quarantined(_, reason) => reason.clone(),
    };
    let took = format!("{:.2} s", trial.took.as_secs_f64());
    writeln!(out, "{word}  {:<26} {took:>8}  {detail}", trial.scene)?;
    let more: &[String] = match &trial.end {
        TrialEnd::Unstable(before) => before,
        TrialEnd::Failed(wrong) | TrialEnd::Quarantined(wrong, _) => &wrong.why,
        _ => &[],
    };
    for line in more.iter().chain(&trial.remark) {
        writeln!(out, "                {line}")?;
    }
    Ok(())
}

fn counts(trials: &[Trial]) -> String {
    let count = |counts: fn(&TrialEnd) -> bool| trials.iter().filter(|t| counts(&t.end)).count();
    let (passed, failed) = (
        count(|e| matches!(e, TrialEnd::Passed)),
        count(|e| matches!(e, TrialEnd::Failed(_))),
    );
    let others = [
        (count(|e| matches!(e, TrialEnd::Unstable(_))), "unstable"),
        (
            count(|e| matches!(e, TrialEnd::Quarantined(..))),
            "quarantined",
        ),
        (count(|e| matches!(e, TrialEnd::Skipped(_))), "skipped"),
    ];
    let mut words = format!("{passed} passed, {failed} failed");
    for (n, word) in others.into_iter().filter(|(n, _)| *n > 0) {
        words += &format!(", {n} {word}");
    }
    words
}

fn json(
    verdict: Verdict,
    (bench, kind): (&str, &str),
    trials: &[Trial],
    out: &mut dyn Write,
) -> io::Result<()> {
    let trial = |t: &Trial| {
        let measures: Vec<serde_json::Value> = t
            .measures
            .iter()
            .map(|m| {
                serde_json::json!({
                    "name": m.name, "value": m.value, "unit": m.unit,
                    "limit": m.bound_text(), "good": m.good(),
                })
            })
            .collect();
        let why: &[String] = match &t.end {
            TrialEnd::Passed => &[],
            TrialEnd::Skipped(why) => std::slice::from_ref(why),
            TrialEnd::Unstable(before) => before,
            TrialEnd::Failed(wrong) | TrialEnd::Quarantined(wrong, _) => &wrong.why,
        };
        serde_json::json!({
            "trial": t.scene, "verdict": t.end.key(), "why": why,
            "took_s": t.took.as_secs_f64(), "measures": measures,
        })
    };
    let trials: Vec<serde_json::Value> = trials.iter().map(trial).collect();
    let all =
        serde_json::json!({ "verdict": verdict, "bench": bench, "source": kind, "trials": trials });
    serde_json::to_writer(&mut *out, &all)?;
    writeln!(out)
}
