//! The run's end: starts a guardian, keeps it awake, and takes leave.

use std::fs;
use std::io;
use std::os::fd::{AsFd, AsRawFd, OwnedFd};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;

use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::sys::socket::{AddressFamily, MsgFlags, SockFlag, SockType, recv, send, socketpair};
use palpate_core::units::{Duration, Instant};

use crate::pulse::Pulse;

use super::{PACKET, Watch, packet, word};

/// Longest time that a guardian takes to look at every board and switch it off.
const START_MS: u16 = 20_000;
/// Longest time that it takes to confirm the end.
const END_MS: u16 = 5_000;

/// Errors of a guardian's start: without it there is no run.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The process could not be started.
    #[error("the guardian cannot be started: {0}")]
    Spawn(#[from] io::Error),
    /// The guardian cannot guard, for this reason.
    #[error("{0}")]
    Refused(String),
    /// A stop of an earlier run is latched.
    #[error("{0}")]
    Latched(String),
    /// The guardian has sent nothing.
    #[error("the guardian does not answer")]
    Silent,
}

/// A guardian that can no longer be relied on: the run has to end.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Lost {
    /// The guardian's process is gone.
    #[error("the guardian process is gone; no guardian is left to switch off after this program")]
    Died,
    /// The guardian does not answer.
    #[error("the guardian does not answer; no guardian is left to switch off after this program")]
    Silent,
    /// The guardian has switched everything off by itself and latched that, for this cause.
    #[error("{0}; the guardian has switched everything off")]
    Halted(String),
}

/// Reason for which a guardian of this process may be killed together with it, by its number and `/proc/self/status`.
fn dies_along(pid: u32, status: &str) -> Option<&'static str> {
    let nested = status.lines().find_map(|line| line.strip_prefix("NSpid:"));
    let nested = nested.is_some_and(|ids| ids.split_whitespace().count() > 1);
    (pid == 1 || nested).then_some(
        "this program runs in a PID namespace whose first process takes the guardian along when it is killed: expected a first process that outlives the run (`docker run --init`, and no `unshare --pid`), or an OE line in the bench (real.oe), or a driver unit",
    )
}

/// A guardian and the socket to it. Dropped without [`Self::end`], it acts.
#[derive(Debug)]
pub struct Guardian {
    link: Arc<OwnedFd>,
    child: Child,
    /// Time between two heartbeats.
    period: Duration,
    /// Silence after which the guardian counts as gone.
    limit: Duration,
    sent: Instant,
    heard: Instant,
    /// `true` once the guardian does not answer any more.
    silent: bool,
}

impl Guardian {
    /// Starts a guardian by the program `hil`, to which its command is added, and returns when everything is off and
    /// read back, with the boards that were found driving, a line each.
    ///
    /// # Errors
    /// [`StartError`].
    pub fn start(mut program: Command, watch: &Watch) -> Result<(Self, String), StartError> {
        let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
        if watch.oe.is_none()
            && let Some(why) = dies_along(std::process::id(), &status)
        {
            return Err(StartError::Refused(why.into()));
        }
        let kind = SockType::SeqPacket;
        let flags = SockFlag::SOCK_CLOEXEC;
        let (link, theirs) = socketpair(AddressFamily::Unix, kind, None, flags)
            .map_err(|e| StartError::Spawn(e.into()))?;
        let child = program
            .args(watch.arguments())
            .stdin(Stdio::from(theirs))
            .stdout(Stdio::null())
            .spawn()?;
        // The command holds the guardian's end as well: a guardian that dies at its start is to be noticed.
        drop(program);
        let heartbeat = watch.heartbeat.as_micros() as u64;
        let mut guardian = Self {
            link: Arc::new(link),
            child,
            period: Duration::from_micros(heartbeat / 5),
            limit: Duration::from_micros(heartbeat * 10),
            sent: Instant::ZERO,
            heard: Instant::ZERO,
            silent: false,
        };
        match guardian.answer(START_MS) {
            Some((word::READY, found)) => Ok((guardian, found)),
            Some((word, reason)) => {
                let _ = guardian.child.wait();
                Err(match word {
                    word::LATCHED => StartError::Latched(reason),
                    _ => StartError::Refused(reason),
                })
            }
            None => Err(StartError::Silent),
        }
    }

    /// The process's number.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Heartbeat of the loop for use within a wait.
    pub fn pulse(&self) -> Pulse {
        Pulse::new(Arc::clone(&self.link), word::BEAT)
    }

