//! A CAN interface on which emulated boards speak: their frames go out, everybody else's come in.

use std::io::{self, ErrorKind};
use std::os::fd::{AsFd, BorrowedFd};

use embedded_can::{Frame as _, Id, StandardId};
use nix::libc;
use palpate_core::codec::can::CanFrame;
use socketcan::{CanDataFrame, CanFrame as AnyFrame, CanSocket, Socket};

/// Counts of an interface's frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Frames sent.
    pub sent: u64,
    /// Frames that the interface did not take: queue full, interface down.
    pub lost: u64,
    /// Data frames with an 11-bit identifier received.
    pub received: u64,
    /// Frames of other kinds: extended, remote, error.
    pub foreign: u64,
}

/// An open interface.
#[derive(Debug)]
pub struct Interface {
    name: String,
    socket: CanSocket,
    counts: Counts,
}

impl Interface {
    /// Opens an interface that exists and is up.
    ///
    /// # Errors
    /// Error of the system: ENODEV if there is none of that name.
    pub fn open(name: &str) -> io::Result<Self> {
        let socket = CanSocket::open(name)?;
        socket.set_nonblocking(true)?;
        Ok(Self {
            name: name.into(),
            socket,
            counts: Counts::default(),
        })
    }

    /// Name of the interface.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Counts of the interface's frames.
    pub const fn counts(&self) -> Counts {
        self.counts
    }

    /// The next frame of another sender that a board could read; `None` when there is none now, and while
    /// the interface is down.
    ///
    /// # Errors
    /// Error of the system when the interface has gone.
    pub fn receive(&mut self) -> io::Result<Option<CanFrame>> {
        loop {
            let frame = match self.socket.read_frame() {
                Ok(AnyFrame::Data(frame)) => frame,
                Ok(_) => {
                    self.counts.foreign += 1;
                    continue;
                }
                Err(e) if e.kind() == ErrorKind::Interrupted => continue,
                Err(e) if is_pause(&e) => return Ok(None),
                Err(e) => return Err(e),
            };
            let heard = match frame.id() {
                Id::Standard(id) => CanFrame::new(id.as_raw(), frame.data()),
                Id::Extended(_) => None,
            };
            match heard {
                Some(heard) => {
                    self.counts.received += 1;
                    return Ok(Some(heard));
                }
                None => self.counts.foreign += 1,
            }
        }
    }

    /// Sends a frame; one that the interface does not take now is lost, as on a real bus, and counted.
    ///
    /// # Errors
    /// Error of the system when the interface has gone.
    pub fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        let id = StandardId::new(frame.id());
        let Some(frame) = id.and_then(|id| CanDataFrame::new(id, frame.data())) else {
            return Ok(()); // a `CanFrame` has 11 bits and at most 8 bytes
        };
        match self.socket.write_frame(&frame) {
            Ok(()) => self.counts.sent += 1,
            Err(e) if is_pause(&e) => self.counts.lost += 1,
            Err(e) => return Err(e),
        }
        Ok(())
    }
}

/// Tells whether a later attempt may succeed on the same socket.
fn is_pause(error: &io::Error) -> bool {
    let number = error.raw_os_error();
    error.kind() == ErrorKind::WouldBlock || matches!(number, Some(libc::ENOBUFS | libc::ENETDOWN))
}

impl AsFd for Interface {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}
