//! The guardian process itself, which carries out its [decisions](super::decide).
//!
//! All that it needs is there before it reports that it is ready: threads, descriptors, records, and every page it will
//! touch.

use std::fmt::Write as _;
use std::fs;
use std::io;
use std::os::fd::{AsRawFd, BorrowedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration as Elapsed;

use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::signal::{Signal, kill};
use nix::sys::socket::{MsgFlags, SockType, getsockopt, recv, send, sockopt};
use nix::unistd::{Pid, getppid, setsid};
use palpate_core::units::{Duration, Instant};
use signal_hook::consts::SIGTERM;

use super::decide::{Answer, BUSES, Cause, Decider, Event, News, Now, Post, Text};
use super::hand::Hand;
use super::outputs::Why;
use super::scribe::{Latcher, Teller};
use super::{Armed, Latch, PACKET, Sweeper, Watch, WatchedBus, word};
use crate::hardware::Hardware;
use crate::lock::BusLock;
use crate::oe::OeLine;
use crate::pacer::{RunClock, asleep_ns};
use crate::sys;

/// Longest time that boards take to answer for the first time.
const START: Elapsed = Elapsed::from_secs(5);
/// The cause of a stop for which neither run nor guardian wrote another.
const ABANDONED: &str = "run and guardian ended without a word";
/// Longest time that words take to reach people at the end.
const WORDS: Elapsed = Elapsed::from_millis(200);

/// Guards until the run says good-bye or everything is off after its death; the socket to the run is
/// standard input. Returns the exit status: 0 after a good-bye, 3 when it cannot guard, 4 after acting.
pub fn serve(watch: &Watch) -> u8 {
    let stdin = io::stdin();
    let parent = getppid();
    // Whoever made the socket is the run: a guardian kills no other process, such as the shell in which it is typed.
    let is_run = getsockopt(&stdin, sockopt::SockType) == Ok(SockType::SeqPacket)
        && getsockopt(&stdin, sockopt::PeerCredentials)
            .is_ok_and(|run| run.pid() == parent.as_raw());
    if !is_run {
        if let Ok(teller) = Teller::start() {
            teller.tell(format_args!("not for people: expected the socket of a run as standard input; `hil run` starts its own guardian"));
            teller.finish(WORDS);
        }
        return 3;
    }
    // A session of its own: no terminal's Ctrl-C or hang-up is meant for the guardian.
    let _ = setsid();
    match Station::take(watch, parent) {
        Ok((mut station, found)) => {
            say(word::READY, &found);
            station.stand(watch)
        }
        Err((word, reason)) => {
            say(word, &reason);
            3
        }
    }
}

/// Sends a packet to the run; one that is gone needs none.
fn say(word: u8, text: &str) {
    let mut packet = [0; PACKET];
    packet[0] = word;
    let length = text.len().min(PACKET - 1);
    let (to, from) = (packet.get_mut(1..=length), text.as_bytes().get(..length));
    if let (Some(to), Some(from)) = (to, from) {
        to.copy_from_slice(from);
    }
    let flags = MsgFlags::MSG_DONTWAIT | MsgFlags::MSG_NOSIGNAL;
    let _ = send(io::stdin().as_raw_fd(), &packet[..=length], flags);
}

/// Takes all that the system gives to a process that must not fail: memory that is never paged out, the last place in
/// the queue of the out-of-memory killer, a place before ordinary programs.
fn harden() {
    if sys::lock_memory().is_err() {
        // Memory that stays locked would only keep later pages from coming. Stacks were touched; the rest was used
        // once.
        sys::unlock_memory();
    }
    let _ = fs::write("/proc/self/oom_score_adj", "-1000");
    let _ = sys::set_fifo_priority(60);
}

/// The locks of all adapters.
fn locks(watch: &Watch) -> Result<Vec<BusLock>, String> {
    let lock = |bus: &WatchedBus| {
        let hardware = Hardware::adapter(&bus.path).map_err(|e| e.to_string())?;
        BusLock::take(&hardware).map_err(|e| e.to_string())
    };
    watch.buses.iter().map(lock).collect()
}

/// Arms the records of all adapters, or none of them.
fn arm(locks: &[BusLock]) -> Result<Vec<Armed>, String> {
    let mut armed = Vec::new();
    for lock in locks {
        match Latch::new(lock.hardware()).arm(lock, ABANDONED) {
            Ok(record) => armed.push(record),
            Err(reason) => {
                armed.iter().for_each(Armed::disarm);
                return Err(reason);
            }
        }
    }
    Ok(armed)
}

/// State of the guardian process.
struct Station {
    clock: RunClock,
    asleep_ns: i64,
    hands: Vec<Hand>,
    /// Reason for which each bus is not known to be off, by its last answer.
    whys: [Option<Why>; BUSES],
    oe: Option<OeLine>,
    parent: Pid,
    terminated: Arc<AtomicBool>,
    locks: Vec<BusLock>,
    latcher: Latcher,
    teller: Teller,
    /// `true` once another program's wish for everything off was heard.
    is_asked: bool,
    /// `true` while the run's process is there, as far as is known.
    is_there: bool,
    /// `true` while the run's end of the pair is open.
    is_open: bool,
}

impl Station {
    /// Locks the buses, arms their latches, cuts the OE line, switches everything off and reads back.
    fn take(watch: &Watch, parent: Pid) -> Result<(Self, String), (u8, String)> {
        let refused = |reason: String| (word::REFUSED, reason);
        sys::ignore_signals();
        let terminated = Arc::new(AtomicBool::new(false));
        signal_hook::flag::register(SIGTERM, Arc::clone(&terminated))
            .map_err(|e| refused(format!("SIGTERM: {e}")))?;
        let locks = locks(watch).map_err(refused)?;
        // Under the locks: no other guardian is there that could latch.
        for lock in &locks {
            if let Some(held) = Latch::new(lock.hardware()).read_locked(lock) {
                return Err((word::LATCHED, held.refusal(lock.hardware())));
            }
        }
        let oe = watch
            .oe
            .as_ref()
            .map(|(chip, line)| OeLine::cut(chip, *line));
        let oe = oe.transpose().map_err(refused)?;
        let opened = Sweeper::open(&watch.buses);
        let mut sweeper = opened.map_err(|e| refused(e.to_string()))?;
        let (found, wrong) = sweeper.off(START);
        if let Some(reason) = wrong.into_iter().next() {
            return Err(refused(reason));
        }
        let thread = |e: io::Error| refused(format!("no thread for the guardian: {e}"));
        let teller = Teller::start().map_err(thread)?;
        let latcher = Latcher::start(teller.clone()).map_err(thread)?;
        // Last: whatever fails before leaves no record that the next run would take for a stop.
        latcher.hold(arm(&locks).map_err(refused)?);
        harden();
        let driving = found.iter().filter(|b| b.was_driving());
        let lines: Vec<String> = driving.map(ToString::to_string).collect();
        let station = Self {
            clock: RunClock::start(),
            asleep_ns: asleep_ns(),
            hands: sweeper.into_hands(),
            whys: [None; BUSES],
            oe,
            parent,
            terminated,
            locks,
            latcher,
            teller,
            is_asked: false,
            is_there: true,
            is_open: true,
        };
        Ok((station, lines.join("\n")))
    }

    /// Carries decisions out until nothing is left to do.
    fn stand(&mut self, watch: &Watch) -> u8 {
        let heartbeat = Duration::from_micros(watch.heartbeat.as_micros() as u64);
        let mut decider = Decider::new(self.hands.len(), heartbeat);
        let mut buffer = [0; PACKET];
        loop {
            if let Some(status) = decider.end() {
                self.latcher.finish();
                self.teller.finish(WORDS);
                return status;
            }
            self.wait(decider.next());
            // Time first: unseen time is judged before any event of it.
            decider.step(self.now(), Event::Time, self);
            if self.is_asked_off() {
                decider.step(self.now(), Event::Ended, self);
            }
            for bus in 0..self.hands.len() {
                let report = self.hands.get(bus).and_then(Hand::report);
                if let Some(report) = report {
                    let off = report.off.is_ok();
                    if let Some(why) = self.whys.get_mut(bus) {
                        *why = report.off.err();
                    }
                    decider.step(self.now(), Event::Swept { bus, off }, self);
                }
            }
            while self.is_open {
                match receive(&mut buffer) {
                    Ok(Some(packet)) => decider.step(self.now(), event(packet), self),
                    Ok(None) => break,
                    Err(()) => {
                        self.is_open = false;
                        decider.step(self.now(), Event::Closed, self);
                    }
                }
            }
            // Once the run is gone the guardian is another process's child. The first process of all is never gone before.
            let gone = getppid() != self.parent || self.parent.as_raw() <= 1 && !self.is_open;
            if self.is_there && gone {
                self.is_there = false;
                decider.step(self.now(), Event::Gone, self);
            }
        }
    }

    fn now(&self) -> Now {
        let asleep = asleep_ns().saturating_sub(self.asleep_ns);
        Now {
            at: self.clock.now(),
            asleep: Duration::from_micros(u64::try_from(asleep).unwrap_or(0) / 1000),
        }
    }

    /// Tells whether a signal has come, or another program has asked for everything off, since the last time.
    fn is_asked_off(&mut self) -> bool {
        let signal = self.terminated.swap(false, Ordering::Relaxed);
        let asked = self.locks.iter().any(BusLock::is_asked_off);
        signal || asked && !std::mem::replace(&mut self.is_asked, true)
    }

    /// Waits until `until`, a packet or a signal.
    fn wait(&self, until: Instant) {
        let left = until.since(self.clock.now()).as_micros().div_ceil(1000);
        let timeout = PollTimeout::try_from(left).unwrap_or(PollTimeout::MAX);
        if self.is_open {
            let stdin = io::stdin();
            let _ = poll(
                &mut [PollFd::new(stdin_of(&stdin), PollFlags::POLLIN)],
                timeout,
            );
        } else {
            let _ = poll(&mut [], timeout);
        }
    }
}

fn stdin_of(stdin: &io::Stdin) -> BorrowedFd<'_> {
    std::os::fd::AsFd::as_fd(stdin)
}

