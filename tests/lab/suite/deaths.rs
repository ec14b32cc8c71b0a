//! Runs that die while wires are driven, and what the emulated chip says of it: nothing may stay on.
//!
//! Every death falls at a random moment. The delay is the emulator's: from the moment before the blow to its
//! `all_off`, in the lab's own time, which does not pass while its host does something else. `PALPATE_DEATHS` says how many of each kind (default 20), `PALPATE_DEATH`
//! chooses one kind or `others` than SIGKILL, `PALPATE_SEED` moves the moments.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use palpate_records::{candump, mcap};

use super::tools::{hil, in_lab, number_of, scene, scratch, sh, text, try_sh};
use super::ward::{Fate, LIMIT_NS, Moments, Run, Ward, now_ns, stop_thread};

/// Bursts come every 58.5 ms; a blow falls anywhere in the first four.
const WITHIN: Duration = Duration::from_millis(234);
/// Longer than any turn may take.
const LATE: Duration = Duration::from_millis(200);

/// A way to die.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Death {
    /// By a signal.
    By(Signal),
    /// The loop panics.
    Panic,
    /// The loop's thread alone stands still; everything else of the program lives.
    Hang,
    /// The kernel's out-of-memory killer takes it.
    OutOfMemory,
    /// The guardian dies, the run lives.
    Guardian,
    /// The boards fall silent.
    Silence,
    /// Run and guardian stand still for a while, and then go on.
    Frozen,
    /// Nothing can be recorded any more.
    FullDisk,
}

const DEATHS: [Death; 13] = [
    Death::By(Signal::SIGKILL),
    Death::By(Signal::SIGINT),
    Death::By(Signal::SIGTERM),
    Death::By(Signal::SIGHUP),
    Death::By(Signal::SIGABRT),
    Death::By(Signal::SIGSTOP),
    Death::Panic,
    Death::Hang,
    Death::OutOfMemory,
    Death::Guardian,
    Death::Silence,
    Death::Frozen,
    Death::FullDisk,
];

impl Death {
    /// Strikes; returns when.
    fn strike(self, ward: &Ward, run: &Run, disk: &Path) -> u64 {
        let struck = now_ns();
        match self {
            Self::By(signal) => kill(run.pid(), signal).unwrap(),
            Self::Panic => kill(run.pid(), Signal::SIGUSR1).unwrap(),
            Self::Guardian => kill(run.guardian, Signal::SIGKILL).unwrap(),
            Self::Silence => ward.stop_boards(),
            Self::Hang => stop_thread(run.pid(), "loop"),
            Self::OutOfMemory => {
                std::fs::write(format!("/proc/{}/oom_score_adj", run.pid()), "1000").unwrap();
                std::fs::write("/proc/sysrq-trigger", "f").unwrap();
            }
            Self::Frozen => {
                let both = [run.pid(), run.guardian];
                both.iter()
                    .for_each(|pid| kill(*pid, Signal::SIGSTOP).unwrap());
                std::thread::sleep(LATE);
                both.iter()
                    .for_each(|pid| kill(*pid, Signal::SIGCONT).unwrap());
                // Until then nothing could have done anything.
                return now_ns();
            }
            Self::FullDisk => {
                let _ = std::fs::write(disk.join("filler"), vec![0; 1 << 20]); // until there is no more room
            }
        }
        struck
    }

    /// Whether the run lives on without outputs, until it is told to end.
    const fn lives(self) -> bool {
        matches!(self, Self::Silence | Self::Frozen)
    }

    /// Milliseconds until everything has to be off.
    fn limit_ms(self) -> f64 {
        let limit_ms = LIMIT_NS as f64 * 1e-6;
        match self {
            // A full disk is found by the next write.
            Self::FullDisk => 3.0 * limit_ms,
            _ => limit_ms,
        }
    }

