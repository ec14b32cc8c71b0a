//! Runs that die while wires are driven, and what the emulated chip says of it: nothing may stay on.
//!
//! Every death falls at a random moment within a burst. The delay is the emulator's: from the moment before the
//! blow to its `all_off`, in the lab's own time. `PALPATE_DEATHS` says how many of each kind (default 3, CI 20,
//! soak 200 and 50); `PALPATE_DEATH` chooses `sigkill` or `others`; `PALPATE_SEED` moves the moments.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::process::{Child, Command, Stdio};
use std::time::Duration;

use nix::sys::ptrace;
use nix::sys::signal::{Signal, kill};
use nix::sys::wait::{WaitPidFlag, WaitStatus, waitpid};
use nix::time::{ClockId, clock_gettime};
use nix::unistd::Pid;
use serde_json::Value;

use super::emulator::Emulator;
use super::tools::{here, in_lab, scratch, sh, try_sh};

/// Time for whatever still wants to drive to show itself, after everything was off.
const QUIET: Duration = Duration::from_millis(700);

/// A way to die.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Death {
    /// By a signal.
    By(Signal),
    /// The loop's thread alone stands still; everything else of the program lives.
    Hang,
    /// The kernel's out-of-memory killer takes it.
    OutOfMemory,
    /// The guardian dies, the run lives.
    Guardian,
}

const DEATHS: [Death; 9] = [
    Death::By(Signal::SIGKILL),
    Death::By(Signal::SIGINT),
    Death::By(Signal::SIGTERM),
    Death::By(Signal::SIGHUP),
    Death::By(Signal::SIGABRT),
    Death::By(Signal::SIGSTOP),
    Death::Hang,
    Death::OutOfMemory,
    Death::Guardian,
];

/// The clock of the emulator's events.
fn now_ns() -> u64 {
    let now = clock_gettime(ClockId::CLOCK_MONOTONIC).unwrap();
    now.tv_sec() as u64 * 1_000_000_000 + now.tv_nsec() as u64
}

/// Moments from a seed: a linear congruential generator is random enough for those.
struct Moments(u64);

impl Moments {
    /// Milliseconds below `limit`.
    fn below(&mut self, limit: u64) -> Duration {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        Duration::from_millis((self.0 >> 33) % limit)
    }
}

fn number_of(name: &str, default: u64) -> u64 {
    let said = std::env::var(name).ok();
    said.map_or(default, |n| n.parse().unwrap())
}

/// A run on the emulator's nodes; the boards begin the scene with its start command.
fn run(emulator: &Emulator, options: &str) -> Child {
    sh("cansend vcan0 20F#0701");
    let hil = std::env::var("PALPATE_HIL").unwrap();
    let line = format!(
        "exec {hil} run sphere-along --quiet --bench {} --can vcan0 --i2c {} {options}",
        here().join("suite/bench.toml").display(),
        emulator.node
    );
    Command::new("sh")
        .args(["-c", &line])
        .stdin(Stdio::null())
        .spawn()
        .unwrap()
}

/// The guardian of a run.
fn guardian_of(run: &Child) -> Pid {
    let found = sh(&format!("pgrep -P {} hil", run.id()));
    Pid::from_raw(found.trim().parse().unwrap())
}

impl Death {
    fn strike(self, run: &Child, guardian: Pid) {
        let pid = Pid::from_raw(run.id() as i32);
        match self {
            Self::By(signal) => kill(pid, signal).unwrap(),
            Self::Guardian => kill(guardian, Signal::SIGKILL).unwrap(),
            Self::OutOfMemory => {
                sh(&format!(
                    "echo 1000 > /proc/{pid}/oom_score_adj; echo f > /proc/sysrq-trigger"
                ));
            }
            Self::Hang => stop_thread(pid, "loop"),
        }
    }
}

