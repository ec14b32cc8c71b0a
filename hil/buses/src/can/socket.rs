//! One CAN_RAW socket: its opening, and its packets with all that the kernel tells about them.

use std::io::{self, IoSliceMut};
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, OwnedFd, RawFd};

use nix::errno::Errno;
use nix::libc::{self, canid_t};
use nix::sys::socket::{
    ControlMessageOwned, MsgFlags, TimestampingFlag, recvmsg, send, setsockopt, sockopt,
};
use nix::sys::time::TimeSpec;
use palpate_core::codec::can::CanFrame;
use socketcan::{CanFilter, CanSocket, Socket, SocketOptions};

/// Bytes of a classic CAN frame from the kernel: identifier, length, padding, data.
const FRAME: usize = 16;
/// Bytes the kernel shall keep for us: a second of a full bus needs about 8000 frames of some 800 bytes
/// of its own bookkeeping each.
const RECEIVE_BUFFER: usize = 8 << 20;

/// A socket that has been opened for a set of boards.
#[derive(Debug)]
pub struct Endpoint {
    socket: CanSocket,
}

/// Packet from a socket, with its time stamps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Packet {
    /// Meaning of the packet.
    pub content: Content,
    /// The kernel's time stamp, ns since 1970.
    pub software_ns: Option<i64>,
    /// The controller's time stamp, ns of its own clock.
    pub hardware_ns: Option<i64>,
    /// Frames that the socket has lost so far, if any (SO_RXQ_OVFL; wraps).
    pub dropped: Option<u32>,
}

/// The kinds of packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// A classic data frame with an 11-bit identifier.
    Frame(CanFrame),
    /// An error frame: class bits of its identifier, and its data.
    Error(u32, [u8; 8]),
    /// Anything else: 29 bits, remote, CAN FD, no frame at all.
    Other,
}

impl Endpoint {
    /// Opens an interface for the data of these boards (`id & 0x00F`), with error frames, receive times
    /// and the count of lost frames. No boards: all frames.
    ///
    /// # Errors
    /// Error of the system; `ENODEV` for an interface that does not exist.
    pub fn open(interface: &str, boards: &[u8]) -> io::Result<Self> {
        let socket = CanSocket::open(interface)?;
        if !boards.is_empty() {
            // Extended and remote frames have their flag set, so the mask refuses them.
            let mask = 0x00F | libc::CAN_EFF_FLAG | libc::CAN_RTR_FLAG;
            let filter = |c: &u8| CanFilter::new(canid_t::from(*c), mask);
            let filters: Vec<CanFilter> = boards.iter().map(filter).collect();
            socket.set_filters(&filters)?;
        }
        socket.set_error_filter_accept_all()?;
        socket.set_nonblocking(true)?;
        // Beyond the system's limit where that is allowed, else up to it.
        if setsockopt(&socket, sockopt::RcvBufForce, &RECEIVE_BUFFER).is_err() {
            setsockopt(&socket, sockopt::RcvBuf, &RECEIVE_BUFFER)?;
        }
        setsockopt(&socket, sockopt::RxqOvfl, &1)?;
        let stamps = TimestampingFlag::SOF_TIMESTAMPING_RX_HARDWARE
            | TimestampingFlag::SOF_TIMESTAMPING_RAW_HARDWARE
            | TimestampingFlag::SOF_TIMESTAMPING_RX_SOFTWARE
            | TimestampingFlag::SOF_TIMESTAMPING_SOFTWARE;
        setsockopt(&socket, sockopt::Timestamping, &stamps)?;
        Ok(Self { socket })
    }

    /// The next packet. Never waits.
    ///
    /// # Errors
    /// `EAGAIN` when there is none; `ENETDOWN` once when the interface goes down, `ENODEV` when it is
    /// gone.
    pub fn receive(&self) -> Result<Packet, Errno> {
        let mut bytes = [0; FRAME];
        // A time stamp of three times (two kinds of them at most) and the count of lost frames.
        let mut control = nix::cmsg_space!([TimeSpec; 3], [TimeSpec; 3], u32);
        let mut parts = [IoSliceMut::new(&mut bytes)];
        let message = recvmsg::<()>(
            self.socket.as_raw_fd(),
            &mut parts,
            Some(&mut control),
            MsgFlags::MSG_DONTWAIT,
        )?;
        let length = message.bytes;
        let (mut software_ns, mut hardware_ns, mut dropped) = (None, None, None);
        for part in message.cmsgs()? {
            match part {
                ControlMessageOwned::ScmTimestampsns(stamps) => {
                    software_ns = nanoseconds(stamps.system);
                    hardware_ns = nanoseconds(stamps.hw_raw);
                }
                ControlMessageOwned::RxqOvfl(count) => dropped = Some(count),
                _ => {}
            }
        }
        Ok(Packet {
            content: content(&bytes[..length.min(FRAME)]),
            software_ns,
            hardware_ns,
            dropped,
        })
    }

    /// Queues a frame.
    ///
    /// # Errors
    /// `ENOBUFS` or `EAGAIN` for a full queue, `ENETDOWN` for an interface that is down.
    pub fn send(&self, frame: &CanFrame) -> Result<(), Errno> {
        let mut bytes = [0; FRAME];
        bytes[..4].copy_from_slice(&u32::from(frame.id()).to_ne_bytes());
        bytes[4] = frame.data().len() as u8; // at most 8
        bytes[8..8 + frame.data().len()].copy_from_slice(frame.data());
        send(self.socket.as_raw_fd(), &bytes, MsgFlags::MSG_DONTWAIT).map(drop)
    }
}

/// Makes a double for tests: one end of a pair of datagram sockets speaks like a CAN socket.
impl From<OwnedFd> for Endpoint {
    fn from(fd: OwnedFd) -> Self {
        Self {
            socket: CanSocket::from(fd),
        }
    }
}

impl AsFd for Endpoint {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }
}

impl AsRawFd for Endpoint {
    fn as_raw_fd(&self) -> RawFd {
        self.socket.as_raw_fd()
    }
}

/// A stamp in nanoseconds; the kernel leaves those it does not have at zero.
fn nanoseconds(stamp: TimeSpec) -> Option<i64> {
    let ns = stamp
        .tv_sec()
        .checked_mul(1_000_000_000)?
        .checked_add(stamp.tv_nsec())?;
    (ns > 0).then_some(ns)
}

/// The meaning of a packet's bytes.
fn content(bytes: &[u8]) -> Content {
    let &[i0, i1, i2, i3, length, _, _, _, ref data @ ..] = bytes else {
        return Content::Other;
    };
    let Ok(data) = <[u8; 8]>::try_from(data) else {
        return Content::Other;
    };
    let id = u32::from_ne_bytes([i0, i1, i2, i3]);
    if id & libc::CAN_ERR_FLAG != 0 {
        return Content::Error(id & libc::CAN_ERR_MASK, data);
    }
    let (short, length) = (u16::try_from(id), usize::from(length));
    match (short, data.get(..length)) {
        (Ok(id), Some(data)) => CanFrame::new(id, data).map_or(Content::Other, Content::Frame),
        _ => Content::Other,
    }
}

#[cfg(test)]
#[path = "socket_tests.rs"]
mod tests;
