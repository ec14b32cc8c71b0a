//! A frame on the wire: its bits, its checksum, its stuffing (ISO 11898-1, classic base format).

use palpate_core::codec::can::CanFrame;

/// Bits after the stuffed part: CRC delimiter, ACK slot and delimiter, end of frame (7).
pub const TRAILER: u32 = 10;
/// Recessive bits between frames (intermission).
pub const INTERMISSION: u32 = 3;
/// Generator of CRC-15-CAN.
const CRC_POLY: u16 = 0x4599;

/// Bytes under the CRC at most: the padded header and the data field.
const COVERED: usize = 11;

/// `CRC_TABLE[n][byte]`: CRC-15 of a byte with `n` zero bytes behind it. The register starts at zero, so the
/// CRC of a frame is the XOR over its bytes, and the look-ups need not wait for one another.
static CRC_TABLE: [[u16; 256]; COVERED] = {
    let mut table = [[0; 256]; COVERED];
    let mut byte = 0;
    while byte < 256 {
        let (mut crc, mut behind) = ((byte as u16) << 7, 0);
        while behind < COVERED {
            let mut bit = 0;
            while bit < 8 {
                crc = if crc & 0x4000 != 0 {
                    crc << 1 ^ CRC_POLY
                } else {
                    crc << 1
                };
                bit += 1;
            }
            crc &= 0x7FFF;
            table[behind][byte] = crc;
            behind += 1;
        }
        byte += 1;
    }
    table
};

/// One bit through the stuffing rule. A state is `level * 4 + run - 1` with run 1 to 4: the fifth
/// equal bit is followed at once by a stuff bit of the other level. Returns (state, stuff bits).
const fn stuff_bit(state: u8, bit: u8) -> (u8, u8) {
    let (level, run) = (state / 4, state % 4 + 1);
    if bit != level {
        (bit * 4, 0)
    } else if run == 4 {
        ((1 - level) * 4, 1)
    } else {
        (state + 1, 0)
    }
}

/// Bits of the sequence that go through the stuffing rule at once.
const CHUNK: u32 = 11;

/// [`stuff_bit`] over [`CHUNK`] bits, most significant first: a byte for every start state, the next state in bits 3 to 5,
/// the stuff bits in bits 0 to 2. All look-ups of a frame are made at once; what waits for the state is a shift.
static STUFF: [u64; 1 << CHUNK] = {
    let mut table = [0; 1 << CHUNK];
    let mut value = 0;
    while value < 1 << CHUNK {
        let mut start = 0;
        while start < 8 {
            let (mut state, mut count, mut bit) = (start as u8, 0, CHUNK);
            while bit > 0 {
                bit -= 1;
                let (next, stuffed) = stuff_bit(state, (value >> bit & 1) as u8);
                state = next;
                count += stuffed;
            }
            table[value] |= ((state << 3 | count) as u64) << (8 * start);
            start += 1;
        }
        value += 1;
    }
    table
};

/// Start of frame to the length code, 19 bits. SOF, RTR, IDE and r0 are dominant: only the identifier
/// and the length have ones.
fn header(frame: &CanFrame) -> u32 {
    u32::from(frame.id()) << 7 | frame.data().len() as u32
}

/// Start of frame to data field, right-aligned, and its length.
fn covered(frame: &CanFrame) -> (u128, u32) {
    let length = 8 * frame.data().len() as u32;
    let data = u128::from(u64::from_be_bytes(frame.padded())) >> (64 - length);
    (u128::from(header(frame)) << length | data, 19 + length)
}

/// CRC-15 of these bits, from start of frame to data field. Leading zeros leave a zero register alone, so every frame may be as long as the longest.
fn crc_of(covered: u128) -> u16 {
    let bytes = covered.to_le_bytes();
    let bytes = bytes.iter().zip(&CRC_TABLE);
    bytes.fold(0, |crc, (&byte, table)| crc ^ table[usize::from(byte)])
}

/// Stuff bits of a frame.
pub fn stuff_bits(frame: &CanFrame) -> u32 {
    /// Chunks of the longest frame.
    const CHUNKS: u32 = 98_u32.div_ceil(CHUNK);
    /// Stands before shorter ones, so that all take the same way: alternating bits are never stuffed, and the last one is
    /// recessive, as the bus is before the start of frame.
    const FILL: u128 = u128::MAX / 3;
    let (bits, length) = sequence(frame);
    let bits = FILL << length | bits;
    let (mut state, mut count) = (0, 0);
    for chunk in (0..CHUNKS).rev() {
        let value = (bits >> (chunk * CHUNK)) as usize & ((1 << CHUNK) - 1);
        let entry = STUFF[value] >> state;
        state = entry & 0o70;
        count += entry & 7;
    }
    count as u32 // at most 24
}

/// The stuffed part without its stuff bits (start of frame to CRC), right-aligned, and its length.
fn sequence(frame: &CanFrame) -> (u128, u32) {
    let (bits, length) = covered(frame);
    (bits << 15 | u128::from(crc_of(bits)), length + 15)
}

/// Bits from start of frame to the end of its end-of-frame field, stuffing included. The
/// intermission follows.
pub fn length(frame: &CanFrame) -> u32 {
    34 + 8 * frame.data().len() as u32 + stuff_bits(frame) + TRAILER
}

/// The stuffed bits of a frame from start of frame to CRC, `true` = recessive.
pub fn stuffed(frame: &CanFrame) -> impl Iterator<Item = bool> {
    let (bits, length) = sequence(frame);
    let mut state = 4;
    (0..length).rev().flat_map(move |shift| {
        let bit = (bits >> shift & 1) as u8;
        let (next, stuffed) = stuff_bit(state, bit);
        state = next;
        [Some(bit == 1), (stuffed == 1).then_some(bit == 0)]
            .into_iter()
            .flatten()
    })
}

/// The position of the first bit in which two frames sent at once differ (0 = start of frame), or
/// `None` if they are the same on the wire.
pub fn first_difference(a: &CanFrame, b: &CanFrame) -> Option<u32> {
    stuffed(a)
        .zip(stuffed(b))
        .position(|(a, b)| a != b)
        .map(|n| n as u32)
}

#[cfg(test)]
#[path = "bits_tests.rs"]
mod tests;