    /// How the run has to end, and what has to be latched.
    fn check(self, ward: &Ward, code: Option<i32>, signal: Option<i32>, fate: Fate) {
        let cause = ward.latch().read().map(|held| held.cause);
        let cause = cause.as_deref();
        match self {
            Self::By(Signal::SIGINT | Signal::SIGTERM | Signal::SIGHUP) => {
                assert_eq!((code, cause), (Some(0), None), "{self:?}");
            }
            Self::Guardian | Self::FullDisk => {
                assert_eq!((code, cause), (Some(3), None), "{self:?}")
            }
            Self::Panic => assert_eq!(
                (code, cause),
                (Some(3), Some("the run died without a word"))
            ),
            Self::By(Signal::SIGSTOP) | Self::Hang => {
                assert_eq!(signal, Some(Signal::SIGKILL as i32), "{self:?}");
                assert!(
                    cause.unwrap().starts_with("the run hung"),
                    "{self:?}: {cause:?}"
                );
            }
            Self::By(_) | Self::OutOfMemory => {
                assert!(signal.is_some(), "{self:?}: {code:?}");
                assert_eq!(cause, Some("the run died without a word"), "{self:?}");
            }
            // Between two bursts there is nothing to stop.
            Self::Silence if cause.is_none() => {
                assert_eq!(code, Some(0), "{self:?}: {fate:?}");
            }
            Self::Frozen => {
                // It ends by itself, or the guardian ends it.
                assert_ne!(code, Some(0), "{self:?}");
                assert!(cause.is_some(), "{self:?}");
            }
            Self::Silence => {
                assert_eq!(code, Some(4), "{self:?}");
                let cause = cause.unwrap();
                let known = cause.starts_with("stale-input") || cause.starts_with("late-tick");
                assert!(known, "{self:?}: {cause}");
            }
        }
    }
}

/// What was recorded up to a death opens: `log`, which lies on a disk that may be full, and two files beside it.
fn check_records(death: Death, log: &Path, [messages, pins]: [&Path; 2]) {
    let text = std::fs::read_to_string(log).unwrap();
    let frames = candump::read(&text).unwrap().frames;
    assert!(
        frames.len() > 100 && text.ends_with('\n'),
        "{death:?}: {} frames, {} bytes",
        frames.len(),
        text.len()
    );
    let read = mcap::read(&std::fs::read(messages).unwrap()).unwrap();
    let whole = read
        .frames
        .iter()
        .zip(&frames)
        .all(|(a, b)| a.frame == b.frame);
    assert!(
        whole && !read.frames.is_empty() && read.damages.len() <= 1,
        "{death:?}: {} frames, {:?}",
        read.frames.len(),
        read.damages
    );
    // A VCD is written in blocks: its last line may be torn, nothing else.
    let dump = std::fs::read_to_string(pins).unwrap();
    let lines = &dump[..=dump.rfind('\n').unwrap()];
    let mut parser = vcd::Parser::new(lines.as_bytes());
    let header = parser.parse_header().unwrap();
    assert!(!header.items.is_empty(), "{death:?}: no signals");
    for command in parser {
        assert!(command.is_ok(), "{death:?}: {command:?}");
    }
}

/// The kinds that `PALPATE_DEATH` asks for.
fn chosen() -> Vec<Death> {
    let wanted = std::env::var("PALPATE_DEATH").unwrap_or_default();
    let is_chosen = |death: &Death| match wanted.as_str() {
        "" => true,
        "others" => *death != DEATHS[0],
        name => format!("{death:?}").to_lowercase().contains(name),
    };
    DEATHS.into_iter().filter(is_chosen).collect()
}

