//! Heat and dose outlive a process: many runs have the limits of one, a death keeps its reserve booked, and what is not known is
//! refused until a person forgets it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use nix::libc;
use nix::sys::signal::Signal;
use palpate_core::contact::Levels;
use palpate_core::guard::{Booked, Guard};
use palpate_core::units;
use palpate_files::Setup;
use palpate_run::build;
use palpate_tests::fake_bench::RUN;
use serde_json::Value;

use crate::rig::{Bench, is_soon, now_ns, on_bench};
use crate::run::Said;

/// What a run is given to end.
const END: Duration = Duration::from_secs(12);

/// What a run was: its bursts with their wires, and how much was driven, ticks times microseconds.
struct Played {
    said: Said,
    bursts: Vec<(u16, Booked)>,
    driven: u64,
    /// When it ended by its own clock, us, and by this one.
    ended_us: u64,
    over: Instant,
}

/// The guard of the bench, cold.
pub fn guard(bench: &Bench, scene: &str) -> Guard {
    let path = |name: &str| bench.path(name).display().to_string();
    let setup = Setup::load(&path(scene), &path("bench.toml")).unwrap();
    build(&setup, 1, Levels::Off).unwrap().guard().clone()
}

/// A run on a skin that is touched anew.
fn played(bench: &Bench, length_s: f64) -> Played {
    let _ = fs::remove_file(bench.path("lo.rx"));
    let _feed = bench.feed();
    let scene = bench.scene(length_s);
    let words = Bench::run_words(&scene);
    let words = [&words[..], &["--schedule", "schedule.jsonl"]].concat();
    let said = bench.start(&words).finish(END);
    let over = Instant::now();
    let text = fs::read_to_string(bench.path("schedule.jsonl")).unwrap_or_default();
    let guard = guard(bench, &scene);
    let (mut bursts, mut driven, mut ended_us) = (Vec::new(), 0, 0);
    for line in text.lines() {
        let line: Value = serde_json::from_str(line).unwrap();
        let number = |key: &str| line[key].as_u64();
        ended_us = ended_us.max(number("t_us").unwrap_or(0));
        let (Some(channel), Some(on), Some(off)) = (number("channel"), number("on"), number("off"))
        else {
            continue;
        };
        let (at, until) = (number("t_us").unwrap(), number("until_us").unwrap());
        let width = off.saturating_sub(on);
        if width == 0 || until <= at {
            continue;
        }
        driven += width * (until - at);
        let [at, until] = [at, until].map(units::Instant::from_micros);
        let booked = Booked {
            on: at,
            off: until + guard.surplus(),
            energy_nj: guard.energy_nj(units::Ticks::new(width as u16), until.since(at)),
        };
        bursts.push((channel as u16, booked));
    }
    Played {
        said,
        bursts,
        driven,
        ended_us,
        over,
    }
}

/// The file of this ending in the folder of what outlives a run.
pub fn kept(bench: &Bench, ending: &str) -> Option<PathBuf> {
    let entries = fs::read_dir(bench.path("state/heat"));
    let mut files = entries.ok()?.map(|entry| entry.unwrap().path());
    files.find(|path| path.extension().is_some_and(|e| e == ending))
}

#[test]
fn short_runs_one_after_the_other_keep_the_limits_of_one() {
    on_bench(1, |bench| {
        let begun = Instant::now();
        let scene = bench.scene(1.2);
        let mut audit = guard(bench, &scene);
        let mut over_us = 0;
        for number in 0..6 {
            let played = played(bench, 1.2);
            assert_eq!(played.said.status, Some(0), "{:?}", played.said);
            assert!(number > 0 || played.driven > 0, "nothing was driven");
            let end_us = played.over.duration_since(begun).as_micros() as u64;
            let began_us = end_us.saturating_sub(played.ended_us).max(over_us);
            let began = units::Instant::from_micros(began_us);
            over_us = audit.repeat(began, &played.bursts).as_micros();
        }
        let most = audit.predicted();
        assert!(most.peak_c > 34.0, "{most:?}");
        assert!(
            most.peak_c < 43.3 && most.mean_c < 41.3 && most.deep_c < 41.3 && most.cem43_min < 2.0,
            "{most:?}"
        );
        assert!(kept(bench, "heat").is_some() && kept(bench, "dose").is_some());
    });
}

#[test]
fn a_run_that_is_killed_leaves_its_reserve_booked() {
    on_bench(1, |bench| {
        let cold = played(bench, 1.6);
        assert!(cold.driven > 0, "{:?}", cold.said);
        let _ = fs::remove_file(bench.path("lo.rx"));
        let feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        run.kill();
        run.finish(END);
        drop(feed);
        let cleared = bench.off(&["--bench", "bench.toml", "--unlatch"]);
        assert_eq!(cleared.status, Some(0), "{cleared:?}");
        // Whatever it had driven until then, the next run counts with the worst.
        let next = played(bench, 1.6);
        assert_eq!(next.said.status, Some(0), "{:?}", next.said);
        assert!(
            next.driven < cold.driven / 2,
            "{} of {}",
            next.driven,
            cold.driven
        );
        // Once it is forgotten the bench is cold.
        let forgotten = bench.off(&["--bench", "bench.toml", "--forget-heat", "fake"]);
        assert_eq!(forgotten.status, Some(0), "{forgotten:?}");
        let again = played(bench, 1.6);
        assert!(
            again.driven > cold.driven / 2,
            "{} of {}",
            again.driven,
            cold.driven
        );
    });
}

