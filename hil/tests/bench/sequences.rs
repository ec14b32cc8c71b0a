//! Sequences of short runs on one bench, drawn at random: what is around a run changes between them, and what outlives each is
//! kept. A model that knows nothing of the program's records says which runs are to be refused, and an audit books every burst
//! that the registers saw.
//!
//! `PALPATE_SEQUENCES` says how many are drawn, `PALPATE_STEPS` of how many runs at most, `PALPATE_SEED` which.

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use nix::sys::signal::Signal;
use nix::time::ClockId;
use palpate_tests::fake_bench::{BOOT_ID, Chip, RUN};

use crate::audit::Audit;
use crate::campaign::{BURST_MS, Draws, number};
use crate::damage::{Damage, Kept};
use crate::ledger::guard;
use crate::model::{Certainty, May, Model, Seen};
use crate::names::{NOBODY, has_other_user, names_of};
use crate::rig::{Bench, OFF_MS, nanoseconds, now_ns, once_on_bench};
use crate::run::{Run, Said, signal};
use crate::steps::{Disk, Killed, Step};

/// Sequences of `cargo test`, and their steps.
const FEW: [u64; 2] = [2, 6];
/// The patience with a run that is to end.
const END: Duration = Duration::from_secs(20);
/// The length of a run, seconds.
const LENGTH_S: f64 = 1.2;
/// The length of a run that is killed before its end or has another one beside it, seconds.
const KILLED_S: f64 = 2.0;
/// The state folder in a place where none can be made.
const NOWHERE: &str = "PALPATE_STATE=/proc/nope";

/// A bench, what a person has to do there before anybody may drive, and what was driven.
struct World<'a> {
    bench: &'a Bench,
    draws: Draws,
    audit: Audit,
    has_other_user: bool,
    /// The kernel's number of the adapter.
    adapter: usize,
    model: Model,
    starts: u32,
    /// The begin of the step, nanoseconds.
    begun_ns: u64,
    /// Steps and a person's deeds in words, for who reads a failure.
    story: Vec<String>,
}

impl<'a> World<'a> {
    fn new(bench: &'a Bench, seed: u64) -> Self {
        // One adapter, which may come back under another's number.
        bench.unplug(1);
        for (folder, mode) in [("", 0o777), ("state", 0o1777)] {
            let mode = fs::Permissions::from_mode(mode);
            fs::set_permissions(bench.path(folder), mode).unwrap();
        }
        fs::write(bench.path("bench.toml"), bench.text_on(&[bench.node(0)])).unwrap();
        let scene = bench.scene(LENGTH_S);
        Self {
            audit: Audit::new(bench, guard(bench, &scene)),
            bench,
            draws: Draws(seed.wrapping_mul(0x2545_F491_4F6C_DD1D)),
            has_other_user: has_other_user(),
            adapter: 0,
            model: Model::default(),
            starts: 0,
            begun_ns: 0,
            story: Vec::new(),
        }
    }

    /// Changes of outputs so far: a run that adds none has driven nothing.
    fn changes(&self) -> u64 {
        self.bench.adapters.iter().map(|a| a.state().changes).sum()
    }

