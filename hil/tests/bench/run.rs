//! A program that was started on a bench: what it drives, who guards it, and what becomes of it.

use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus};
use std::sync::Mutex;
use std::thread;
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

use crate::rig::{Bench, is_on, is_soon, now_ns};

/// A run drives by then: it has to start, to look at its boards, and to know its skin.
const ON: Duration = Duration::from_secs(8);
/// A guardian that has nothing left to do is gone by then.
const GUARDED: Duration = Duration::from_secs(5);

/// What a program came to.
#[derive(Debug)]
pub struct Said {
    /// Its exit status; none where a signal ended it.
    pub status: Option<i32>,
    /// What it wrote.
    pub out: String,
    /// What it and its guardian wrote to standard error.
    pub err: String,
}

/// A program that was started.
pub struct Run<'a> {
    bench: &'a Bench,
    child: Mutex<Child>,
    out: PathBuf,
    err: PathBuf,
    guardian: Mutex<Option<u32>>,
}

impl<'a> Run<'a> {
    /// Of a process and the files of its output.
    pub fn new(bench: &'a Bench, child: Child, out: PathBuf, err: PathBuf) -> Self {
        Self {
            bench,
            child: Mutex::new(child),
            out,
            err,
            guardian: Mutex::new(None),
        }
    }

    /// Its process.
    pub fn id(&self) -> u32 {
        self.child.lock().unwrap().id()
    }

    fn ended(&self) -> Option<ExitStatus> {
        self.child.lock().unwrap().try_wait().unwrap()
    }

    /// Returns when a channel is on and the guardian is known.
    #[track_caller]
    pub fn wait_until_on(&self) {
        self.wait_for(|| self.bench.is_on());
        let guardian = self.look_for_guardian();
        guardian.expect("a run that drives has a guardian");
    }

    /// The guardian's process, where the run has started it by now.
    pub fn look_for_guardian(&self) -> Option<u32> {
        let guardian = guardian_of(self.id())?;
        *self.guardian.lock().unwrap() = Some(guardian);
        self.bench.leave(guardian);
        Some(guardian)
    }

    /// Returns at the beginning of a burst, some bursts after the first: which adapter drives it.
    #[track_caller]
    pub fn wait_for_burst(&self) -> usize {
        self.wait_until_on();
        for _ in 0..2 {
            self.wait_for(|| !self.bench.is_on());
            self.wait_for(|| self.bench.is_on());
        }
        let adapters = &self.bench.adapters;
        adapters.iter().position(|page| is_on(page)).unwrap_or(0)
    }

    #[track_caller]
    fn wait_for(&self, so: impl Fn() -> bool) {
        let seen = Cell::new(false);
        is_soon(ON, || {
            seen.set(so());
            seen.get() || self.ended().is_some()
        });
        assert!(seen.get(), "it does not drive: {:?}", self.texts());
    }

    /// The guardian's process, of a run that was on.
    pub fn guardian(&self) -> u32 {
        self.guardian.lock().unwrap().expect("the run was on")
    }

    /// Sends a signal to the run.
    pub fn signal(&self, which: Signal) {
        signal(self.id(), which);
    }

    /// Kills the run; the moment of it.
    pub fn kill(&self) -> u64 {
        let at = now_ns();
        self.signal(Signal::SIGKILL);
        at
    }

    /// Kills the run and its guardian at once.
    pub fn kill_both(&self) {
        signal(self.guardian(), Signal::SIGKILL);
        self.signal(Signal::SIGKILL);
        self.wait_for_guardian();
    }

    /// Returns when the guardian has done what it had to.
    #[track_caller]
    pub fn wait_for_guardian(&self) {
        let guardian = self.guardian();
        let gone = || !runs(self.bench.path("").as_path(), guardian);
        assert!(
            is_soon(GUARDED, gone),
            "the guardian goes on: {:?}",
            self.texts()
        );
    }

    /// Whether it ends by itself in this time, whatever its guardian does.
    pub fn ends_within(&self, limit: Duration) -> bool {
        is_soon(limit, || self.ended().is_some())
    }

    /// Words on its standard error so far.
    pub fn told(&self) -> String {
        self.texts().1
    }

    fn texts(&self) -> (String, String) {
        let text = |path: &Path| String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned();
        (text(&self.out), text(&self.err))
    }

    /// What it came to, once it and its guardian have ended.
    #[track_caller]
    pub fn finish(self, limit: Duration) -> Said {
        let over = is_soon(limit, || self.ended().is_some());
        assert!(over, "it goes on after {limit:?}: {:?}", self.texts());
        if self.guardian.lock().unwrap().is_some() {
            self.wait_for_guardian();
        }
        let status = self.ended().and_then(|status| status.code());
        let (out, err) = self.texts();
        assert!(!err.contains("panicked"), "{err}");
        Said { status, out, err }
    }
}

impl Drop for Run<'_> {
    fn drop(&mut self) {
        if self.ended().is_none() {
            let mut child = self.child.lock().unwrap();
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Sends a signal to a process that may be gone.
pub fn signal(process: u32, which: Signal) {
    let _ = kill(Pid::from_raw(process as i32), which);
}

/// Stops processes, lets time pass, and lets them go on.
pub fn freeze(processes: &[u32], span: Duration, before_waking: impl Fn()) {
    processes.iter().for_each(|id| signal(*id, Signal::SIGSTOP));
    thread::sleep(span);
    before_waking();
    processes.iter().for_each(|id| signal(*id, Signal::SIGCONT));
}

/// Whether this process is one of a bench's, and runs.
pub fn runs(folder: &Path, process: u32) -> bool {
    let environment = fs::read(format!("/proc/{process}/environ")).unwrap_or_default();
    // Its number may be another's by now; who is dead has no environment.
    let name = folder.to_string_lossy();
    String::from_utf8_lossy(&environment).contains(name.trim_end_matches('/'))
}

/// The guardian that a run has started.
fn guardian_of(run: u32) -> Option<u32> {
    let entries = fs::read_dir("/proc").unwrap().flatten();
    let mut processes = entries.filter_map(|e| e.file_name().to_str()?.parse().ok());
    processes.find(|process: &u32| {
        let words = fs::read(format!("/proc/{process}/cmdline")).unwrap_or_default();
        let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
        let parent = stat
            .rsplit_once(')')
            .and_then(|(_, s)| s.split_whitespace().nth(1));
        words.split(|b| *b == 0).nth(1) == Some(b"guardian") && parent == Some(&*run.to_string())
    })
}
