//! Datagrams over UDP for a driver unit and its host. Neither receiving nor sending waits.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::os::fd::{AsFd, BorrowedFd};
use std::time::Duration;

/// Port of a unit where an address names none.
pub const PORT: u16 = 4817;

/// The address that a user named: `HOST`, `HOST:PORT`, `[IPV6]:PORT`.
///
/// # Errors
/// Words of the expected address.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    address_or(text, PORT)
}

/// The address that a user named, with `port` where they named none.
///
/// # Errors
/// Words of the expected address.
pub fn address_or(text: &str, port: u16) -> Result<SocketAddr, String> {
    let expected = |why: &str| {
        format!(
            "expected ADDRESS or ADDRESS:PORT, such as 192.168.1.40:{port}, found `{text}`{why}"
        )
    };
    if let Ok(ip) = text.parse::<IpAddr>() {
        return Ok((ip, port).into());
    }
    if let Ok(whole) = text.parse::<SocketAddr>() {
        return Ok(whole);
    }
    let named = match text.rsplit_once(':') {
        Some((name, port)) => {
            let port = port.parse::<u16>();
            let port = port.map_err(|_| expected(", whose port is none from 0 to 65535"))?;
            (name, port).to_socket_addrs()
        }
        None => (text, port).to_socket_addrs(),
    };
    let mut found = named.map_err(|e| expected(&format!(": {e}")))?;
    found.next().ok_or_else(|| expected(": no such host"))
}

/// A UDP socket.
#[derive(Debug)]
pub struct Datagrams(UdpSocket);

impl Datagrams {
    /// Opens the end that others find at this address; port 0 takes a free one.
    ///
    /// # Errors
    /// Error of the system.
    pub fn listen(at: SocketAddr) -> io::Result<Self> {
        let socket = UdpSocket::bind(at)?;
        socket.set_nonblocking(true)?;
        Ok(Self(socket))
    }

    /// Opens an end that speaks to this address first.
    ///
    /// # Errors
    /// Error of the system.
    pub fn towards(to: SocketAddr) -> io::Result<Self> {
        let any = match (to.is_ipv4(), to.ip().is_loopback()) {
            (true, true) => Ipv4Addr::LOCALHOST.into(),
            (true, false) => IpAddr::from(Ipv4Addr::UNSPECIFIED),
            (false, true) => Ipv6Addr::LOCALHOST.into(),
            (false, false) => Ipv6Addr::UNSPECIFIED.into(),
        };
        Self::listen((any, 0).into())
    }

    /// Local address of the socket.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn here(&self) -> io::Result<SocketAddr> {
        self.0.local_addr()
    }

    /// The oldest datagram that waits, cut at the end of `buffer`, and its sender.
    pub fn receive(&self, buffer: &mut [u8]) -> Option<(usize, SocketAddr)> {
        // A network that is down is an error here: no datagram then, as with one that loses all.
        self.0.recv_from(buffer).ok()
    }

    /// Sends a datagram. One that cannot be sent is lost.
    pub fn send(&self, datagram: &[u8], to: SocketAddr) {
        let _ = self.0.send_to(datagram, to);
    }
}

impl AsFd for Datagrams {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// Tells whether the computer at this address answers that nothing listens there. A silent one gives `false` after
/// `patience`.
pub fn is_closed(to: SocketAddr, datagram: &[u8], patience: Duration) -> bool {
    let refused = || -> io::Result<()> {
        let there = Datagrams::towards(to)?;
        // Only a connected socket gets the refusal.
        there.0.set_nonblocking(false)?;
        there.0.set_read_timeout(Some(patience))?;
        there.0.connect(to)?;
        there.0.send(datagram)?;
        there.0.recv(&mut [0; 1]).map(drop)
    };
    refused().is_err_and(|e| e.kind() == io::ErrorKind::ConnectionRefused)
}

#[cfg(test)]
#[path = "datagrams_tests.rs"]
mod tests;
