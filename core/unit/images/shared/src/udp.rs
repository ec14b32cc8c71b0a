//! Datagrams by UDP on port 4000, over any network card.

use palpate_core::codec::link::{Buffer, MOST};
use palpate_core::units::Instant;
use palpate_unit::Datagrams;
use smoltcp::iface::{Config, Interface, SocketHandle, SocketSet, SocketStorage};
use smoltcp::phy::Device;
use smoltcp::socket::udp::{PacketBuffer, PacketMetadata, Socket, UdpMetadata};
use smoltcp::time::Instant as SmoltcpInstant;
use smoltcp::wire::{HardwareAddress, IpCidr, Ipv4Address, Ipv4Cidr};

use crate::serve::Link;

/// The unit's port.
const PORT: u16 = 4000;
/// The address that QEMU's user network gives its guest.
pub const GUEST: Ipv4Cidr = Ipv4Cidr::new(Ipv4Address::new(10, 0, 2, 15), 24);

/// A network card of a processor.
pub trait Card: Device {
    /// Address of the card on the network.
    fn address(&self) -> HardwareAddress;

    /// Tells whether something waits in the card.
    fn is_waiting(&self) -> bool;
}

/// Memory of the socket, for a static: two datagrams that came and one that goes.
#[derive(Debug)]
pub struct Memory {
    sockets: [SocketStorage<'static>; 1],
    came: [PacketMetadata; 2],
    goes: [PacketMetadata; 1],
}

/// Bytes of the same datagrams, in a static of their own, which then takes no flash.
pub type Bytes = ([u8; 2 * MOST], [u8; MOST]);
/// Bytes for a socket that is not used yet.
pub const NO_BYTES: Bytes = ([0; 2 * MOST], [0; MOST]);

impl Memory {
    /// Memory of a socket that is not used yet.
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

/// A UDP socket over a card.
pub struct Udp<C> {
    card: C,
    clock: fn() -> Instant,
    interface: Interface,
    sockets: SocketSet<'static>,
    socket: SocketHandle,
}

fn time(clock: fn() -> Instant) -> SmoltcpInstant {
    SmoltcpInstant::from_micros(clock().as_micros() as i64)
}

impl<C: Card> Udp<C> {
    /// Starts the network: a card, the processor's clock, and the unit's address.
    pub fn start(
        mut card: C,
        clock: fn() -> Instant,
        address: Ipv4Cidr,
        (memory, bytes): (&'static mut Memory, &'static mut Bytes),
    ) -> Self {
        let config = Config::new(card.address());
        let mut interface = Interface::new(config, &mut card, time(clock));
        interface.update_ip_addrs(|addresses| {
            // The list has room for one at least.
            let _ = addresses.push(IpCidr::Ipv4(address));
        });
        let came = PacketBuffer::new(&mut memory.came[..], &mut bytes.0[..]);
        let goes = PacketBuffer::new(&mut memory.goes[..], &mut bytes.1[..]);
        let mut socket = Socket::new(came, goes);
        // Refused for port 0 alone.
        let _ = socket.bind(PORT);
        let mut sockets = SocketSet::new(&mut memory.sockets[..]);
        let socket = sockets.add(socket);
        Self {
            card,
            clock,
            interface,
            sockets,
            socket,
        }
    }

    fn poll(&mut self) {
        let now = time(self.clock);
        self.interface.poll(now, &mut self.card, &mut self.sockets);
    }
}

impl<C: Card> Datagrams for Udp<C> {
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

impl<C: Card> Link for Udp<C> {
    fn next(&mut self) -> Option<Instant> {
        let socket = self.sockets.get::<Socket<'_>>(self.socket);
        let waits = self.card.is_waiting() || socket.can_recv();
        waits.then_some(Instant::ZERO)
    }
}