/// Stops one thread of a process, by its name, until somebody kills the process.
fn stop_thread(pid: Pid, name: &str) {
    let threads = std::fs::read_dir(format!("/proc/{pid}/task")).unwrap();
    let is_named = |path: &std::path::PathBuf| {
        let comm = std::fs::read_to_string(path.join("comm"));
        comm.is_ok_and(|comm| comm.trim() == name)
    };
    let found = threads.map(|t| t.unwrap().path()).find(is_named).unwrap();
    let thread = found.file_name().unwrap().to_string_lossy().parse();
    let thread = Pid::from_raw(thread.unwrap());
    let (send, stopped) = std::sync::mpsc::channel();
    // A thread's tracer is a thread too, and has to take note of its end.
    std::thread::spawn(move || {
        ptrace::seize(thread, ptrace::Options::empty()).unwrap();
        ptrace::interrupt(thread).unwrap();
        send.send(()).unwrap();
        while let Ok(status) = waitpid(thread, Some(WaitPidFlag::__WALL)) {
            if matches!(status, WaitStatus::Exited(..) | WaitStatus::Signaled(..)) {
                return;
            }
        }
    });
    stopped.recv().unwrap();
}

/// Waits until the chip drives, then for a moment within the burst.
fn wait_for_a_burst(emulator: &mut Emulator, moments: &mut Moments) {
    emulator.wait_for("driving");
    std::thread::sleep(moments.below(35));
}

/// When everything was off for good, after a blow at `struck_ns`; waits until nothing more happens. `None` for
/// a chip that is still driven.
fn off_for_good(emulator: &mut Emulator, struck_ns: u64) -> Option<u64> {
    emulator.hear_until_quiet(QUIET);
    let of = |told: &&Value| matches!(told["event"].as_str(), Some("driving" | "all_off"));
    let last = emulator.told.iter().rev().find(of)?;
    let t_ns = last["t_ns"].as_u64().unwrap();
    (last["event"] == "all_off").then_some(t_ns.saturating_sub(struck_ns))
}

/// Looks at the bench and clears the stop, as the documents say.
fn way_back(emulator: &Emulator) -> String {
    let hil = std::env::var("PALPATE_HIL").unwrap();
    sh(&format!("{hil} off --unlatch --i2c {}", emulator.node))
}

#[test]
fn no_death_leaves_an_output_on() {
    if !in_lab("deaths of a run") {
        return;
    }
    let (count, seed) = (number_of("PALPATE_DEATHS", 3), number_of("PALPATE_SEED", 1));
    let mut moments = Moments(seed);
    let mut emulator = Emulator::start(&["--await-start", "--scene", "sphere-along"]);
    let mut left_on = Vec::new();
    let chosen = std::env::var("PALPATE_DEATH").unwrap_or_default();
    let is_chosen = |death: &Death| match chosen.as_str() {
        "sigkill" => *death == DEATHS[0],
        "others" => *death != DEATHS[0],
        _ => true,
    };
    let file = scratch("death.log");
    for death in DEATHS.into_iter().filter(is_chosen) {
        let mut delays = Vec::new();
        for n in 0..count {
            let mut run = run(&emulator, &format!("--record {}", file.display()));
            wait_for_a_burst(&mut emulator, &mut moments);
            let guardian = guardian_of(&run);
            let struck = now_ns();
            death.strike(&run, guardian);
            let ended = run.wait().unwrap();
            // Only when both are gone is nobody left who could still switch off.
            while std::fs::exists(format!("/proc/{guardian}")).unwrap() {
                std::thread::sleep(Duration::from_millis(20));
            }
            match off_for_good(&mut emulator, struck) {
                Some(delay_ns) => delays.push(delay_ns as f64 * 1e-6),
                None => left_on.push(format!("{death:?} {n}")),
            }
            if matches!(
                death,
                Death::By(Signal::SIGINT | Signal::SIGTERM | Signal::SIGHUP)
            ) {
                assert!(ended.success(), "{death:?}: {ended}");
            }
            // What was recorded until then is whole lines of a log.
            let log = std::fs::read_to_string(&file).unwrap();
            assert!(
                log.lines().count() > 100 && log.ends_with('\n'),
                "{death:?}"
            );
            way_back(&emulator);
        }
        delays.sort_by(f64::total_cmp);
        println!(
            "{death:?}: {} deaths, off {:.1} ms after (median), {:.1} ms at worst",
            delays.len(),
            delays.get(delays.len() / 2).unwrap_or(&f64::NAN),
            delays.last().unwrap_or(&f64::NAN)
        );
    }
    assert!(left_on.is_empty(), "outputs left on: {left_on:?}");
    assert_eq!(emulator.stop()["driving"], Value::Array(Vec::new()));
}