#[test]
fn what_cannot_be_read_is_refused_until_the_bench_s_name_is_typed() {
    on_bench(1, |bench| {
        let feed = bench.feed();
        let said = bench.run(1.0).finish(END);
        assert_eq!(said.status, Some(0), "{said:?}");
        for ending in ["heat", "dose"] {
            let file = kept(bench, ending).unwrap();
            let whole = fs::read(&file).unwrap();
            for length in [0, whole.len() / 2, whole.len() - 1] {
                fs::write(&file, &whole[..length]).unwrap();
                let at = now_ns();
                let refused = bench.run(1.0).finish(END);
                assert_eq!(refused.status, Some(4), "{refused:?}");
                for words in [
                    "it is cut or damaged",
                    "hil off --bench bench.toml --forget-heat fake",
                ] {
                    assert!(refused.err.contains(words), "{words}: {refused:?}");
                }
                assert!(bench.longest_on_since(at) <= 0.0, "it drove");
            }
            let newer = [&whole[..8], &[9, 0, 0, 0], &whole[12..]].concat();
            fs::write(&file, newer).unwrap();
            let refused = bench.run(1.0).finish(END);
            assert_eq!(refused.status, Some(4), "{refused:?}");
            assert!(
                refused.err.contains("found 9: another version"),
                "{refused:?}"
            );
            fs::write(&file, &whole).unwrap();
        }
        fs::write(kept(bench, "heat").unwrap(), "").unwrap();
        let off = |name| bench.off(&["--bench", "bench.toml", "--forget-heat", name]);
        let kept_on = off("another");
        assert_eq!(kept_on.status, Some(2), "{kept_on:?}");
        assert!(kept_on.err.contains("expected `fake`"), "{kept_on:?}");
        let node = bench.node(0).display().to_string();
        let unnamed = bench.off(&["--i2c", &node, "--forget-heat", "emulated"]);
        assert_eq!(unnamed.status, Some(2), "{unnamed:?}");
        assert_eq!(bench.run(1.0).finish(END).status, Some(4));
        let forgotten = off("fake");
        assert_eq!(forgotten.status, Some(0), "{forgotten:?}");
        assert!(
            forgotten.out.contains("heat and dose are forgotten"),
            "{forgotten:?}"
        );
        assert!(off("fake").out.contains("no heat and no dose was kept"));
        drop(feed);
        let said = played(bench, 1.0).said;
        assert_eq!(said.status, Some(0), "{said:?}");
    });
}

#[test]
fn a_disk_that_takes_no_reserve_lets_nothing_drive() {
    for (errno, words) in [
        (libc::ENOSPC, "heat cannot be kept: No space left"),
        (libc::EROFS, "install -d"),
    ] {
        on_bench(1, |bench| {
            let _feed = bench.feed();
            let scarce = &bench.scarce;
            scarce.disk_errno.store(errno as u32, Ordering::Release);
            scarce.disk_fails.store(RUN, Ordering::Release);
            let said = bench.run(1.5).finish(END);
            assert_eq!(said.status, Some(3), "{said:?}");
            assert!(said.err.contains(words), "{said:?}");
            assert!(bench.longest_on() <= 0.0, "it drove");
            assert_eq!(bench.latched(), "");
        });
    }
}

#[test]
fn a_disk_that_hangs_ends_a_run_with_outputs_off() {
    on_bench(1, |bench| {
        let _feed = bench.feed();
        let run = bench.run(30.0);
        run.wait_for_burst();
        bench.scarce.disk_hangs.store(RUN, Ordering::Release);
        let at = now_ns();
        // Four seconds are reserved.
        std::thread::sleep(Duration::from_millis(5200));
        bench.assert_off_within(0.0, at + 4_500_000_000);
        bench.scarce.disk_hangs.store(0, Ordering::Release);
        let said = run.finish(END);
        assert_eq!(said.status, Some(3), "{said:?}");
        assert!(said.err.contains("heat cannot be kept"), "{said:?}");
        assert_eq!(bench.latched(), "");
    });
}

#[test]
fn a_unit_on_hardware_keeps_a_ledger_of_its_own() {
    on_bench(1, |bench| {
        let made = bench.start(&["unit", "--new-key", "unit.key"]);
        assert_eq!(made.finish(END).status, Some(0));
        let words = ["unit", "--key", "unit.key", "--bench", "bench.toml"];
        let words = [&words[..], &["--at", "127.0.0.1:0", "--quiet"]].concat();
        let unit = bench.start(&words);
        assert!(is_soon(END, || kept(bench, "dose").is_some()
            && kept(bench, "heat").is_some()));
        unit.signal(Signal::SIGINT);
        let said = unit.finish(END);
        assert_eq!(said.status, Some(0), "{said:?}");
        let file = kept(bench, "dose").unwrap();
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        assert!(name.starts_with("unit-on-"), "{name}");
        fs::write(&file, "").unwrap();
        let refused = bench.start(&words).finish(END);
        assert_eq!(refused.status, Some(4), "{refused:?}");
        assert!(refused.err.contains("--forget-heat fake"), "{refused:?}");
        let forgotten = bench.off(&["--bench", "bench.toml", "--forget-heat", "fake"]);
        assert_eq!(forgotten.status, Some(0), "{forgotten:?}");
        assert!(!Path::new(&file).exists());
    });
}
