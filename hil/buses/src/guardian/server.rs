//! The guardian process itself.

use std::fs;
use std::io::{self, Write};
use std::os::fd::{AsFd, AsRawFd};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::signal::{Signal, kill};
use nix::sys::socket::{MsgFlags, recv, send};
use nix::unistd::{Pid, getppid, setsid};
use palpate_core::units::Duration;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use super::{Latch, PACKET, Sweeper, Watch, packet, word};
use crate::lock::BusLock;
use crate::oe::OeLine;
use crate::pacer::RunClock;
use crate::sys;

/// How long boards may take to answer for the first time.
const START: std::time::Duration = std::time::Duration::from_secs(5);
/// A run whose end of the pair closed has this long to end by itself.
const GRACE: Duration = Duration::from_millis(500);
/// How long a guardian goes on trying to reach boards that do not answer.
const PATIENCE: Duration = Duration::from_millis(600_000);
/// How often an awake guardian looks whether the run is silent.
const SLICE_MS: u64 = 10;
/// Pauses between those tries: the first and the longest.
const PAUSE: (u64, u64) = (5, 50);
/// What a thread that writes a few small files needs: the guardian's memory is locked.
const STACK: usize = 128 * 1024;

/// Why the guardian acts.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Cause {
    /// The run's end closed without a good-bye.
    Died,
    /// No heartbeat for this long.
    Hung(Duration),
    /// The run asked for it, and says why.
    Asked(String),
    /// A signal ended the guardian.
    Terminated,
}

impl Cause {
    fn asked(cause: &[u8]) -> Self {
        Self::Asked(String::from_utf8_lossy(cause).into_owned())
    }

    fn words(&self) -> String {
        match self {
            Self::Died => "the run died without a word".into(),
            Self::Hung(silence) => {
                format!(
                    "the run hung: no heartbeat for {} ms",
                    silence.as_micros() / 1000
                )
            }
            Self::Asked(cause) => cause.clone(),
            Self::Terminated => "switched off by `hil off` or a SIGTERM to the guardian".into(),
        }
    }
}

/// Everything a guardian holds.
struct Post<'a> {
    watch: &'a Watch,
    clock: RunClock,
    sweeper: Sweeper,
    oe: Option<OeLine>,
    parent: Pid,
    terminated: Arc<AtomicBool>,
    /// Writes a latch while the guardian listens on.
    latching: Option<JoinHandle<()>>,
    _locks: Vec<BusLock>,
}

/// Guards until the run says good-bye or everything is off after its death; the socket to the run is
/// standard input. Returns the exit status: 0 after a good-bye, 3 when it cannot guard, 4 after acting.
pub fn serve(watch: &Watch) -> u8 {
    // A session of its own: no terminal's Ctrl-C or hang-up is meant for the guardian.
    let _ = setsid();
    let parent = getppid();
    let (post, found) = match Post::take(watch, parent) {
        Ok(taken) => taken,
        Err(reason) => {
            say(word::REFUSED, &reason);
            return 3;
        }
    };
    say(word::READY, &found);
    post.stand()
}

/// A packet to the run; one that is gone needs none.
fn say(word: u8, text: &str) {
    let stdin = io::stdin();
    let flags = MsgFlags::MSG_DONTWAIT | MsgFlags::MSG_NOSIGNAL;
    let _ = send(stdin.as_raw_fd(), &packet(word, text), flags);
}

/// A line for people, if anybody reads them.
fn tell(text: &str) {
    let _ = writeln!(io::stderr(), "guardian: {text}");
}

/// What the system gives to one who must not fail, as far as it does: memory that is never paged out, the
/// last place in the queue of the out-of-memory killer, a place before ordinary programs.
fn harden() {
    let _ = sys::lock_memory();
    let _ = fs::write("/proc/self/oom_score_adj", "-1000");
    let _ = sys::set_fifo_priority(60);
}

