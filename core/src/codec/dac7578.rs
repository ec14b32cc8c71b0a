//! DAC7578 frames (TI data sheet SBAS496A; its sections in brackets): eight converters of twelve bits behind one address.
//!
//! A write is a command and access byte, then two data bytes [DACx578 I2C update sequence, table 1]. A read is that byte
//! alone, a repeated START and two bytes. A code stands left-justified in its two bytes.

use core::ops::RangeInclusive;

/// Write the input register of a channel.
pub const WRITE: u8 = 0x00;
/// Copy the input register of a channel to its DAC register; as a read, the DAC register itself.
pub const UPDATE: u8 = 0x10;
/// Write the input register of a channel and copy all of them.
pub const WRITE_UPDATE_ALL: u8 = 0x20;
/// Write the input register of a channel and copy that one.
pub const WRITE_UPDATE: u8 = 0x30;
/// Power channels up or down [power-down commands].
pub const POWER: u8 = 0x40;
/// Write what the CLR pin loads [clear code register and CLR pin].
pub const CLEAR_CODE: u8 = 0x50;
/// Choose the channels that do without the LDAC pin [LDAC functionality].
pub const LDAC: u8 = 0x60;
/// Reset as at power-on [software reset function].
pub const RESET: u8 = 0x70;

/// Access bits of all channels together.
pub const ALL: u8 = 0x0F;
/// Channels of one chip, A to H.
pub const CHANNELS: u8 = 8;
/// The largest code.
pub const FULL_SCALE: u16 = 0x0FFF;
/// 7-bit addresses that the ADDR pins choose between: all of the QFN package, three of them with the TSSOP package [tables
/// 3 and 4].
pub const ADDRESSES: RangeInclusive<u8> = 0x48..=0x4F;
/// The 7-bit address that every such chip of a bus obeys, for writing.
pub const BROADCAST_ADDRESS: u8 = 0x47;

/// The data of a power command that switches all channels on: mode 00 and a bit for each.
pub const ALL_ON: u16 = 0x1FE0;
/// The data of an LDAC command by which no channel waits for the pin.
pub(crate) const NO_PIN: u16 = 0xFF00;

/// The bytes of a write: a command, its access bits, and two bytes of data.
pub const fn frame(command: u8, access: u8, data: u16) -> [u8; 3] {
    let [high, low] = data.to_be_bytes();
    [command | access & ALL, high, low]
}

/// A code as data.
pub const fn data(code: u16) -> u16 {
    code << 4
}

/// The largest code that gives no more than a current, where `full_scale` belongs to the largest of all; both in one unit.
pub const fn code_of(current: u32, full_scale: u32) -> u16 {
    let full = if full_scale == 0 { 1 } else { full_scale };
    let code = current as u64 * FULL_SCALE as u64 / full as u64;
    if code > FULL_SCALE as u64 {
        FULL_SCALE
    } else {
        code as u16
    }
}

/// The code in two bytes that were read.
pub const fn code(bytes: [u8; 2]) -> u16 {
    u16::from_be_bytes(bytes) >> 4
}