#[test]
fn run_and_guardian_killed_at_once_leave_outputs_on_until_hil_off() {
    if !in_lab("run and guardian killed at once") {
        return;
    }
    let mut emulator = Emulator::start(&["--await-start", "--scene", "sphere-along"]);
    let mut moments = Moments(1);
    let mut stayed_on = false;
    for _ in 0..10 {
        let mut run = run(&emulator, "");
        emulator.wait_for("driving");
        std::thread::sleep(moments.below(10));
        let guardian = guardian_of(&run);
        kill(guardian, Signal::SIGSTOP).unwrap();
        kill(Pid::from_raw(run.id() as i32), Signal::SIGKILL).unwrap();
        kill(guardian, Signal::SIGKILL).unwrap();
        run.wait().unwrap();
        stayed_on = off_for_good(&mut emulator, 0).is_none();
        if stayed_on {
            break;
        }
        way_back(&emulator);
    }
    assert!(stayed_on, "ten blows, none of them within a burst");
    // No software is left. The next one to look finds the chip driving, and says so.
    let said = way_back(&emulator);
    assert!(said.contains("was driving channels"), "{said}");
    assert!(off_for_good(&mut emulator, 0).is_some(), "hil off");
    emulator.stop();
}

#[test]
fn an_adapter_that_was_unplugged_and_comes_back_is_switched_off_first() {
    if !in_lab("an adapter unplugged") {
        return;
    }
    let mut emulator = Emulator::start(&["--await-start", "--scene", "sphere-along"]);
    let mut run = run(&emulator, "");
    emulator.wait_for("driving");
    let driver = "/sys/bus/hid/drivers/mcp2221";
    let device = sh(&format!("ls {driver} | grep -m1 04D8"));
    sh(&format!("echo {} > {driver}/unbind", device.trim()));
    std::thread::sleep(Duration::from_secs(6)); // beyond the run's own patience
    sh(&format!("echo {} > {driver}/bind", device.trim()));
    assert!(
        off_for_good(&mut emulator, 0).is_some(),
        "still driven after it came back"
    );
    let ended = run.wait().unwrap();
    assert_eq!(ended.code(), Some(3));
    way_back(&emulator);
    emulator.stop();
}

#[test]
fn silence_on_can_and_a_full_disk_end_in_outputs_off() {
    if !in_lab("CAN silence and a full disk") {
        return;
    }
    let mut emulator = Emulator::start(&["--await-start", "--scene", "sphere-along"]);
    let mut silent = run(&emulator, "");
    emulator.wait_for("driving");
    let struck = now_ns();
    sh("ip link set vcan0 down");
    let delay = off_for_good(&mut emulator, struck).expect("CAN silence");
    println!("CAN silence: off {:.1} ms after", delay as f64 * 1e-6);
    sh("ip link set vcan0 up");
    assert!(
        silent.wait().unwrap().success(),
        "the run survives the silence"
    );

    let small = scratch("small");
    let disk = small.display();
    sh(&format!(
        "mkdir -p {disk}; mount -t tmpfs -o size=64k tmpfs {disk}"
    ));
    let file = small.join("a.log");
    let mut full = run(&emulator, &format!("--record {}", file.display()));
    emulator.wait_for("driving");
    let ended = full.wait().unwrap();
    assert_eq!(ended.code(), Some(3));
    assert!(off_for_good(&mut emulator, 0).is_some(), "full disk");
    let log = std::fs::read_to_string(&file).unwrap();
    assert!(log.lines().count() > 100);
    try_sh(&format!("umount {disk}"));
    emulator.stop();
}