impl<'a> Post<'a> {
    /// Locks the buses, cuts the OE line, looks at every board, switches everything off and reads back.
    fn take(watch: &'a Watch, parent: Pid) -> Result<(Self, String), String> {
        let terminated = Arc::new(AtomicBool::new(false));
        let ignored = Arc::new(AtomicBool::new(false));
        for (signal, flag) in [
            (SIGTERM, &terminated),
            (SIGINT, &ignored),
            (SIGHUP, &ignored),
        ] {
            let caught = signal_hook::flag::register(signal, Arc::clone(flag));
            caught.map_err(|e| format!("signal {signal}: {e}"))?;
        }
        let paths = watch.buses.iter().map(|bus| &bus.path);
        let locks: Result<Vec<_>, _> = paths.map(|path| BusLock::take(path)).collect();
        let locks = locks.map_err(|e| e.to_string())?;
        let oe = watch
            .oe
            .as_ref()
            .map(|(chip, line)| OeLine::cut(chip, *line));
        let oe = oe.transpose()?;
        let mut sweeper = Sweeper::open(&watch.buses, watch.transfer).map_err(|e| e.to_string())?;
        let found = sweeper.look();
        sweeper.off_within(START)?;
        harden();
        let driving = found.iter().filter(|b| b.was_driving());
        let lines: Vec<String> = driving.map(ToString::to_string).collect();
        let post = Self {
            watch,
            clock: RunClock::start(),
            sweeper,
            oe,
            parent,
            terminated,
            latching: None,
            _locks: locks,
        };
        Ok((post, lines.join("\n")))
    }

    /// Listens to the run.
    fn stand(mut self) -> u8 {
        let heartbeat = self.watch.heartbeat.as_micros() as u64;
        // Since the last heartbeat; none before the first. Time in which the guardian did not get to run
        // itself counts little: the run did not either, and gets its turn before it is judged.
        let mut silence: Option<u64> = None;
        let mut looked = self.clock.now();
        loop {
            if let Some(silence) = silence.filter(|s| *s > heartbeat) {
                return self.act(&Cause::Hung(Duration::from_micros(silence)));
            }
            if self.terminated.load(Ordering::Relaxed) {
                return self.act(&Cause::Terminated);
            }
            let received = receive(silence.map(|_| SLICE_MS));
            let now = self.clock.now();
            let passed = now.since(looked).as_micros().min(2_000 * SLICE_MS);
            looked = now;
            let packet = match received {
                Ok(Some(packet)) => packet,
                Ok(None) => {
                    silence = silence.map(|s| s + passed);
                    continue;
                }
                Err(()) => return self.act(&Cause::Died),
            };
            silence = silence.map(|_| 0);
            match packet.split_first() {
                Some((&word::BEAT, _)) => {
                    silence = Some(0);
                    say(word::BEAT, "");
                }
                Some((&word::RELEASE, _)) => self.set_oe(false),
                Some((&word::CUT, _)) => self.set_oe(true),
                Some((&word::STOP, cause)) => {
                    let cause = Cause::asked(cause);
                    self.set_oe(true);
                    if self.sweeper.off().is_err() {
                        return self.act(&cause);
                    }
                    self.latch(&cause, true);
                }
                Some((&word::LATCH, cause)) => self.latch_beside(&Cause::asked(cause)),
                Some((&word::BYE, _)) => {
                    self.set_oe(true);
                    self.wait_for_latch();
                    return match self.sweeper.off() {
                        Ok(()) => {
                            say(word::READY, "");
                            0
                        }
                        Err(reason) => {
                            say(word::REFUSED, &reason);
                            self.act(&Cause::Asked(format!("at the end of the run: {reason}")))
                        }
                    };
                }
                Some((&word::TRIP, cause)) => {
                    return self.act(&Cause::asked(cause));
                }
                _ => return self.act(&Cause::Asked("the run sent what is no word".into())),
            }
        }
    }

    fn set_oe(&mut self, cut: bool) {
        if let Some(Err(reason)) = self.oe.as_mut().map(|line| line.set(cut)) {
            tell(&reason);
        }
    }

