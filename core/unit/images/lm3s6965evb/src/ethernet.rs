//! The Stellaris Ethernet controller, as smoltcp wants it: one frame at a time.

use palpate_image::Register;
use palpate_image::udp::Card;
use smoltcp::phy::{Checksum, Device, DeviceCapabilities, Medium, RxToken, TxToken};
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetAddress, HardwareAddress};

const CLEAR: Register = Register(0x4004_8000);
const MASK: Register = Register(0x4004_8004);
const RECEIVE: Register = Register(0x4004_8008);
const TRANSMIT: Register = Register(0x4004_800C);
const DATA: Register = Register(0x4004_8010);
const ADDRESS: [Register; 2] = [Register(0x4004_8014), Register(0x4004_8018)];
const WAITING: Register = Register(0x4004_8034);
const REQUEST: Register = Register(0x4004_8038);

/// Longest frame without its check sequence.
const FRAME: usize = 1514;
/// Every interrupt.
const ALL: u32 = 0x7F;

/// The controller.
#[derive(Debug)]
pub struct Ethernet {
    received: [u8; FRAME],
    sent: [u8; FRAME],
}

impl Ethernet {
    /// Switches it on.
    pub fn start() -> Self {
        CLEAR.write(ALL);
        // Length padded, check sequence added, both ways at once.
        TRANSMIT.write(0b1_0111);
        RECEIVE.write(1);
        // A frame that came ends the processor's rest.
        MASK.write(1);
        Self {
            received: [0; FRAME],
            sent: [0; FRAME],
        }
    }

    /// Whether a frame waits.
    pub fn is_waiting() -> bool {
        WAITING.read() & 0x3F != 0
    }

    /// Takes the oldest frame out of the controller; its length.
    fn take(&mut self) -> Option<usize> {
        CLEAR.write(1);
        if !Self::is_waiting() {
            return None;
        }
        // Two bytes of length, of themselves and the check sequence as well, then the frame, in words.
        let first = DATA.read().to_le_bytes();
        let whole = usize::from(u16::from_le_bytes([first[0], first[1]]));
        self.received[..2].copy_from_slice(&first[2..]);
        for at in (4..whole).step_by(4) {
            let word = DATA.read().to_le_bytes();
            if let Some(room) = self.received.get_mut(at - 2..) {
                let length = room.len().min(4);
                room[..length].copy_from_slice(&word[..length]);
            }
        }
        Some(whole.saturating_sub(6).min(FRAME))
    }
}

/// A frame that came.
#[derive(Debug)]
pub struct Received<'a>(&'a [u8]);

impl RxToken for Received<'_> {
    fn consume<R, F: FnOnce(&[u8]) -> R>(self, use_it: F) -> R {
        use_it(self.0)
    }
}

/// Room for a frame that goes.
#[derive(Debug)]
pub struct Sent<'a>(&'a mut [u8; FRAME]);

impl TxToken for Sent<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, fill: F) -> R {
        let frame = &mut self.0[..length.min(FRAME)];
        let result = fill(frame);
        // Its length without the Ethernet header, then the frame, in words.
        let [low, high] = (frame.len().saturating_sub(14) as u16).to_le_bytes();
        let byte = |at: usize| frame.get(at).copied().unwrap_or(0);
        DATA.write(u32::from_le_bytes([low, high, byte(0), byte(1)]));
        for at in (2..frame.len()).step_by(4) {
            DATA.write(u32::from_le_bytes([
                byte(at),
                byte(at + 1),
                byte(at + 2),
                byte(at + 3),
            ]));
        }
        REQUEST.write(1);
        result
    }
}

impl Card for Ethernet {
    fn address(&self) -> HardwareAddress {
        let [a, b, c, d] = ADDRESS[0].read().to_le_bytes();
        let [e, f, ..] = ADDRESS[1].read().to_le_bytes();
        HardwareAddress::Ethernet(EthernetAddress([a, b, c, d, e, f]))
    }

    fn is_waiting(&self) -> bool {
        Self::is_waiting()
    }
}

impl Device for Ethernet {
    type RxToken<'a> = Received<'a>;
    type TxToken<'a> = Sent<'a>;

    fn receive(&mut self, _: Instant) -> Option<(Received<'_>, Sent<'_>)> {
        let length = self.take()?;
        Some((Received(&self.received[..length]), Sent(&mut self.sent)))
    }

    fn transmit(&mut self, _: Instant) -> Option<Sent<'_>> {
        Some(Sent(&mut self.sent))
    }

    fn capabilities(&self) -> DeviceCapabilities {
        let mut capabilities = DeviceCapabilities::default();
        capabilities.medium = Medium::Ethernet;
        capabilities.max_transmission_unit = FRAME;
        capabilities.max_burst_size = Some(1);
        // The seal says more of a datagram than UDP's sum does.
        capabilities.checksum.udp = Checksum::Tx;
        capabilities
    }
}