    /// Sends a heartbeat of the loop, when one is due, and checks that the guardian is alive. Only the loop itself may
    /// call this: a thread beside it would be alive while the loop hangs.
    ///
    /// # Errors
    /// [`Lost`].
    pub fn beat(&mut self, now: Instant) -> Result<(), Lost> {
        if now < self.sent + self.period && self.sent != Instant::ZERO {
            return Ok(());
        }
        if self.sent == Instant::ZERO {
            self.heard = now;
        }
        self.sent = now.max(Instant::from_micros(1));
        self.send(&[word::BEAT])?;
        let mut packet = [0; PACKET];
        loop {
            match recv(self.link.as_raw_fd(), &mut packet, MsgFlags::MSG_DONTWAIT) {
                Ok(0) => return Err(Lost::Died),
                Ok(length) if packet[0] == word::HALT => {
                    let cause = packet.get(1..length).unwrap_or_default();
                    return Err(Lost::Halted(String::from_utf8_lossy(cause).into_owned()));
                }
                Ok(_) => self.heard = now,
                Err(Errno::EINTR) => {}
                Err(Errno::EAGAIN) => break,
                Err(_) => return Err(Lost::Died),
            }
        }
        self.silent = now.since(self.heard) > self.limit;
        match self.silent {
            true => Err(Lost::Silent),
            false => Ok(()),
        }
    }

    /// Tells whether the guardian is gone: then nobody would switch off outputs that this program leaves on.
    pub fn is_gone(&self) -> bool {
        let mut link = [PollFd::new(self.link.as_fd(), PollFlags::empty())];
        let closed = poll(&mut link, PollTimeout::ZERO).is_ok_and(|count| count > 0);
        self.silent || closed
    }

    /// Releases the OE line, once the boards are configured, or cuts it.
    ///
    /// # Errors
    /// [`Lost`].
    pub fn set_outputs(&self, released: bool) -> Result<(), Lost> {
        self.send(&[if released { word::RELEASE } else { word::CUT }])
    }

    /// The guard has stopped this run: the guardian cuts OE, switches everything off as well, and latches the
    /// cause. Run and guardian live on; nothing may be driven any more.
    ///
    /// # Errors
    /// [`Lost`].
    pub fn stop(&self, cause: &str) -> Result<(), Lost> {
        self.send(&packet(word::STOP, cause))
    }

    /// The guard has stopped a part of this run, which is off. The guardian latches the cause now, and switches nothing:
    /// the other outputs go on.
    ///
    /// # Errors
    /// [`Lost`].
    pub fn latch(&self, cause: &str) -> Result<(), Lost> {
        self.send(&packet(word::LATCH, cause))
    }

    /// Takes leave: the guardian switches everything off once more, reads back, and ends.
    ///
    /// # Errors
    /// Boards that it could not switch off; it goes on trying after this program's end.
    pub fn end(&mut self) -> Result<(), String> {
        self.send(&[word::BYE]).map_err(|e| e.to_string())?;
        match self.answer(END_MS) {
            Some((word::READY, _)) => {
                self.see_it_end();
                Ok(())
            }
            Some((_, reason)) => Err(reason),
            None => Err(Lost::Silent.to_string()),
        }
    }

    /// Returns when the guardian's process is gone. One that still writes to a disk that hangs goes on without this
    /// program.
    fn see_it_end(&mut self) {
        let mut link = [PollFd::new(self.link.as_fd(), PollFlags::empty())];
        let closed = poll(&mut link, PollTimeout::from(END_MS)).is_ok_and(|count| count > 0);
        if closed {
            let _ = self.child.wait();
        }
    }

    /// Hands over: this run cannot switch off itself, for this cause. The guardian latches it and goes on
    /// trying after this program's end. Returns whether everything is off already.
    pub fn hand_over(&mut self, cause: &str) -> bool {
        if self.send(&packet(word::TRIP, cause)).is_err() {
            return false;
        }
        matches!(self.answer(END_MS / 10), Some((word::READY, _)))
    }

    fn send(&self, packet: &[u8]) -> Result<(), Lost> {
        let flags = MsgFlags::MSG_DONTWAIT | MsgFlags::MSG_NOSIGNAL;
        match send(self.link.as_raw_fd(), packet, flags) {
            // A full queue is one that is not read; `beat` notices by the missing answers.
            Ok(_) | Err(Errno::EAGAIN | Errno::EINTR) => Ok(()),
            Err(_) => Err(Lost::Died),
        }
    }

    /// The next answer that is no heartbeat.
    fn answer(&mut self, timeout_ms: u16) -> Option<(u8, String)> {
        loop {
            let mut waiting = [PollFd::new(self.link.as_fd(), PollFlags::POLLIN)];
            match poll(&mut waiting, PollTimeout::from(timeout_ms)) {
                Err(Errno::EINTR) => continue,
                Ok(0) | Err(_) => return None,
                Ok(_) => {}
            }
            let mut packet = vec![0; PACKET];
            let length = recv(self.link.as_raw_fd(), &mut packet, MsgFlags::empty()).ok()?;
            match packet[..length].split_first() {
                None => return None,
                // An act of its own before is no answer.
                Some((&(word::BEAT | word::HALT), _)) => {}
                Some((&first, rest)) => {
                    return Some((first, String::from_utf8_lossy(rest).into_owned()));
                }
            }
        }
    }
}

#[cfg(test)]
#[path = "client_tests.rs"]
mod tests;
