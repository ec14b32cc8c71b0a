//! Controller of an interface as the kernel knows it: one question, or one command, over a netlink socket of its own.

use std::os::fd::{AsRawFd, OwnedFd};

use nix::errno::Errno;
use nix::libc;
use nix::net::if_::if_nametoindex;
use nix::sys::socket::{
    AddressFamily, MsgFlags, SockFlag, SockProtocol, SockType, recv, send, socket,
};

/// Bytes of the heads `nlmsghdr` and `ifinfomsg`, which attributes follow.
const HEADS: usize = 32;
/// Longest reply: the kernel sends no longer one on a link.
const REPLY: usize = 32 << 10;
/// Bits of an attribute's type that are no flags.
const TYPE: u16 = 0x3FFF;

// Types of `linux/can/netlink.h`.
const CAN_BITTIMING: u16 = libc::IFLA_CAN_BITTIMING as u16;
const CAN_STATE: u16 = libc::IFLA_CAN_STATE as u16;
const CAN_RESTART_MS: u16 = libc::IFLA_CAN_RESTART_MS as u16;
const CAN_RESTART: u16 = libc::IFLA_CAN_RESTART as u16;

/// States of a controller, in the order of the kernel's `enum can_state`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CanState {
    /// Takes part in everything.
    ErrorActive,
    /// More than 96 errors.
    ErrorWarning,
    /// More than 128 errors: may no longer destroy frames.
    ErrorPassive,
    /// More than 256 errors: off the bus.
    BusOff,
    /// Switched off.
    Stopped,
    /// Waits for a frame.
    Sleeping,
}

/// Facts on a controller; a virtual interface has none of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Controller {
    /// Bit rate, bit/s; 0 where the kernel does not know it.
    pub bitrate: Option<u32>,
    /// State on the bus.
    pub state: Option<CanState>,
    /// Time from bus-off to the kernel's restart, ms; 0 for none.
    pub restart_ms: Option<u32>,
}

impl Controller {
    /// Asks the kernel about an interface.
    ///
    /// # Errors
    /// `ENODEV` for an interface that does not exist, and other errors of the system.
    pub fn ask(interface: &str) -> Result<Self, Errno> {
        let reply = exchange(interface, libc::RTM_GETLINK, 0, &[])?;
        Ok(Self::read(reply.get(HEADS..).unwrap_or_default()))
    }

    /// Reads the attributes of a link.
    fn read(link: &[u8]) -> Self {
        let info = find(link, libc::IFLA_LINKINFO).unwrap_or_default();
        let data = find(info, libc::IFLA_INFO_DATA).unwrap_or_default();
        let states = [
            CanState::ErrorActive,
            CanState::ErrorWarning,
            CanState::ErrorPassive,
            CanState::BusOff,
            CanState::Stopped,
            CanState::Sleeping,
        ];
        Self {
            // the first of the numbers there
            bitrate: number(data, CAN_BITTIMING),
            state: number(data, CAN_STATE).and_then(|state| states.get(state as usize).copied()),
            restart_ms: number(data, CAN_RESTART_MS),
        }
    }
}

/// Restarts the controller of an interface that is bus-off.
///
/// # Errors
/// `EPERM` without CAP_NET_ADMIN, `EBUSY` for a controller that is on the bus, `EOPNOTSUPP` where there is none.
pub fn restart(interface: &str) -> Result<(), Errno> {
    exchange(interface, libc::RTM_NEWLINK, libc::NLM_F_ACK, &restarting()).map(drop)
}

fn restarting() -> Vec<u8> {
    let data = attribute(CAN_RESTART, &1_u32.to_ne_bytes());
    let mut info = attribute(libc::IFLA_INFO_KIND, b"can");
    info.extend(attribute(libc::IFLA_INFO_DATA, &data));
    attribute(libc::IFLA_LINKINFO, &info)
}

/// Sends one request on an interface; returns the kernel's reply with its heads.
fn exchange(
    interface: &str,
    request: u16,
    flags: libc::c_int,
    attributes: &[u8],
) -> Result<Vec<u8>, Errno> {
    let index = if_nametoindex(interface)?;
    let flags = (libc::NLM_F_REQUEST | flags) as u16; // both fit
    let mut message = Vec::with_capacity(HEADS + attributes.len());
    message.extend(((HEADS + attributes.len()) as u32).to_ne_bytes());
    message.extend(request.to_ne_bytes());
    message.extend(flags.to_ne_bytes());
    message.extend([0; 12]); // sequence, port; family and type of the link
    message.extend(index.to_ne_bytes());
    message.extend([0; 8]); // its flags, and those to change
    message.extend(attributes);

    let (kind, to) = (SockType::Raw, SockProtocol::NetlinkRoute);
    let netlink: OwnedFd = socket(AddressFamily::Netlink, kind, SockFlag::SOCK_CLOEXEC, to)?;
    // The kernel answers within the call.
    send(netlink.as_raw_fd(), &message, MsgFlags::empty())?;
    let mut reply = vec![0; REPLY];
    let length = recv(netlink.as_raw_fd(), &mut reply, MsgFlags::MSG_DONTWAIT)?;
    reply.truncate(length);
    match reply.get(4..6) == Some(&(libc::NLMSG_ERROR as u16).to_ne_bytes()) {
        true => refusal(&reply).map_or(Ok(reply), Err),
        false => Ok(reply),
    }
}

/// The error in a message of errors; none where it acknowledges.
fn refusal(reply: &[u8]) -> Option<Errno> {
    let error = i32::from_ne_bytes(*reply.get(16..)?.first_chunk()?);
    (error != 0).then(|| Errno::from_raw(error.wrapping_neg()))
}

/// An attribute as bytes, up to where the next one begins.
fn attribute(kind: u16, data: &[u8]) -> Vec<u8> {
    let length = 4 + data.len();
    let mut bytes = Vec::with_capacity(length.next_multiple_of(4));
    bytes.extend((length as u16).to_ne_bytes());
    bytes.extend(kind.to_ne_bytes());
    bytes.extend(data);
    bytes.resize(length.next_multiple_of(4), 0);
    bytes
}

/// Data of the first attribute of a type.
fn find(mut bytes: &[u8], wanted: u16) -> Option<&[u8]> {
    loop {
        let [l0, l1, k0, k1] = *bytes.first_chunk()?;
        let length = usize::from(u16::from_ne_bytes([l0, l1]));
        let data = bytes.get(4..length)?;
        if u16::from_ne_bytes([k0, k1]) & TYPE == wanted {
            return Some(data);
        }
        bytes = bytes.get(length.next_multiple_of(4)..)?;
    }
}

fn number(bytes: &[u8], wanted: u16) -> Option<u32> {
    let data = find(bytes, wanted)?.first_chunk()?;
    Some(u32::from_ne_bytes(*data))
}

#[cfg(test)]
#[path = "controller_tests.rs"]
mod tests;
