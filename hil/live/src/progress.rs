//! Name, progress and end of long work: one line on standard error, where that is a terminal, once the work takes
//! longer than two seconds.
//!
//! Work that counts stores a number. A thread of its own shows the number: no work waits for a terminal.

use std::fs;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::lock::held;

/// Time within which work ends without a line.
const LATE: Duration = Duration::from_secs(2);
/// Time between two looks at the progress.
const EVERY: Duration = Duration::from_millis(125);
/// Steps of work that counts in parts of one.
const STEPS: u64 = 100_000;

/// `true` where progress may be shown at all.
static ALLOWED: AtomicBool = AtomicBool::new(false);
/// `true` while something writes to the terminal at length.
static ASIDE: AtomicBool = AtomicBool::new(false);
/// The line that is shown, or will be; work within other work has none of its own.
static SHOWN: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Allows progress to be shown, where standard error is a terminal that can redraw a line and no CI keeps a log of it.
pub fn allow() {
    let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let dumb = std::env::var_os("TERM").is_none_or(|term| term == "dumb");
    let allowed = std::io::stderr().is_terminal() && !set("CI") && !dumb;
    ALLOWED.store(allowed, Ordering::Relaxed);
}

/// Writes to the terminal while the line is out of the way.
pub fn aside<T>(write: impl FnOnce() -> T) -> T {
    let bar = held(&SHOWN).clone();
    ASIDE.store(true, Ordering::Relaxed);
    let written = match bar {
        Some(bar) => bar.suspend(write),
        None => write(),
    };
    ASIDE.store(false, Ordering::Relaxed);
    written
}

/// Source of the work's progress.
#[derive(Debug)]
enum Course {
    /// Steps that the work counts itself.
    Counted,
    /// Bytes of this file that the system has read for the work. Readers lie in rooms that know neither clock nor
    /// terminal.
    Reading(PathBuf),
}

/// Work under way. Dropped, its line is gone.
#[derive(Debug)]
pub struct Progress {
    at: Arc<AtomicU64>,
    /// Sender whose drop ends the line, and the thread that shows it.
    shown: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Progress {
    /// Progress of work in so many steps; `noun` names them: `runs`.
    pub fn counted(what: &str, total: u64, noun: &str) -> Self {
        let style = format!("{{msg}} [{{bar:30}}] {{pos}} of {{len}} {noun}, {{eta}} left");
        Self::new(what, Some(total), &style, Course::Counted)
    }

    /// Progress of work whose done part is known.
    pub fn of_part(what: &str) -> Self {
        let style = "{msg} [{bar:30}] {percent} %, {eta} left";
        Self::new(what, Some(STEPS), style, Course::Counted)
    }

    /// Progress of reading a file from begin to end. The end of a pipe is not known.
    pub fn reading(path: &Path) -> Self {
        let what = format!("reading {}", path.display());
        match fs::canonicalize(path).and_then(|path| Ok((fs::metadata(&path)?, path))) {
            Ok((there, path)) if there.is_file() => {
                let style = "{msg} [{bar:30}] {bytes} of {total_bytes}, {eta} left";
                Self::new(&what, Some(there.len()), style, Course::Reading(path))
            }
            _ => Self::endless(&what),
        }
    }

    /// Progress of work of unknown length.
    pub fn endless(what: &str) -> Self {
        Self::new(
            what,
            None,
            "{spinner} {msg}, for {elapsed}",
            Course::Counted,
        )
    }

    fn new(what: &str, total: Option<u64>, style: &str, course: Course) -> Self {
        let at = Arc::new(AtomicU64::new(0));
        let none = Self {
            at: Arc::clone(&at),
            shown: None,
        };
        let mut other = held(&SHOWN);
        let hidden = ASIDE.load(Ordering::Relaxed) && std::io::stdout().is_terminal();
        if !ALLOWED.load(Ordering::Relaxed) || hidden || other.is_some() {
            return none;
        }
        let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(what.to_owned());
        let (ends, ended) = channel();
        let show = {
            let bar = bar.clone();
            move || show(&bar, &course, &at, &ended)
        };
        let Ok(thread) = std::thread::Builder::new()
            .name("progress".into())
            .spawn(show)
        else {
            return none;
        };
        *other = Some(bar);
        Self {
            at: Arc::clone(&none.at),
            shown: Some((ends, thread)),
        }
    }

    /// Sets the step that the work has reached.
    pub fn to(&self, step: u64) {
        self.at.store(step, Ordering::Relaxed);
    }

    /// Counts one more step.
    pub fn step(&self) {
        self.at.fetch_add(1, Ordering::Relaxed);
    }

    /// Sets the part of the work that is done, 0 to 1.
    pub fn part(&self, part: f64) {
        self.to((part * STEPS as f64) as u64);
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some((ends, thread)) = self.shown.take() {
            drop(ends);
            // The thread has cleared its line, so the next text stands where it was.
            let _ = thread.join();
            *held(&SHOWN) = None;
        }
    }
}

/// Draws the line until the work ends, if that takes long enough.
fn show(bar: &ProgressBar, course: &Course, at: &AtomicU64, ended: &Receiver<()>) {
    if ended.recv_timeout(LATE) != Err(RecvTimeoutError::Timeout) {
        return;
    }
    bar.set_draw_target(ProgressDrawTarget::stderr());
    while ended.recv_timeout(EVERY) == Err(RecvTimeoutError::Timeout) {
        let now = match course {
            Course::Counted => at.load(Ordering::Relaxed),
            Course::Reading(path) => position(path).unwrap_or_else(|| bar.position()),
        };
        bar.set_position(now);
        bar.tick();
    }
    bar.finish_and_clear();
}

/// Bytes that this process has read of a file that it has open; `None` where it has not.
fn position(path: &Path) -> Option<u64> {
    let open = fs::read_dir("/proc/self/fd").ok()?.flatten();
    let of = |fd: fs::DirEntry| {
        let same = fs::read_link(fd.path()).is_ok_and(|link| link == path);
        let info = Path::new("/proc/self/fdinfo").join(fd.file_name());
        let info = same.then(|| fs::read_to_string(info).ok())??;
        info.lines()
            .next()?
            .strip_prefix("pos:")?
            .trim()
            .parse()
            .ok()
    };
    open.filter_map(of).max()
}

#[cfg(test)]
#[path = "progress_tests.rs"]
mod tests;