/// The next packet; none when nothing has come, an error when the run's end has closed.
fn receive(buffer: &mut [u8; PACKET]) -> Result<Option<&[u8]>, ()> {
    match recv(io::stdin().as_raw_fd(), buffer, MsgFlags::MSG_DONTWAIT) {
        Ok(0) => Err(()),
        Ok(length) => Ok(buffer.get(..length)),
        Err(Errno::EAGAIN | Errno::EINTR) => Ok(None),
        Err(_) => Err(()),
    }
}

/// Event that a packet tells.
fn event(packet: &[u8]) -> Event<'_> {
    let Some((first, rest)) = packet.split_first() else {
        return Event::Noise;
    };
    // A cause that is cut in the midst of a letter loses that one.
    let text = match std::str::from_utf8(rest) {
        Ok(text) => text,
        Err(error) => {
            let good = rest.get(..error.valid_up_to()).unwrap_or_default();
            std::str::from_utf8(good).unwrap_or_default()
        }
    };
    match *first {
        word::BEAT => Event::Beat,
        word::RELEASE => Event::Release,
        word::CUT => Event::Cut,
        word::STOP => Event::Stop(text),
        word::LATCH => Event::Latch(text),
        word::BYE => Event::Bye,
        word::TRIP => Event::Trip(text),
        _ => Event::Noise,
    }
}

