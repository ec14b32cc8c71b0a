//! `hil test`: every scene with expectations, as a trial on a bench.

use std::io::{self, Write};
use std::path::PathBuf;

use rayon::prelude::*;

use crate::cli::{Color, TestArgs};
use crate::trial::{
    Goldens, Halt, Member, Suite, Trial, TrialEnd, attempt, decide, expects_anything, junit, lacks,
    last, page,
};
use palpate_files::{
    Bench, BenchKind, FileError, Format, Loaded, Overrides, Quarantine, Setup, Source, load_bench,
    sensor_of,
};
use palpate_live::output::{Outputs, print, print_json};
use palpate_live::progress::Progress;
use palpate_records::verdict::Verdict;
use palpate_run::Failure;
use serde::Serialize;

use super::devices::bench_with;

/// Measurements on the line of a trial that passed.
const SHOWN: usize = 3;

/// Runs the trials and says how they ended.
///
/// # Errors
/// [`Failure::Check`] where one failed or nothing was tried; [`Failure::Device`] where the bench is not well;
/// [`Failure::Input`] for a name that fits none, or a file that cannot be.
pub fn test(args: &TestArgs, color: Color) -> Result<(), Failure> {
    let mut overrides = Overrides::default();
    for text in &args.set {
        overrides.set("--set", text)?;
    }
    let mut suite = Suite::collect(&args.targets, args.filter.as_deref())?;
    for member in &mut suite.members {
        member.scene = member.scene.clone().with(&overrides)?;
    }
    let benches = benches(args, &suite, &overrides)?;
    for (path, format) in pages(args) {
        outputs(args).check(path, format)?;
    }
    let run = Run {
        args,
        color,
        told: !args.voice.quiet && !args.voice.json,
        source: benches.first().map_or("emulated", kind),
        quarantine: quarantine(args, &suite)?,
        failed_before: failed_before(args, &suite)?,
    };
    let mut suites = Vec::new();
    let mut halt = None;
    for bench in &benches {
        let (trials, found) = run.on(bench, &suite)?;
        suites.push((bench.value.name.clone(), trials));
        halt = halt.or(found);
    }
    if let Some(folder) = &suite.folder {
        last::remember(folder, &suites)?;
    }
    run.tell(&suites, halt)
}

/// The benches that are meant: the one named, else the emulated ones in the folders, else the one that ships.
fn benches(
    args: &TestArgs,
    suite: &Suite,
    overrides: &Overrides,
) -> Result<Vec<Loaded<Bench>>, Failure> {
    let on = &args.on;
    if on.bench.is_none() && on.can.is_empty() && on.i2c.is_empty() {
        let mut found = Vec::new();
        for path in &suite.benches {
            let bench = load_bench(&path.display().to_string())?.with(overrides)?;
            if bench.value.kind == BenchKind::Emulated {
                found.push(bench);
            }
        }
        if !found.is_empty() {
            return Ok(found);
        }
    }
    // A bench of the folders may be meant by the name of its file.
    let named = on.bench.as_deref().map(|name| {
        let same = |p: &&PathBuf| p.file_stem().is_some_and(|stem| stem == name);
        let path = suite.benches.iter().find(same);
        path.map_or_else(|| name.to_owned(), |p| p.display().to_string())
    });
    Ok(vec![bench_with(
        named.as_deref(),
        overrides,
        &on.can,
        &on.i2c,
    )?])
}

fn quarantine(args: &TestArgs, suite: &Suite) -> Result<Quarantine, FileError> {
    let Some(path) = args.quarantine.as_ref().or(suite.quarantine.as_ref()) else {
        return Ok(Quarantine::default());
    };
    let mut names: Vec<String> = palpate_fixtures::scene_names().map(str::to_owned).collect();
    names.extend(suite.members.iter().map(|m| m.scene.value.name.clone()));
    Quarantine::read(&Source::open(path)?, &names)
}

/// What failed when the folder was last tried, where only that is wanted.
fn failed_before(args: &TestArgs, suite: &Suite) -> Result<Option<Vec<(String, String)>>, Failure> {
    if !args.last_failed {
        return Ok(None);
    }
    let Some(folder) = &suite.folder else {
        return Err(Failure::Input(
            "--last-failed: expected a folder; what failed is remembered there".into(),
        ));
    };
    // Where nothing failed, everything is tried.
    Ok(Some(last::failed(folder)?).filter(|failed| !failed.is_empty()))
}

