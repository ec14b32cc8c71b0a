//! TCA9548A control register (TI data sheet SCPS207): an I2C switch with eight channels, a bit each, and no other register.

use core::ops::RangeInclusive;

/// 7-bit addresses that pins A0 to A2 choose between [address reference].
pub const ADDRESSES: RangeInclusive<u8> = 0x70..=0x77;
/// Channels of one switch.
pub const CHANNELS: u8 = 8;
/// Control register after power-up or RESET: no channel connected.
pub const RESET: u8 = 0x00;

/// The control byte that connects one channel; none for a channel that does not exist.
pub const fn only(channel: u8) -> u8 {
    if channel < CHANNELS { 1 << channel } else { 0 }
}
