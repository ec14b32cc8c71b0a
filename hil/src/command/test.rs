//! `hil test`: every scene with expectations, as a trial on a bench.

use std::io;
use std::path::PathBuf;

use rayon::prelude::*;

use crate::cli::{Color, TestArgs};
use crate::trial::{
    Goldens, Halt, Held, Member, Suite, Trial, TrialEnd, attempt, decide, expects_anything, junit,
    lacks, last, page, unclaimed,
};
use palpate_files::{
    Bench, BenchKind, FileError, Format, Loaded, Overrides, Quarantine, Setup, Source, sensor_of,
};
use palpate_live::output::{Outputs, print};
use palpate_live::progress::Progress;
use palpate_records::verdict::Verdict;
use palpate_run::Failure;

use super::test_stages::{change, chooses_none, list, stages};
use super::test_told::{FILES, counts, json, slowest, tell};

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
    change(&mut suite, &overrides)?;
    let mut broken = std::mem::take(&mut suite.broken);
    let stages = stages(args, &suite, &overrides, &mut broken)?;
    if args.list {
        return list(args, &stages, &broken);
    }
    for (path, format) in pages(args) {
        outputs(args).check(path, format)?;
    }
    let run = Trials {
        args,
        color,
        told: !args.voice.quiet && !args.voice.json,
        source: stages.first().map_or("emulated", |stage| kind(&stage.0)),
        quarantine: quarantine(args, &suite)?,
        failed_before: failed_before(args, &suite)?,
    };
    let mut suites = Vec::new();
    let mut halt = None;
    let broken = broken.iter();
    let broken = broken.map(|(path, why)| Trial::broken(&path.display().to_string(), why.clone()));
    let mut files: Vec<Trial> = broken.collect();
    for (bench, members) in &stages {
        let (trials, found) = run.on(bench, members)?;
        suites.push((bench.value.name.clone(), trials));
        halt = halt.or(found);
    }
    if let Some(folder) = &suite.folder {
        last::remember(folder, &suites)?;
    }
    if halt.is_none() {
        let names: Vec<&str> = suites.iter().map(|(name, _)| name.as_str()).collect();
        let all_tried = suite.whole && !args.last_failed && chooses_none(args);
        files.extend(unclaimed(&suite, &names, all_tried)?);
    }
    if !files.is_empty() {
        if run.told {
            let colored = run.colored();
            print(|out| files.iter().try_for_each(|trial| tell(trial, colored, out)))?;
        }
        suites.push((FILES.to_owned(), files));
    }
    run.tell(&suites, halt)
}

fn quarantine(args: &TestArgs, suite: &Suite) -> Result<Quarantine, FileError> {
    let Some(path) = args.quarantine.as_ref().or(suite.quarantine.as_ref()) else {
        return Ok(Quarantine::default());
    };
    let mut names: Vec<String> = palpate_fixtures::scene_names().map(str::to_owned).collect();
    names.extend(suite.members.iter().map(|m| m.scene.value.name.clone()));
    Quarantine::read(&Source::open(path)?, &names)
}

/// Trials that failed when the folder was last tried, where only those are wanted.
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

/// Permission of the files of results to replace others.
const fn outputs(args: &TestArgs) -> Outputs<'static> {
    Outputs::new(args.force)
}

/// The files of results that are wanted.
fn pages(args: &TestArgs) -> impl Iterator<Item = (&PathBuf, Format)> {
    let junit = args.junit.iter().map(|path| (path, Format::Junit));
    junit.chain(args.html.iter().map(|path| (path, Format::Html)))
}

/// Common state of all trials of a command.
struct Trials<'a> {
    args: &'a TestArgs,
    color: Color,
    /// True if trials are told as they end.
    told: bool,
    /// Word for the benches: emulated or real.
    source: &'static str,
    quarantine: Quarantine,
    /// Scene and bench of what failed last, where nothing else is tried.
    failed_before: Option<Vec<(String, String)>>,
}

