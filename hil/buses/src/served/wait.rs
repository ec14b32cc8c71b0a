//! Waiting for whichever comes first: a moment, a request, or the signal to stop.

use std::io;
use std::os::fd::{AsFd, BorrowedFd};

use nix::errno::Errno;
use nix::poll::{PollFd, PollFlags, ppoll};
use nix::sys::signal::{SigSet, Signal};
use nix::sys::signalfd::{SfdFlags, SignalFd};
use nix::sys::time::TimeSpec;
use nix::time::{ClockId, clock_gettime};

/// The monotonic clock, nanoseconds: the same for every program of this machine.
pub fn monotonic_ns() -> u64 {
    let read = clock_gettime(ClockId::CLOCK_MONOTONIC);
    read.map_or(0, |t| {
        t.tv_sec() as u64 * 1_000_000_000 + t.tv_nsec() as u64
    })
}

/// SIGINT, SIGTERM and SIGHUP as something to wait for in place of a sudden end.
#[derive(Debug)]
pub struct Signals(SignalFd);

impl Signals {
    /// Catches the three from now on.
    ///
    /// # Errors
    /// Error of the system.
    pub fn catch() -> io::Result<Self> {
        let mut set = SigSet::empty();
        for signal in [Signal::SIGINT, Signal::SIGTERM, Signal::SIGHUP] {
            set.add(signal);
        }
        set.thread_block()?;
        let flags = SfdFlags::SFD_NONBLOCK | SfdFlags::SFD_CLOEXEC;
        Ok(Self(SignalFd::with_flags(&set, flags)?))
    }

    /// Tells whether a signal has come since the last call.
    pub fn raised(&mut self) -> bool {
        matches!(self.0.read_signal(), Ok(Some(_)))
    }
}

impl AsFd for Signals {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// Waits until one of `fds` can be read, or until the monotonic clock shows `until_ns`. Returns which of
/// them can be read, or have an error to tell.
///
/// # Errors
/// Error of the system.
pub fn wait(fds: &[BorrowedFd<'_>], until_ns: u64) -> io::Result<Vec<bool>> {
    let left = until_ns.saturating_sub(monotonic_ns());
    let left = TimeSpec::new((left / 1_000_000_000) as i64, (left % 1_000_000_000) as i64);
    let mut polled: Vec<PollFd<'_>> = fds
        .iter()
        .map(|fd| PollFd::new(*fd, PollFlags::POLLIN))
        .collect();
    match ppoll(&mut polled, Some(left), None) {
        Ok(_) => Ok(polled.iter().map(|p| p.any().unwrap_or(true)).collect()),
        Err(Errno::EINTR) => Ok(vec![true; fds.len()]),
        Err(error) => Err(error.into()),
    }
}
