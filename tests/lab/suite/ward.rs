//! A run under observation: started, struck, and looked after until no process is left that could switch off.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use embedded_hal::i2c::I2c;
use linux_embedded_hal::I2cdev;
use nix::sys::ptrace;
use nix::sys::wait::{WaitPidFlag, WaitStatus, waitpid};
use nix::time::{ClockId, clock_gettime};
use nix::unistd::Pid;
use palpate_buses::can::Endpoint;
use palpate_buses::guardian::Latch;
use palpate_buses::hardware::Hardware;
use palpate_buses::lock::BusLock;
use palpate_core::codec::can::CanFrame;

use super::emulator::{Emulator, at};
use super::tools::{hil, scene, scratch, sh};

/// Time in which whatever is still driven shows itself: two periods of the chip and a turn of the emulator.
const QUIET: Duration = Duration::from_millis(60);

/// The heartbeat's limit of the suite's bench.
pub const HEARTBEAT_MS: u64 = 40;

/// Off within this: from a death, from the first transfer that fails, from the last reading. Bursts come every 58.5 ms and last
/// 35 ms.
pub const LIMIT_NS: u64 = 100_000_000;

/// The clock of the emulator's events.
pub fn now_ns() -> u64 {
    let now = clock_gettime(ClockId::CLOCK_MONOTONIC).unwrap();
    now.tv_sec() as u64 * 1_000_000_000 + now.tv_nsec() as u64
}

/// Moments from a seed: a linear congruential generator is random enough for those.
pub struct Moments(pub u64);

impl Moments {
    /// A time below `limit`, by the microsecond.
    pub fn below(&mut self, limit: Duration) -> Duration {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        Duration::from_micros((self.0 >> 33) % limit.as_micros() as u64)
    }
}

/// What became of the outputs after a blow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// Off, so many nanoseconds after the blow; none for a blow between two bursts.
    Off(Option<u64>),
    /// Still driven.
    On,
}

/// The guard has stopped a run because this machine was too slow for it: nothing can be learnt from that run.
#[derive(Debug)]
pub struct TooSlow;

/// Tries again where the machine was too slow, three times in all.
#[track_caller]
pub fn patiently(mut attempt: impl FnMut() -> Result<(), TooSlow>) {
    for _ in 0..3 {
        match attempt() {
            Ok(()) => return,
            Err(TooSlow) => println!("this machine was too slow: late-tick; once more"),
        }
    }
    panic!("this machine is too slow to be tested on: late-tick three times");
}

/// From now on no heat and no dose is booked: what a death leaves would keep the next run from driving at once.
pub fn cool() {
    sh("rm -rf /var/lib/palpate/heat");
}

/// The emulator with everything that runs on it needs.
pub struct Ward {
    pub emulator: Emulator,
    bench: PathBuf,
    can: Endpoint,
    /// What run and guardian say.
    said: PathBuf,
}

/// A run and its guardian.
pub struct Run {
    pub child: Child,
    pub guardian: Pid,
}

/// The latch of the adapter of a node.
pub fn latch_of(node: &str) -> Latch {
    Latch::new(&Hardware::adapter(Path::new(node)).unwrap())
}