    /// Starts a run by a name and as a user that are drawn.
    fn start(&mut self, length_s: f64, nobody: bool, state: Option<&str>) -> Run<'a> {
        let mut names = names_of(self.bench, self.adapter).to_vec();
        names.push(self.bench.node(self.adapter));
        let name = &names[self.draws.below(names.len() as u64) as usize];
        let nobody = nobody || self.draws.below(5) == 0 && self.may_be_nobody();
        if nobody {
            self.model.count("runs of another user");
        }
        self.starts += 1;
        let file = format!("named-{}.toml", self.starts);
        fs::write(
            self.bench.path(&file),
            self.bench.text_on(std::slice::from_ref(name)),
        )
        .unwrap();
        let scene = self.bench.scene(length_s);
        let own = [
            env!("CARGO_BIN_EXE_hil"),
            "run",
            &scene,
            "--bench",
            &file,
            "--quiet",
        ];
        let user = if nobody { &NOBODY[..] } else { &[] };
        let words: Vec<&str> = user.iter().chain(&own).copied().collect();
        let setpriv = ["/usr/bin/setpriv"];
        let program = if nobody { &setpriv[..] } else { &[] };
        let words: Vec<&str> = state
            .into_iter()
            .chain(program.iter().copied())
            .chain(words)
            .collect();
        self.bench
            .start_with(Path::new("/usr/bin/env"), &words, None)
    }

    fn may_be_nobody(&mut self) -> bool {
        if !self.has_other_user {
            self.model.count("skipped: another user");
        }
        self.has_other_user
    }

    /// Carries a step out; what is wrong is told with all that came before.
    fn step(&mut self) {
        let is_refused = self.model.is_refused();
        if is_refused && self.model.is_seen && self.draws.below(4) > 0 {
            self.person();
        }
        let step = Step::draw(&mut self.draws);
        self.model.count(step.kind());
        self.story.push(format!(
            "{step:?} ({:?}, {:?})",
            self.model.stop, self.model.unreadable
        ));
        for socket in ["lo.rx", "lo-1.rx"] {
            let _ = fs::remove_file(self.bench.path(socket));
        }
        let _feed = self.bench.feed();
        self.begun_ns = now_ns();
        let before = self.changes();
        match step {
            Step::Clean => self.run(May::End),
            Step::Kill(killed, after) => self.kill(killed, after),
            Step::Reboot(is_named, is_anew) => {
                self.reboot(is_named, is_anew);
                self.run(May::End);
            }
            Step::Ledger(damage) => {
                let ending = self.draws.pick(&["heat", "dose"]);
                if let Some(file) = crate::ledger::kept(self.bench, ending) {
                    Kept::read(file).harm_ledger(damage, &mut self.draws);
                    self.model.unreadable = Certainty::Yes;
                }
                self.run(May::End);
            }
            Step::Record(damage) => {
                self.harm_record(damage);
                self.run(May::End);
            }
            Step::Lock => self.newer_lock(),
            Step::Disk(disk, whose, from, span) => self.lack(disk, whose, from, span),
            Step::NoFolder => {
                let run = self.start(LENGTH_S, false, Some(NOWHERE));
                self.finish(run, before, May::Refuse);
            }
            Step::OthersFolder if self.may_be_nobody() => self.others_folder(),
            Step::OthersFolder => {}
            Step::Two(after) => self.two(after),
            Step::Port => {
                self.bench.unplug(self.adapter);
                self.adapter = 1 - self.adapter;
                self.bench.plug(self.adapter, "port-0");
                let text = self.bench.text_on(&[self.bench.node(self.adapter)]);
                fs::write(self.bench.path("bench.toml"), text).unwrap();
                self.run(May::End);
            }
            Step::Off => {
                let words = ["--bench", "bench.toml"];
                assert_eq!(self.bench.off(&words).status, Some(0));
                let words = [&words[..], &["--forget-heat", "another"]].concat();
                assert_eq!(self.bench.off(&words).status, Some(2));
                self.run(May::End);
            }
        }
        self.settle();
        self.model.count(if self.changes() == before {
            "steps without a burst"
        } else {
            "steps that drove"
        });
    }

    /// Runs to the end.
    fn run(&mut self, may: May) {
        let before = self.changes();
        let run = self.start(LENGTH_S, false, None);
        self.finish(run, before, may);
    }

    fn finish(&mut self, run: Run<'_>, before: u64, may: May) {
        let said = run.finish(END);
        self.bench.wait_until_alone();
        let drove = self.changes() != before;
        self.judge(&said, drove, may);
    }

    /// Books the bursts of a step that is over.
    fn settle(&mut self) {
        self.bench.wait_until_alone();
        assert!(!self.bench.is_on(), "left on");
        let late = self.bench.take_lateness();
        if self.audit.take(self.bench, late) {
            self.model.count("limits passed, machine late");
        }
        let longest = self.audit.longest_ms;
        assert!(
            longest <= BURST_MS + OFF_MS + late,
            "on for {longest:.1} ms, machine late by {late:.1}"
        );
    }

    fn judge(&mut self, said: &Said, drove: bool, may: May) {
        let seen = Seen {
            drove,
            is_latched: !self.bench.latched().is_empty(),
            longest_ms: self.bench.longest_on_since(self.begun_ns),
            late_ms: self.bench.lateness(),
        };
        self.model.judge(said, seen, may);
    }

    fn kill(&mut self, killed: Killed, after: Duration) {
        let before = self.changes();
        let run = self.start(KILLED_S, false, None);
        let begun = Instant::now();
        if run.ends_within(after) {
            return self.finish(run, before, May::End);
        }
        // Before the scene is over by its clock, which began later.
        let is_early = begun.elapsed().as_secs_f64() < KILLED_S;
        let drove = self.changes() != before;
        let guardian = run.look_for_guardian();
        if let Some(guardian) = guardian.filter(|_| !matches!(killed, Killed::Run)) {
            signal(guardian, Signal::SIGKILL);
        }
        if !matches!(killed, Killed::Guardian) {
            run.kill();
        }
        if matches!(killed, Killed::Both) {
            self.watchdog();
        }
        let is_dead = guardian.is_some() || !matches!(killed, Killed::Guardian);
        if !is_dead {
            return self.finish(run, before, May::End);
        }
        let said = run.finish(END);
        self.bench.wait_until_alone();
        if self.model.is_refused() {
            assert!(self.changes() == before, "it drove: {said:?}");
            return;
        }
        self.model.booked += 1;
        if self.changes() != before {
            self.model.whole = None;
        }
        self.model.stop = match drove && is_early {
            true => Certainty::Yes,
            false => Certainty::Maybe,
        };
        self.model.count("deaths");
    }

    /// Takes all outputs off, as a watchdog on the boards does once the bus is silent: both processes are dead.
    fn watchdog(&self) {
        for page in &self.bench.adapters {
            page.change(now_ns, |state| {
                state.chips = state.chips.map(|chip| Chip::new(chip.address));
            });
        }
    }

    fn reboot(&mut self, is_named: bool, is_anew: bool) {
        self.bench.wait_until_alone();
        if is_named {
            let name = format!("{:016x}\n", self.draws.below(u64::MAX));
            fs::write(self.bench.path(BOOT_ID), name).unwrap();
        }
        if is_anew {
            let now = nanoseconds(ClockId::CLOCK_MONOTONIC) as i64;
            let started = now - self.draws.ms(1000, 30_000).as_nanos() as i64;
            self.bench
                .clock
                .started_ns
                .store(started, Ordering::Release);
        }
    }

    fn record(&self) -> Option<PathBuf> {
        self.bench.records().pop().map(|(path, _)| path)
    }

    fn harm_record(&mut self, damage: Damage) {
        let Some(path) = self.record() else {
            return;
        };
        let kept = Kept::read(path);
        kept.harm_record(damage, &mut self.draws);
        self.model.whole.get_or_insert((kept, self.model.stop));
        // Another byte may be one that says nothing.
        if damage != Damage::Byte {
            self.model.stop = Certainty::Yes;
        } else if self.model.stop == Certainty::No {
            self.model.stop = Certainty::Maybe;
        }
    }

    fn newer_lock(&mut self) {
        let Some(lock) = self.bench.locks().pop() else {
            return self.run(May::End);
        };
        let kept = Kept::read(lock);
        kept.harm_record(Damage::Newer, &mut self.draws);
        self.run(May::Refuse);
        kept.restore();
    }

    fn lack(&mut self, disk: Disk, whose: u32, from: Option<Duration>, span: Duration) {
        let bench = self.bench;
        let scarce = &bench.scarce;
        let lack: &AtomicU32 = match disk {
            Disk::Fails(errno) => {
                scarce.disk_errno.store(errno as u32, Ordering::Release);
                &scarce.disk_fails
            }
            Disk::Hangs => &scarce.disk_hangs,
        };
        let before = self.changes();
        if from.is_none() {
            lack.store(whose, Ordering::Release);
        }
        let run = self.start(LENGTH_S, false, None);
        if let Some(from) = from {
            run.ends_within(from);
            lack.store(whose, Ordering::Release);
        }
        let fails = matches!(disk, Disk::Fails(_));
        run.ends_within(if fails { END } else { span });
        lack.store(0, Ordering::Release);
        let may = match fails && from.is_none() {
            true => May::Refuse,
            // What the guardian does is done.
            false if whose == RUN => May::Lack,
            false => May::Fail,
        };
        self.finish(run, before, may);
    }

    fn others_folder(&mut self) {
        let folders = [("state", 0o1777), ("state/heat", 0o777)];
        let folders = folders.map(|(name, mode)| (self.bench.path(name), mode));
        let set = |mode: Option<u32>| {
            for (folder, own) in folders.iter().filter(|(folder, _)| folder.exists()) {
                let mode = fs::Permissions::from_mode(mode.unwrap_or(*own));
                fs::set_permissions(folder, mode).unwrap();
            }
        };
        let before = self.changes();
        set(Some(0o555));
        let run = self.start(LENGTH_S, true, None);
        self.finish(run, before, May::Refuse);
        set(None);
    }

    /// Two programs, the second by another name: one drives at most.
    fn two(&mut self, after: Duration) {
        let _feed = crate::feed::Feed::start(self.bench.path("lo-1.rx"), 4);
        let before = self.changes();
        let first = self.start(KILLED_S, false, None);
        first.ends_within(after);
        let second = self.start(LENGTH_S, false, None);
        let both = [first, second].map(|run| run.finish(END));
        self.bench.wait_until_alone();
        let drove = self.changes() != before;
        let is_lost = |said: &Said| {
            said.status == Some(3)
                && ["in use by", "another run"]
                    .iter()
                    .any(|w| said.err.contains(w))
        };
        let [lost, won]: [Vec<_>; 2] = [true, false].map(|lost| {
            let these = both.iter().filter(|said| is_lost(said) == lost);
            these.collect()
        });
        assert!(lost.len() < 2, "each lost to the other: {both:?}");
        let ended = won.iter().filter(|said| said.status == Some(0)).count();
        assert!(ended < 2, "both have driven: {both:?}");
        self.model.count(if lost.len() == 1 {
            "second programs refused"
        } else {
            "second programs after a refusal"
        });
        for said in won {
            self.judge(said, drove && said.status == Some(0), May::End);
        }
    }

    /// A person who has looked at the bench does what the refusal says.
    fn person(&mut self) {
        let at = self.adapter;
        let bench = ["--bench", "bench.toml"];
        self.model.is_seen = false;
        if self.model.stop == Certainty::Yes
            && (self.model.unreadable != Certainty::Yes || self.draws.below(2) == 0)
        {
            let said = self.bench.off(&[&["--unlatch"], &bench[..]].concat());
            self.story.push(format!("--unlatch on {at}"));
            match said.status {
                Some(0) => {
                    self.model.stop = Certainty::No;
                    self.model.whole = None;
                }
                // That program clears it, or leaves it as it was.
                _ => {
                    assert!(said.err.contains("newer version"), "{said:?}");
                    let (kept, stop) = self
                        .model
                        .whole
                        .take()
                        .expect("a record of a newer version");
                    kept.restore();
                    self.model.stop = stop;
                }
            }
            self.model.count("stops cleared");
        } else {
            let said = self
                .bench
                .off(&[&bench[..], &["--forget-heat", "fake"]].concat());
            self.story.push("--forget-heat".into());
            assert_eq!(said.status, Some(0), "{said:?}");
            (self.model.unreadable, self.model.booked) = (Certainty::No, 0);
            self.audit.forget();
            self.model.count("heat forgotten");
        }
    }
}

#[test]
fn drawn_sequences_lose_no_stop_and_pass_no_limit() {
    let count = number("PALPATE_SEQUENCES", FEW[0]);
    let steps = number("PALPATE_STEPS", FEW[1]);
    let first = number("PALPATE_SEED", 1);
    for seed in first..first + count {
        let begun = Instant::now();
        once_on_bench(2, |bench| {
            let mut world = World::new(bench, seed);
            for done in 1..=steps {
                let stepped =
                    std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| world.step()));
                assert!(
                    stepped.is_ok(),
                    "PALPATE_SEED={seed}, step {done}: {:#?}",
                    world.story
                );
            }
            let audit = &world.audit;
            println!(
                "sequence {seed}: {steps} steps in {:.0} s, {:?}; {} bursts, the longest {:.1} ms, at most {:?}",
                begun.elapsed().as_secs_f64(),
                world.model.counts,
                audit.bursts,
                audit.longest_ms,
                audit.most
            );
        });
    }
}
