//! The heartbeat of a loop that waits: what a slow transfer says to the guardian meanwhile.

use std::os::fd::{AsRawFd, OwnedFd};
use std::sync::Arc;

use nix::sys::socket::{MsgFlags, send};

/// Says that the loop is alive while it waits for something that has a limit of its own.
#[derive(Clone, Debug)]
pub struct Pulse {
    link: Arc<OwnedFd>,
    beat: u8,
}

impl Pulse {
    /// A heartbeat of one byte on this socket.
    pub const fn new(link: Arc<OwnedFd>, beat: u8) -> Self {
        Self { link, beat }
    }

    /// One heartbeat.
    pub fn beat(&self) {
        let flags = MsgFlags::MSG_DONTWAIT | MsgFlags::MSG_NOSIGNAL;
        // A guardian that is gone is noticed by its own client.
        let _ = send(self.link.as_raw_fd(), &[self.beat], flags);
    }
}