/// Clears the stop of that adapter, once no guardian holds it any more.
pub fn unlatch(node: &str) {
    let hardware = Hardware::adapter(Path::new(node)).unwrap();
    for _ in 0..1000 {
        if let Ok(lock) = BusLock::take(&hardware) {
            Latch::new(&hardware).clear(&lock).unwrap();
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("somebody holds {node}");
}

impl Ward {
    /// A scene that begins with a start command, on boards that stand still.
    pub fn open(scene_file: &str, options: &[&str]) -> Self {
        Self::open_on("bench.toml", scene_file, options)
    }

    /// Opens one for a bench of the suite.
    pub fn open_on(bench_file: &str, scene_file: &str, options: &[&str]) -> Self {
        let all = [&["--await-start", "--scene", scene_file], options].concat();
        let emulator = Emulator::start(&all);
        let bench = scratch("bench.toml");
        let text = std::fs::read_to_string(scene(bench_file)).unwrap();
        let mut text = text.replace("/dev/i2c-0", &emulator.node);
        if let Some(chip) = &emulator.oe {
            let oe = format!("[real]\noe = {{ chip = \"{chip}\", line = 0 }}\n");
            text = text.replace("[real]\n", &oe);
        }
        std::fs::write(&bench, text).unwrap();
        let can = Endpoint::open("vcan0", &[]).unwrap();
        let this = Self {
            emulator,
            bench,
            can,
            said: scratch("said"),
        };
        this.unlatch();
        cool();
        this.stop_boards();
        this
    }

    pub fn latch(&self) -> Latch {
        latch_of(&self.emulator.node)
    }

    pub fn unlatch(&self) {
        unlatch(&self.emulator.node);
    }

    pub fn bench(&self) -> &Path {
        &self.bench
    }

    /// From now on the boards are silent, until a start command.
    pub fn stop_boards(&self) {
        let stop = CanFrame::new(0x20F, &[0x07, 0x01]).unwrap();
        self.can.send(&stop).unwrap();
    }

    /// `hil run` on this emulator's nodes.
    pub fn command(&self, scene_file: &str, options: &[&str]) -> Command {
        let mut command = Command::new(hil());
        command
            .args(["run", scene_file, "--bench"])
            .arg(&self.bench)
            .args(options)
            .env("PALPATE_DRILL", "1")
            .stdin(Stdio::null());
        command
    }

    /// A run that has begun to drive.
    pub fn run(&mut self, scene_file: &str, options: &[&str]) -> Run {
        self.run_until("driving", scene_file, options)
    }

    /// A run, once the emulator has told of this.
    pub fn run_until(&mut self, event: &str, scene_file: &str, options: &[&str]) -> Run {
        self.run_heard(event, scene_file, options, |_| {})
    }

    /// Runs a command as [`Self::run_until`] does; `hear` gets its words so far, again and again.
    pub fn run_heard(
        &mut self,
        event: &str,
        scene_file: &str,
        options: &[&str],
        mut hear: impl FnMut(&str),
    ) -> Run {
        self.stop_boards();
        cool();
        // An earlier run's events may still wait to be heard.
        self.emulator.hear(Duration::ZERO);
        self.emulator.told.clear();
        let said = File::create(&self.said).unwrap();
        let mut command = self.command(scene_file, options);
        let mut child = command.stdout(Stdio::null()).stderr(said).spawn().unwrap();
        self.emulator.wait_while(event, || {
            let ended = child.try_wait().unwrap();
            let said = std::fs::read_to_string(&self.said);
            assert!(ended.is_none(), "the run has ended by itself: {said:?}");
            hear(&said.unwrap_or_default());
        });
        let guardian = guardian_of(&child);
        Run { child, guardian }
    }

    /// Whether the guard has stopped a run for want of speed.
    ///
    /// # Errors
    /// [`TooSlow`].
    pub fn check_speed(&self) -> Result<(), TooSlow> {
        let held = self.latch().read();
        let slow = held.is_some_and(|held| held.cause.starts_with("late-tick"));
        if slow { Err(TooSlow) } else { Ok(()) }
    }

    /// Waits until the outputs are driven, or off.
    ///
    /// # Errors
    /// [`TooSlow`], when that is why it does not happen.
    pub fn wait_for_outputs(&mut self, driven: bool) -> Result<(), TooSlow> {
        for _ in 0..100 {
            self.emulator.hear(Duration::from_millis(10));
            if self.emulator.is_driving == driven {
                return Ok(());
            }
            self.emulator.hear(Duration::from_millis(190));
        }
        self.check_speed()?;
        panic!("outputs driven: {driven} was awaited; {}", self.said());
    }

    /// What run and guardian have said.
    pub fn said(&self) -> String {
        std::fs::read_to_string(&self.said).unwrap()
    }

    /// [`fate`] of this ward's outputs.
    pub fn fate(&mut self, struck_ns: u64) -> Fate {
        fate(&mut self.emulator, struck_ns)
    }
}

/// What has become of the outputs since the blow, once nothing more happens.
pub fn fate(emulator: &mut Emulator, struck_ns: u64) -> Fate {
    // An answer: everything that was asked before it has been done.
    let mut look = [0];
    if let Ok(mut bus) = I2cdev::new(&emulator.node) {
        let _ = bus.write_read(0x40_u8, &[0], &mut look);
    }
    emulator.hear_until_quiet(QUIET);
    let of =
        |told: &&serde_json::Value| matches!(told["event"].as_str(), Some("driving" | "all_off"));
    let mut told = emulator.told.iter().filter(of).rev();
    match told.next() {
        Some(last) if last["event"] == "driving" => Fate::On,
        Some(last) => Fate::Off(at(last).checked_sub(struck_ns)),
        None => Fate::Off(None),
    }
}

impl Run {
    pub fn pid(&self) -> Pid {
        Pid::from_raw(self.child.id() as i32)
    }

    /// Waits until neither run nor guardian is left.
    pub fn end(&mut self) -> ExitStatus {
        let ended = self.child.wait().unwrap();
        while std::fs::exists(format!("/proc/{}", self.guardian)).unwrap() {
            std::thread::sleep(Duration::from_millis(5));
        }
        ended
    }
}

impl Drop for Run {
    /// A failed test leaves no process behind.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The guardian of a run: its only child.
pub fn guardian_of(run: &Child) -> Pid {
    let threads = std::fs::read_dir(format!("/proc/{}/task", run.id())).unwrap();
    let children = threads.map(|t| std::fs::read_to_string(t.unwrap().path().join("children")));
    let children: String = children.map(Result::unwrap).collect();
    Pid::from_raw(children.trim().parse().unwrap())
}

/// Stops one thread of a process, by its name, until the process is killed.
pub fn stop_thread(pid: Pid, name: &str) {
    let threads = std::fs::read_dir(format!("/proc/{pid}/task")).unwrap();
    let is_named = |path: &PathBuf| {
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
