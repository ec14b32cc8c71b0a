//! Datagrams by UDP on port 4000, at the address that QEMU's user network gives its guest.

use palpate_core::codec::link::{Buffer, MOST};
use palpate_core::units::Instant;
use palpate_image::Link;
use palpate_unit::Datagrams;
use smoltcp::iface::{Config, Interface, SocketHandle, SocketSet, SocketStorage};
use smoltcp::socket::udp::{PacketBuffer, PacketMetadata, Socket, UdpMetadata};
use smoltcp::time::Instant as SmoltcpInstant;
use smoltcp::wire::{EthernetAddress, HardwareAddress, IpCidr, Ipv4Address};

use crate::clock;
use crate::ethernet::Ethernet;

/// The unit's port.
const PORT: u16 = 4000;

/// Memory of the socket, for a static: two datagrams that came and one that goes.
#[derive(Debug)]
pub struct Memory {
    sockets: [SocketStorage<'static>; 1],
    came: [PacketMetadata; 2],
    goes: [PacketMetadata; 1],
}

/// Bytes of the same datagrams, in a static of their own, which then takes no flash.
pub type Bytes = ([u8; 2 * MOST], [u8; MOST]);

impl Memory {
    /// Unused.
    pub const fn new() -> Self {
        Self {
            sockets: [SocketStorage::EMPTY],
            came: [PacketMetadata::EMPTY; 2],
            goes: [PacketMetadata::EMPTY; 1],
        }
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::new()
    }
}

/// A UDP socket over the Ethernet.
pub struct Udp {
    ethernet: Ethernet,
    interface: Interface,
    sockets: SocketSet<'static>,
    socket: SocketHandle,
}

fn time() -> SmoltcpInstant {
    SmoltcpInstant::from_micros((clock::now_ns() / 1000) as i64)
}

impl Udp {
    /// Starts the network. Any other bytes of `seed` are as good.
    pub fn start(memory: &'static mut Memory, bytes: &'static mut Bytes, seed: u64) -> Self {
        let mut ethernet = Ethernet::start();
        let address = HardwareAddress::Ethernet(EthernetAddress(Ethernet::address()));
        let mut config = Config::new(address);
        config.random_seed = seed;
        let mut interface = Interface::new(config, &mut ethernet, time());
        interface.update_ip_addrs(|addresses| {
            // The list has room for one at least.
            let _ = addresses.push(IpCidr::new(Ipv4Address::new(10, 0, 2, 15).into(), 24));
        });
        let came = PacketBuffer::new(&mut memory.came[..], &mut bytes.0[..]);
        let goes = PacketBuffer::new(&mut memory.goes[..], &mut bytes.1[..]);
        let mut socket = Socket::new(came, goes);
        // Refused for port 0 alone.
        let _ = socket.bind(PORT);
        let mut sockets = SocketSet::new(&mut memory.sockets[..]);
        let socket = sockets.add(socket);
        Self {
            ethernet,
            interface,
            sockets,
            socket,
        }
    }

    fn poll(&mut self) {
        self.interface
            .poll(time(), &mut self.ethernet, &mut self.sockets);
    }
}

impl Datagrams for Udp {
    type Peer = UdpMetadata;

    fn receive(&mut self, buffer: &mut Buffer) -> Option<(usize, UdpMetadata)> {
        self.poll();
        let socket = self.sockets.get_mut::<Socket<'_>>(self.socket);
        // A longer one is cut, and refused with its seal.
        let (datagram, peer) = socket.recv().ok()?;
        let length = datagram.len().min(MOST);
        buffer[..length].copy_from_slice(&datagram[..length]);
        Some((length, peer))
    }

    fn send(&mut self, datagram: &[u8], to: UdpMetadata) {
        let socket = self.sockets.get_mut::<Socket<'_>>(self.socket);
        // Without room it is lost, as any datagram may be.
        let _ = socket.send_slice(datagram, to);
        self.poll();
    }
}

impl Link for Udp {
    fn next(&mut self) -> Option<Instant> {
        let socket = self.sockets.get::<Socket<'_>>(self.socket);
        let waits = Ethernet::is_waiting() || socket.can_recv();
        waits.then_some(Instant::ZERO)
    }
}