/// What the files of results may replace.
const fn outputs(args: &TestArgs) -> Outputs<'static> {
    Outputs::of(args.force)
}

/// The files of results that are wanted.
fn pages(args: &TestArgs) -> impl Iterator<Item = (&PathBuf, Format)> {
    let junit = args.junit.iter().map(|path| (path, Format::Junit));
    junit.chain(args.html.iter().map(|path| (path, Format::Html)))
}

/// What all trials of a command share.
struct Run<'a> {
    args: &'a TestArgs,
    color: Color,
    /// Whether trials are told as they end.
    told: bool,
    /// Whether the benches are emulated or real.
    source: &'static str,
    quarantine: Quarantine,
    /// Scene and bench of what failed last, where nothing else is tried.
    failed_before: Option<Vec<(String, String)>>,
}

impl Run<'_> {
    fn colored(&self) -> bool {
        self.color.on(&io::stdout())
    }

    /// The trials on one bench, in order; several at a time where it is emulated.
    fn on(
        &self,
        bench: &Loaded<Bench>,
        suite: &Suite,
    ) -> Result<(Vec<Trial>, Option<Halt>), Failure> {
        let name = &bench.value.name;
        let again = |m: &&Member| {
            let failed = self.failed_before.as_ref();
            failed.is_none_or(|f| f.contains(&(m.scene.value.name.clone(), name.clone())))
        };
        let members: Vec<&Member> = suite.members.iter().filter(again).collect();
        if self.told {
            let (n, kind, seed) = (members.len(), kind(bench), self.args.on.seed);
            let s = if n == 1 { "" } else { "s" };
            print(|out| writeln!(out, "{n} trial{s} on {name} ({kind}), seed {seed}"))?;
        }
        let cores = || std::thread::available_parallelism().map_or(1, Into::into);
        let jobs = match bench.value.kind {
            BenchKind::Emulated => self.args.jobs.unwrap_or_else(cores),
            BenchKind::Real => 1, // there is one
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(jobs).build();
        let pool = pool.map_err(|e| Failure::Device(format!("--jobs {jobs}: {e}")))?;
        let (mut trials, mut halt) = (Vec::new(), None);
        let progress = Progress::counted("test", members.len() as u64, "trials");
        for some in members.chunks(jobs) {
            let tried: Vec<Result<(Trial, Option<Halt>), Failure>> = match &halt {
                Some(why) => {
                    let why = ToString::to_string(why);
                    let skipped = |m: &&Member| Trial::skipped(&m.scene.value.name, why.clone());
                    some.iter().map(|m| Ok((skipped(m), None))).collect()
                }
                None => {
                    let one = |m: &&Member| {
                        let ended = one(m, bench, self.args);
                        progress.step();
                        ended
                    };
                    pool.install(|| some.par_iter().map(one).collect())
                }
            };
            for ended in tried {
                let (mut trial, found) = ended?;
                halt = halt.or(found);
                if let Some(reason) = self.quarantine.reason(&trial.scene, name) {
                    trial = quarantined(trial, reason);
                }
                if self.told {
                    print(|out| tell(&trial, self.colored(), out))?;
                }
                trials.push(trial);
            }
        }
        Ok((trials, halt))
    }

    /// What all came to, on standard output and in files.
    fn tell(&self, suites: &[(String, Vec<Trial>)], halt: Option<Halt>) -> Result<(), Failure> {
        let trials: Vec<&Trial> = suites.iter().flat_map(|(_, trials)| trials).collect();
        let skipped = |t: &&&Trial| matches!(t.end, TrialEnd::Skipped(_));
        let verdict = match trials.iter().map(|t| t.end.verdict()).max() {
            _ if trials.iter().filter(skipped).count() == trials.len() => Verdict::Incomplete,
            None | Some(Verdict::Ok) => Verdict::Ok,
            // That a limit was passed is the trial's verdict; of all trials it is that one failed.
            Some(_) => Verdict::Failed,
        };
        let mut counts = counts(&trials);
        if verdict == Verdict::Incomplete {
            counts += "; nothing was tested";
        }
        if let Some(path) = &self.args.junit {
            let text = junit(suites);
            outputs(self.args).write(path, Format::Junit, |out| out.write_all(text.as_bytes()))?;
        }
        if let Some(path) = &self.args.html {
            let text = page(verdict, &counts, suites);
            outputs(self.args).write(path, Format::Html, |out| out.write_all(text.as_bytes()))?;
        }
        if self.args.voice.json {
            json(verdict, self.source, suites)?;
        } else if self.told {
            print(|out| {
                let word = verdict.paint(verdict.word(), self.colored());
                writeln!(out, "{word}: {counts}")
            })?;
        }
        match (halt, verdict) {
            (Some(halt @ Halt::Unwell(_)), _) => Err(Failure::Device(halt.to_string())),
            (Some(halt @ Halt::Stopped(_)), _) => Err(Failure::Check(halt.to_string())),
            (None, Verdict::Ok) => Ok(()),
            (None, _) => Err(Failure::Check(counts)),
        }
    }
}

