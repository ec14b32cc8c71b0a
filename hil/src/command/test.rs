//! `hil test`: every scene with expectations, as a trial on a bench.

use std::io::{self, Write};
use std::path::Path;

use crate::cli::TestArgs;
use crate::output::{Outputs, print};
use crate::trial::{Halt, Trial, Verdict, attempt, decide, expects_anything, junit, lacks};
use palpate_files::{
    Bench, BenchKind, FileError, Format, Loaded, Quarantine, Scene, Setup, Source, load_scene,
    sensor_of,
};
use palpate_run::Failure;

use super::devices::bench;

/// Measurements on the line of a trial that passed.
const SHOWN: usize = 3;

/// Runs the trials and says how they ended.
///
/// # Errors
/// [`Failure::Check`] where one failed; [`Failure::Device`] where the bench is not well; [`Failure::Input`] for a filter that fits none, or a file that cannot be.
pub fn test(args: &TestArgs) -> Result<(), Failure> {
    let bench = bench(args.bench.as_deref(), &args.can, &args.i2c)?;
    let scenes = chosen(args.filter.as_deref())?;
    let quarantine = quarantine(args, &scenes)?;
    let outputs = Outputs {
        force: args.force,
        inputs: &[],
    };
    if let Some(path) = &args.junit {
        outputs.check(path, Format::Junit)?;
    }
    let name = bench.value.name.clone();
    let kind = match bench.value.kind {
        BenchKind::Emulated => "emulated",
        BenchKind::Real => "real",
    };
    let told = !args.quiet && !args.json;
    if told {
        print(|out| {
            let (n, seed) = (scenes.len(), args.seed);
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
            print(|out| tell(&trial, out))?;
        }
        trials.push(trial);
    }
    if let Some(path) = &args.junit {
        let text = junit(&name, &trials);
        outputs.write(path, Format::Junit, |out| out.write_all(text.as_bytes()))?;
    }
    let counts = counts(&trials);
    if args.json {
        print(|out| json(&name, kind, &trials, out))?;
    } else if told {
        print(|out| writeln!(out, "{counts}"))?;
    }
    let failed = trials
        .iter()
        .any(|t| matches!(t.verdict, Verdict::Failed(_)));
    match (halt, failed) {
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
        return Err(Failure::Input(format!(
            "{filter}: expected part of a scene's name ({}) or a scene file",
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
    let decided = decide(&name, args.retries, || match attempt(&setup, args.seed) {
        Ok(tried) => tried,
        Err(failure) => {
            input.get_or_insert(failure);
            crate::trial::Try {
                halt: Some(Halt::Unwell("it cannot be run on".into())),
                ..Default::default()
            }
        }
    });
    match input {
        Some(failure) => Err(failure),
        None => Ok(decided),
    }
}

fn quarantined(trial: Trial, reason: &str) -> Trial {
    match trial.verdict {
        Verdict::Failed(wrong) => Trial {
            verdict: Verdict::Quarantined(wrong, reason.to_owned()),
            ..trial
        },
        Verdict::Passed | Verdict::Unstable(_) => Trial {
            remark: Some("passes although it is quarantined: take it out".to_owned()),
            ..trial
        },
        _ => trial,
    }
}

/// A line for the trial, and more where something is wrong.
fn tell(trial: &Trial, out: &mut dyn Write) -> io::Result<()> {
    let word = trial.verdict.word();
    let detail = match &trial.verdict {
        Verdict::Passed | Verdict::Unstable(_) => {
            let held = trial.measures.iter().filter(|m| m.bound.is_some());
            let words: Vec<String> = held.take(SHOWN).map(|m| m.words()).collect();
            words.join(", ")
        }
        Verdict::Skipped(why) => why.clone(),
        Verdict::Failed(_) => String::new(),
        Verdict::Quarantined(_, reason) => reason.clone(),
    };
    let took = format!("{:.2} s", trial.took.as_secs_f64());
    writeln!(out, "  {word:<11} {:<26} {took:>8}  {detail}", trial.scene)?;
    let more: &[String] = match &trial.verdict {
        Verdict::Unstable(before) => before,
        Verdict::Failed(wrong) | Verdict::Quarantined(wrong, _) => wrong,
        _ => &[],
    };
    for line in more.iter().chain(&trial.remark) {
        writeln!(out, "              {line}")?;
    }
    Ok(())
}

fn counts(trials: &[Trial]) -> String {
    let count = |word: &str| trials.iter().filter(|t| t.verdict.word() == word).count();
    let mut parts = vec![format!("{} passed", count("pass"))];
    for (word, plural) in [
        ("FAIL", "failed"),
        ("unstable", "unstable"),
        ("quarantined", "quarantined"),
        ("skip", "skipped"),
    ] {
        let n = count(word);
        if n > 0 || word == "FAIL" {
            parts.push(format!("{n} {plural}"));
        }
    }
    parts.join(", ")
}

fn json(bench: &str, kind: &str, trials: &[Trial], out: &mut dyn Write) -> io::Result<()> {
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
        let why: Vec<String> = match &t.verdict {
            Verdict::Passed => Vec::new(),
            Verdict::Skipped(why) => vec![why.clone()],
            Verdict::Unstable(w) | Verdict::Failed(w) | Verdict::Quarantined(w, _) => w.clone(),
        };
        serde_json::json!({
            "trial": t.scene, "verdict": t.verdict.word().to_lowercase(), "why": why,
            "took_s": t.took.as_secs_f64(), "measures": measures,
        })
    };
    let trials: Vec<serde_json::Value> = trials.iter().map(trial).collect();
    let all = serde_json::json!({ "bench": bench, "source": kind, "trials": trials });
    serde_json::to_writer(&mut *out, &all)?;
    writeln!(out)
}