impl Trials<'_> {
    fn colored(&self) -> bool {
        self.color.on(&io::stdout())
    }

    /// The trials on one bench, in order; several at a time where it is emulated.
    fn on(
        &self,
        bench: &Loaded<Bench>,
        members: &[&Member],
    ) -> Result<(Vec<Trial>, Option<Halt>), Failure> {
        let name = &bench.value.name;
        let again = |m: &&Member| {
            let failed = self.failed_before.as_ref();
            failed.is_none_or(|f| f.contains(&(m.scene.value.name.clone(), name.clone())))
        };
        let members: Vec<&Member> = members.iter().copied().filter(again).collect();
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
                    let skipped = |m: &&Member| {
                        Trial::untried(&m.scene.value.name, TrialEnd::Skipped(why.clone()))
                    };
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
            for (member, ended) in some.iter().zip(tried) {
                let (mut trial, found) = match ended {
                    Err(bad @ (Failure::Input(_) | Failure::File(_))) => {
                        let name = &member.scene.value.name;
                        (Trial::broken(name, bad.to_string()), None)
                    }
                    ended => ended?,
                };
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

    /// Tells the result of all trials, on standard output and in files.
    fn tell(&self, suites: &[(String, Vec<Trial>)], halt: Option<Halt>) -> Result<(), Failure> {
        let trials: Vec<&Trial> = suites.iter().flat_map(|(_, trials)| trials).collect();
        let verdict = if !trials.iter().any(|t| t.end.is_tried()) {
            Verdict::Incomplete
        } else if trials.iter().all(|t| t.end.verdict().is_done()) {
            Verdict::Ok
        } else {
            // That a limit was passed is the trial's verdict; of all trials it is that one failed.
            Verdict::Failed
        };
        // Where nothing could be tried, the command line is what is wrong.
        let wrong = |t: &&&Trial| matches!(t.end, TrialEnd::Broken(_));
        let all_wrong = trials.iter().filter(wrong).count() == trials.len();
        let all_wrong = trials.first().filter(|_| all_wrong);
        let mut counts = counts(&trials);
        if verdict == Verdict::Incomplete {
            counts += "; nothing was tested";
        }
        let outputs = outputs(self.args);
        outputs.write_some(self.args.junit.as_deref(), Format::Junit, || junit(suites))?;
        let html = self.args.html.as_deref();
        outputs.write_some(html, Format::Html, || page(verdict, &counts, suites))?;
        if self.args.voice.json {
            json(verdict, self.source, suites)?;
        } else if self.told {
            print(|out| {
                slowest(&trials, out)?;
                let word = verdict.paint(verdict.word(), self.colored());
                writeln!(out, "{word}: {counts}")
            })?;
        }
        if let Some(broken) = all_wrong {
            return Err(Failure::Input(broken.end.why().join("; ")));
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

/// The goldens of a scene that is a file, on a bench.
pub(super) fn goldens_of(member: &Member, bench: &Loaded<Bench>) -> Option<Goldens> {
    let file = member.file.as_deref();
    file.map(|file| Goldens::new(file, &bench.value.name))
}

/// End of the trial of a scene that is not tried on a bench; none where it is tried.
pub(super) fn why_not(
    member: &Member,
    bench: &Loaded<Bench>,
    args: &TestArgs,
) -> Result<Option<TrialEnd>, Failure> {
    let scene = &member.scene;
    if let Some(missing) = scene.value.misses(&bench.value) {
        let own = scene.value.own_bench();
        let why = format!("the scene wants {missing}, such as bench `{own}` has");
        return Ok(Some(TrialEnd::Refused(why)));
    }
    let goldens = goldens_of(member, bench);
    let kept = args.accept || goldens.is_some_and(|g| !g.kinds().is_empty());
    if !expects_anything(&scene.value.expect) && !kept {
        let why = "no [expect] in the scene, and no golden beside it";
        return Ok(Some(TrialEnd::Skipped(why.into())));
    }
    // Before the two are joined, which a display that does not fit would refuse.
    let sensor = sensor_of(scene)?;
    let missing = lacks(&scene.value, &sensor.value, &bench.value);
    let some = (!missing.is_empty()).then(|| missing.join(", "));
    Ok(some.map(|missing| TrialEnd::Skipped(format!("the bench lacks {missing}"))))
}

/// One trial: skipped for what the bench lacks, or run and held against its goldens.
fn one(
    member: &Member,
    bench: &Loaded<Bench>,
    args: &TestArgs,
) -> Result<(Trial, Option<Halt>), Failure> {
    let name = member.scene.value.name.clone();
    if let Some(end) = why_not(member, bench, args)? {
        return Ok((Trial::untried(&name, end), None));
    }
    let goldens = goldens_of(member, bench);
    let setup = Setup::join(member.scene.clone(), bench.clone())?;
    let (mut input, mut held) = (None, Held::default());
    let (mut trial, halt) = decide(&name, args.retries, || {
        let tried = attempt(&setup, args.on.seed, |outcome, wrong| {
            held = match &goldens {
                Some(goldens) if !args.accept => goldens.check(&outcome.trace, wrong)?,
                // What fails its expectations is nothing to keep.
                Some(goldens) if wrong.verdict == Verdict::Ok => goldens.accept(&outcome.trace)?,
                _ => Held::default(),
            };
            Ok(())
        });
        tried.unwrap_or_else(|failure| {
            input.get_or_insert(failure);
            crate::trial::Try {
                halt: Some(Halt::Unwell("it cannot be run on".into())),
                ..Default::default()
            }
        })
    });
    if let Some(failure) = input {
        return Err(failure);
    }
    trial.remark = remark(&held, goldens.as_ref());
    trial.goldens = held;
    Ok((trial, halt))
}

/// Advice on goldens that changed, and on those that hold other benches alone.
fn remark(held: &Held, goldens: Option<&Goldens>) -> Option<String> {
    if let Some(folder) = &held.waits {
        let folder = folder.display();
        return Some(format!(
            "`hil review --goldens {folder}` shows the change, to accept or reject it"
        ));
    }
    let others = goldens.map_or_else(Vec::new, Goldens::of_others);
    let unheld = held.kinds.is_empty() && held.wrote.is_empty() && !others.is_empty();
    unheld.then(|| {
        format!(
            "held by no golden of this bench; there is {}",
            others.join(", ")
        )
    })
}

fn quarantined(trial: Trial, reason: &str) -> Trial {
    match trial.end {
        TrialEnd::Failed(wrong) => Trial {
            end: TrialEnd::Quarantined(wrong, reason.to_owned()),
            ..trial
        },
        TrialEnd::Passed | TrialEnd::Noted(_) | TrialEnd::Unstable(_) => Trial {
            remark: Some("passes although it is quarantined: take it out".to_owned()),
            ..trial
        },
        _ => trial,
    }
}