const fn kind(bench: &Loaded<Bench>) -> &'static str {
    match bench.value.kind {
        BenchKind::Emulated => "emulated",
        BenchKind::Real => "real",
    }
}

/// One trial: skipped for what the bench lacks, or run and held against its goldens.
fn one(
    member: &Member,
    bench: &Loaded<Bench>,
    args: &TestArgs,
) -> Result<(Trial, Option<Halt>), Failure> {
    let scene = &member.scene;
    let name = scene.value.name.clone();
    let goldens = member.file.as_deref();
    let goldens = goldens.map(|file| Goldens::of(file, &bench.value.name));
    let kept = args.accept || goldens.as_ref().is_some_and(Goldens::exist);
    if !expects_anything(&scene.value.expect) && !kept {
        let why = "no [expect] in the scene, and no golden beside it";
        return Ok((Trial::skipped(&name, why.into()), None));
    }
    // Before the two are joined, which a display that does not fit would refuse.
    let sensor = sensor_of(scene)?;
    let missing = lacks(&scene.value, &sensor.value, &bench.value);
    if !missing.is_empty() {
        let why = format!("the bench lacks {}", missing.join(", "));
        return Ok((Trial::skipped(&name, why), None));
    }
    let setup = Setup::join(scene.clone(), bench.clone())?;
    let mut input = None;
    let decided = decide(&name, args.retries, || {
        let tried = attempt(&setup, args.on.seed, |outcome, wrong| match &goldens {
            Some(goldens) if !args.accept => goldens.check(&outcome.trace, wrong),
            // What fails its expectations is nothing to keep.
            Some(goldens) if wrong.verdict == Verdict::Ok => goldens.accept(&outcome.trace),
            _ => Ok(()),
        });
        tried.unwrap_or_else(|failure| {
            input.get_or_insert(failure);
            crate::trial::Try {
                halt: Some(Halt::Unwell("it cannot be run on".into())),
                ..Default::default()
            }
        })
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

fn counts(trials: &[&Trial]) -> String {
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

fn json(verdict: Verdict, source: &str, suites: &[(String, Vec<Trial>)]) -> Result<(), Failure> {
    let trial = |bench: &str, t: &Trial| {
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
            "trial": t.scene, "bench": bench, "verdict": t.end.key(), "why": why,
            "took_s": t.took.as_secs_f64(), "measures": measures,
        })
    };
    let of = |(bench, trials): &(String, Vec<Trial>)| -> Vec<_> {
        trials.iter().map(|t| trial(bench, t)).collect()
    };
    let trials: Vec<serde_json::Value> = suites.iter().flat_map(of).collect();
    let benches: Vec<&str> = suites.iter().map(|(bench, _)| bench.as_str()).collect();
    /// In this order: the verdict first.
    #[derive(Serialize)]
    struct All<'a> {
        verdict: Verdict,
        bench: String,
        source: &'a str,
        trials: Vec<serde_json::Value>,
    }
    let all = All {
        verdict,
        bench: benches.join(", "),
        source,
        trials,
    };
    print_json(&all)
}