    /// Everything off, whatever it takes.
    fn act(mut self, cause: &Cause) -> u8 {
        let began = self.clock.now();
        self.set_oe(true);
        let mut result = self.sweeper.off();
        let took = self.clock.now().since(began);
        self.end_run(cause);
        // What the run had on its way may have arrived after the first sweep.
        result = self.sweeper.off().and(result);
        self.latch(cause, result.is_ok());
        let words = cause.words();
        let ms = took.as_micros() as f64 * 1e-3;
        match &result {
            Ok(()) => tell(&format!(
                "{words}; everything is off, {ms:.1} ms after that was known"
            )),
            Err(reason) => tell(&format!(
                "{words}; not everything is known to be off: {reason}; trying on"
            )),
        }
        let mut pause = PAUSE.0;
        while let Err(reason) = result {
            if self.clock.now().since(began) > PATIENCE {
                tell(&format!("giving up: {reason}"));
                return 4;
            }
            if *cause != Cause::Terminated && self.terminated.load(Ordering::Relaxed) {
                return 4; // another program takes over
            }
            self.rest(pause);
            pause = (pause * 2).min(PAUSE.1);
            result = self.sweeper.off();
            if result.is_ok() {
                tell("everything is off now");
                self.latch(cause, true);
            }
        }
        say(word::READY, "");
        4
    }

    /// Waits until the run is gone; one that hung, or does not go, is killed. One that asked for help lives.
    fn end_run(&self, cause: &Cause) {
        if matches!(cause, Cause::Asked(_)) {
            return;
        }
        let began = self.clock.now();
        let mut kill_at = match cause {
            Cause::Hung(_) | Cause::Terminated => began,
            _ => began + GRACE,
        };
        // Once the run is gone the guardian is another process's child; its number may be anybody's then.
        while getppid() == self.parent && self.parent.as_raw() > 1 {
            let now = self.clock.now();
            if now >= kill_at {
                let _ = kill(self.parent, Signal::SIGKILL);
                kill_at = now + GRACE;
            }
            if now > began + GRACE + GRACE {
                tell("the run cannot be killed; it hangs in a driver");
                return;
            }
            self.rest(1);
        }
    }

    fn latch(&mut self, cause: &Cause, verified: bool) {
        self.wait_for_latch();
        latch(&self.buses(), &cause.words(), verified);
    }

    /// Latches what is not known to be off whole. A disk may be slow, and outputs are on: heartbeats are heard meanwhile.
    fn latch_beside(&mut self, cause: &Cause) {
        self.wait_for_latch();
        let (buses, words) = (self.buses(), cause.words());
        let write = {
            let (buses, words) = (buses.clone(), words.clone());
            move || latch(&buses, &words, false)
        };
        match thread::Builder::new().stack_size(STACK).spawn(write) {
            Ok(thread) => self.latching = Some(thread),
            Err(_) => latch(&buses, &words, false),
        }
    }

    fn wait_for_latch(&mut self) {
        if let Some(thread) = self.latching.take() {
            // What it could not write it has told.
            let _ = thread.join();
        }
    }

    fn buses(&self) -> Vec<PathBuf> {
        let buses = self.watch.buses.iter();
        buses.map(|bus| bus.path.clone()).collect()
    }

    fn rest(&self, ms: u64) {
        self.clock
            .sleep_until(self.clock.now() + Duration::from_millis(ms));
    }
}

/// Latches a stop for these adapters.
fn latch(buses: &[PathBuf], words: &str, verified: bool) {
    for path in buses {
        if let Err(error) = Latch::of(path).set(words, verified) {
            tell(&format!("the stop could not be latched: {error}"));
        }
    }
}

/// The next packet; `None` when `left` milliseconds passed or a signal came, an error when the run is gone.
fn receive(left: Option<u64>) -> Result<Option<Vec<u8>>, ()> {
    let stdin = io::stdin();
    let timeout = left.map_or(PollTimeout::NONE, |ms| {
        PollTimeout::try_from(ms).unwrap_or(PollTimeout::MAX)
    });
    let mut waiting = [PollFd::new(stdin.as_fd(), PollFlags::POLLIN)];
    match poll(&mut waiting, timeout) {
        Ok(0) | Err(_) => return Ok(None),
        Ok(_) => {}
    }
    let mut packet = vec![0; PACKET];
    match recv(stdin.as_raw_fd(), &mut packet, MsgFlags::MSG_DONTWAIT) {
        Ok(0) => Err(()),
        Ok(length) => {
            packet.truncate(length);
            Ok(Some(packet))
        }
        Err(Errno::EAGAIN | Errno::EINTR) => Ok(None),
        Err(_) => Err(()),
    }
}
