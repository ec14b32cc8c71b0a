//! A serial port over USB as a network card: one peer, packets by SLIP.

use core::ops::Range;

use palpate_image::udp::Card;
use rp2040_hal::usb::UsbBus;
use smoltcp::phy::{Checksum, Device, DeviceCapabilities, Medium, RxToken, TxToken};
use smoltcp::time::Instant;
use smoltcp::wire::HardwareAddress;
use usb_device::bus::UsbBusAllocator;
use usb_device::device::{StringDescriptors, UsbDevice, UsbDeviceBuilder, UsbVidPid};
use usbd_serial::{SerialPort, USB_CLASS_CDC};

use crate::slip::{Incoming, LINE, PACKET, encode};

/// Bytes that wait on either side of the port.
type Store = [u8; 512];

/// The port.
pub struct Serial {
    device: UsbDevice<'static, UsbBus>,
    port: SerialPort<'static, UsbBus, Store, Store>,
    /// Bytes that came and are not looked at.
    bytes: [u8; 64],
    unread: Range<usize>,
    incoming: Incoming,
    outgoing: Outgoing,
}

/// A packet that goes.
struct Outgoing {
    packet: [u8; PACKET],
    line: [u8; LINE],
    unsent: Range<usize>,
}

impl Serial {
    /// The port of a bus; its host finds it in the turns to come.
    pub fn new(bus: &'static UsbBusAllocator<UsbBus>) -> Self {
        let port = SerialPort::new_with_store(bus, [0; 512], [0; 512]);
        // The numbers that V-USB shares for serial ports.
        let device = || UsbDeviceBuilder::new(bus, UsbVidPid(0x16C0, 0x27DD));
        let names = StringDescriptors::default()
            .manufacturer("Palpate")
            .product("driver unit");
        // Whole descriptors in a packet: the emulated host of rp2040js puts none together.
        let named = device()
            .strings(&[names])
            .and_then(|device| device.max_packet_size_0(64));
        // Refused for more languages than sixteen, or another size, alone.
        let device = named.unwrap_or_else(|_| device());
        Self {
            port,
            device: device.device_class(USB_CLASS_CDC).build(),
            bytes: [0; 64],
            unread: 0..0,
            incoming: Incoming::new(),
            outgoing: Outgoing {
                packet: [0; PACKET],
                line: [0; LINE],
                unsent: 0..0,
            },
        }
    }

    /// Moves bytes on; returns the length of a packet that came.
    fn poll(&mut self) -> Option<usize> {
        self.device.poll(&mut [&mut self.port]);
        let unsent = &mut self.outgoing.unsent;
        if let Some(rest) = self.outgoing.line.get(unsent.clone())
            && !rest.is_empty()
        {
            // A port that takes none now takes some later.
            unsent.start += self.port.write(rest).unwrap_or(0);
        } else {
            let _ = self.port.flush();
        }
        loop {
            for at in self.unread.by_ref() {
                if let Some(length) = self.incoming.byte(self.bytes[at]) {
                    return Some(length);
                }
            }
            let read = self.port.read(&mut self.bytes).unwrap_or(0);
            if read == 0 {
                return None;
            }
            self.unread = 0..read;
        }
    }
}

/// A packet that came.
#[derive(Debug)]
pub struct Received<'a>(&'a [u8]);

impl RxToken for Received<'_> {
    fn consume<R, F: FnOnce(&[u8]) -> R>(self, use_it: F) -> R {
        use_it(self.0)
    }
}

/// Room for a packet that goes.
pub struct Sent<'a>(&'a mut Outgoing);

impl TxToken for Sent<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, fill: F) -> R {
        let packet = &mut self.0.packet[..length.min(PACKET)];
        let result = fill(packet);
        self.0.unsent = 0..encode(packet, &mut self.0.line);
        result
    }
}

impl Card for Serial {
    fn address(&self) -> HardwareAddress {
        HardwareAddress::Ip
    }

    fn is_waiting(&self) -> bool {
        !self.unread.is_empty()
    }
}

impl Device for Serial {
    type RxToken<'a> = Received<'a>;
    type TxToken<'a> = Sent<'a>;

    fn receive(&mut self, _: Instant) -> Option<(Received<'_>, Sent<'_>)> {
        let length = self.poll()?;
        let packet = self.incoming.packet(length);
        Some((Received(packet), Sent(&mut self.outgoing)))
    }

    fn transmit(&mut self, _: Instant) -> Option<Sent<'_>> {
        // One at a time; smoltcp keeps the next.
        self.outgoing
            .unsent
            .is_empty()
            .then_some(Sent(&mut self.outgoing))
    }

    fn capabilities(&self) -> DeviceCapabilities {
        let mut capabilities = DeviceCapabilities::default();
        capabilities.medium = Medium::Ip;
        capabilities.max_transmission_unit = PACKET;
        capabilities.max_burst_size = Some(1);
        // The seal says more of a datagram than UDP's sum does.
        capabilities.checksum.udp = Checksum::Tx;
        capabilities
    }
}