#[test]
fn no_death_leaves_an_output_on() {
    if !in_lab("deaths of a run") {
        return;
    }
    let (count, seed) = (
        number_of("PALPATE_DEATHS", 20),
        number_of("PALPATE_SEED", 1),
    );
    let mut moments = Moments(seed);
    let press = scene("press.toml");
    let mut ward = Ward::open(&press, &[]);
    let disk = scratch("disk");
    std::fs::create_dir_all(&disk).unwrap();
    sh(&format!(
        "mount -t tmpfs -o size=512k tmpfs {}",
        disk.display()
    ));
    let file = disk.join("death.log");
    let (messages, pins) = (scratch("death.mcap"), scratch("death.vcd"));
    let records = [&file, &messages, &pins].map(|path| path.display().to_string());
    let records: Vec<_> = records.iter().flat_map(|path| ["--record", path]).collect();
    let (mut left_on, mut late) = (Vec::new(), Vec::new());
    for death in chosen() {
        let began = now_ns();
        let mut delays = Vec::new();
        let (mut n, mut void, mut latched) = (0, 0, 0);
        while n < count {
            let mut run = ward.run(&press, &records);
            std::thread::sleep(moments.below(WITHIN));
            let stopped = ward.latch().read();
            let struck = death.strike(&ward, &run, &disk);
            if death.lives() {
                std::thread::sleep(Duration::from_millis(150));
                kill(run.pid(), Signal::SIGINT).unwrap();
            }
            // Only when both are gone is no process left that could still switch off.
            let ended = run.end();
            let fate = ward.fate(struck);
            let _ = std::fs::remove_file(disk.join("filler"));
            if fate == Fate::On {
                left_on.push(format!("{death:?} {n}"));
            }
            // A guard that had stopped the run before the blow, for a machine too slow: no death to count.
            let held = ward.latch().read();
            let is_late = held
                .as_ref()
                .is_some_and(|h| h.cause.starts_with("late-tick"));
            if stopped.is_some() || !death.lives() && is_late {
                ward.unlatch();
                void += 1;
                assert!(
                    void <= count,
                    "{death:?}: this machine is too slow to be tested on"
                );
                continue;
            }
            n += 1;
            if let Fate::Off(Some(ns)) = fate {
                let ms = ns as f64 * 1e-6;
                if ms > death.limit_ms() {
                    late.push(format!("{death:?}: {ms:.1} ms"));
                }
                delays.push(ms);
            }
            death.check(&ward, ended.code(), ended.signal(), fate);
            latched += u64::from(held.is_some());
            ward.unlatch();
            check_records(death, &file, [&messages, &pins]);
        }
        // Some blows fall into a burst, and those stop the run.
        assert!(!death.lives() || count < 10 || latched > 0, "{death:?}");
        delays.sort_by(f64::total_cmp);
        println!(
            "{death:?}: {count} deaths, {} with an output on: off {:.1} ms after (median), {:.1} ms at worst; {void} void, {:.1} s each",
            delays.len(),
            delays.get(delays.len() / 2).unwrap_or(&f64::NAN),
            delays.last().unwrap_or(&f64::NAN),
            (now_ns() - began) as f64 * 1e-9 / count as f64
        );
    }
    try_sh(&format!("umount {}", disk.display()));
    assert!(left_on.is_empty(), "outputs left on: {left_on:?}");
    assert!(late.is_empty(), "off too late: {late:?}");
    assert_eq!(ward.emulator.stop()["driving"], serde_json::json!([]));
}

#[test]
fn run_and_guardian_killed_at_once_leave_outputs_on_until_hil_off() {
    if !in_lab("run and guardian killed at once") {
        return;
    }
    let press = scene("press.toml");
    let mut ward = Ward::open(&press, &[]);
    let mut moments = Moments(1);
    let mut stayed_on = false;
    for _ in 0..20 {
        let mut run = ward.run(&press, &[]);
        std::thread::sleep(moments.below(Duration::from_millis(20)));
        kill(run.guardian, Signal::SIGSTOP).unwrap();
        kill(run.pid(), Signal::SIGKILL).unwrap();
        kill(run.guardian, Signal::SIGKILL).unwrap();
        run.end();
        stayed_on = ward.fate(0) == Fate::On;
        if stayed_on {
            break;
        }
        // What the guardian had armed is a stop now that nobody is left.
        ward.unlatch();
    }
    assert!(stayed_on, "twenty blows, none of them within a burst");
    // No software is left. The next one to look finds the chip driving, and says so.
    let bench = ward.bench().display();
    let doctor = try_sh(&format!("{} doctor --bench {bench}", hil().display()));
    let doctor = text(&doctor.stdout);
    assert!(doctor.contains("was driving channels"), "{doctor}");
    let said = sh(&format!("{} off --bench {bench}", hil().display()));
    assert!(said.contains("was driving channels"), "{said}");
    assert!(matches!(ward.fate(0), Fate::Off(_)), "hil off");
    ward.emulator.stop();
}