/// A cause as text; one that is too long is cut.
fn text(cause: &Cause) -> Text {
    let mut text = Text::new();
    let _ = write!(text, "{cause}");
    text
}

impl Post for Station {
    fn cut(&mut self, cut: bool) -> bool {
        self.oe.as_mut().is_none_or(|line| line.set(cut).is_ok())
    }

    fn off(&mut self, bus: usize) {
        if let Some(hand) = self.hands.get(bus) {
            hand.off();
        }
    }

    fn kill(&mut self) {
        // After the run its number may be anybody's.
        if self.parent.as_raw() > 1 && getppid() == self.parent {
            let _ = kill(self.parent, Signal::SIGKILL);
        }
    }

    fn latch(&mut self, cause: &Cause, verified: bool) {
        self.latcher.latch(text(cause), verified);
    }

    fn tell(&mut self, cause: &Cause, news: News) {
        match news {
            News::Off(took) => self.teller.tell(format_args!(
                "{cause}; everything is off, {:.1} ms after that was known",
                took.as_micros() as f64 * 1e-3
            )),
            News::Trying => {
                let why = self.hands.iter().zip(&self.whys);
                let why = why.filter_map(|(hand, why)| Some((hand, (*why)?))).next();
                match why {
                    Some((hand, why)) => self.teller.tell(format_args!(
                        "{cause}; not everything is known to be off: {}, {why}; trying on",
                        hand.bus().path.display()
                    )),
                    None => self.teller.tell(format_args!(
                        "{cause}; not everything is known to be off; trying on"
                    )),
                }
            }
            News::Stays => self.teller.tell(format_args!(
                "the run cannot be killed; it hangs in a driver"
            )),
        }
    }

    fn answer(&mut self, answer: Answer, cause: Option<&Cause>) {
        let mut words = Text::new();
        if let Some(cause) = cause {
            let _ = write!(words, "{cause}");
        }
        match answer {
            Answer::Beat => say(word::BEAT, ""),
            Answer::Off => say(word::READY, ""),
            Answer::Halt => say(word::HALT, &words),
            Answer::NotOff => {
                let hands = self.hands.iter().zip(&self.whys);
                for (hand, why) in hands {
                    if let Some(why) = why {
                        let _ = write!(words, "{}, {why}", hand.bus().path.display());
                        break;
                    }
                }
                say(word::REFUSED, &words);
            }
        }
    }
}
