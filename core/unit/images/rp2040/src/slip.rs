//! Packets on a serial line (RFC 1055).

const END: u8 = 0xC0;
const ESCAPE: u8 = 0xDB;
const ESCAPED_END: u8 = 0xDC;
const ESCAPED_ESCAPE: u8 = 0xDD;

/// Longest packet: a datagram with its heads.
pub const PACKET: usize = 1500;
/// Most bytes of a packet on the line.
pub const LINE: usize = 2 * PACKET + 2;

/// Takes packets from a line, byte by byte.
#[derive(Debug)]
pub struct Incoming {
    packet: [u8; PACKET],
    length: usize,
    escaped: bool,
}

impl Incoming {
    /// State before the first byte.
    pub const fn new() -> Self {
        Self {
            packet: [0; PACKET],
            length: 0,
            escaped: false,
        }
    }

    /// Takes the next byte of the line; returns the length of a packet that it ends. See [`Self::packet`].
    pub fn byte(&mut self, byte: u8) -> Option<usize> {
        let escaped = core::mem::take(&mut self.escaped);
        let byte = match (escaped, byte) {
            (_, END) => {
                let length = core::mem::take(&mut self.length);
                return (1..=PACKET).contains(&length).then_some(length);
            }
            (_, ESCAPE) => {
                self.escaped = true;
                return None;
            }
            (true, ESCAPED_END) => END,
            (true, ESCAPED_ESCAPE) => ESCAPE,
            (_, byte) => byte,
        };
        // A longer one is none.
        if let Some(room) = self.packet.get_mut(self.length) {
            *room = byte;
        }
        self.length = (self.length + 1).min(PACKET + 1);
        None
    }

    /// The bytes of the packet that just ended.
    pub fn packet(&self, length: usize) -> &[u8] {
        &self.packet[..length.min(PACKET)]
    }
}

/// Puts a packet on a line; returns the number of bytes that it takes there.
pub fn encode(packet: &[u8], line: &mut [u8; LINE]) -> usize {
    let mut length = 0;
    let mut put = |byte| {
        // A packet has at most PACKET bytes, and each takes two at most.
        if let Some(room) = line.get_mut(length) {
            *room = byte;
            length += 1;
        }
    };
    // Ends what noise may have begun.
    put(END);
    for byte in packet {
        match *byte {
            END => [ESCAPE, ESCAPED_END].into_iter().for_each(&mut put),
            ESCAPE => [ESCAPE, ESCAPED_ESCAPE].into_iter().for_each(&mut put),
            byte => put(byte),
        }
    }
    put(END);
    length
}
