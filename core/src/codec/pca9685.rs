//! PCA9685 register map (NXP data sheet rev. 4, section 7.3; section numbers in brackets).

/// MODE1 register address [7.3.1].
pub const MODE1: u8 = 0x00;
/// MODE2 register address [7.3.2].
pub const MODE2: u8 = 0x01;
/// SUBADR1 register address; SUBADR2 and 3 follow [7.3.6].
pub const SUBADR1: u8 = 0x02;
/// ALLCALLADR register address [7.3.7].
pub const ALLCALLADR: u8 = 0x05;
/// LED0_ON_L register address; channel n starts at `LED0_ON_L + 4 n` [7.3.3].
pub const LED0_ON_L: u8 = 0x06;
/// LED15_OFF_H, the last register of the contiguous block.
pub const LED15_OFF_H: u8 = 0x45;
/// ALL_LED_ON_L register address, write only, followed by ON_H, OFF_L, OFF_H [7.3.4].
pub const ALL_LED_ON_L: u8 = 0xFA;
/// ALL_LED_OFF_H register address.
pub const ALL_LED_OFF_H: u8 = 0xFD;
/// PRE_SCALE register address [7.3.5].
pub const PRE_SCALE: u8 = 0xFE;
/// TESTMODE register address.
pub const TESTMODE: u8 = 0xFF;

/// Bits of MODE1 [7.3.1].
pub mod mode1 {
    /// Restart pending (reads 1 after SLEEP with outputs running); write 1 to restart.
    pub const RESTART: u8 = 0x80;
    /// Use the EXTCLK pin; sticky until power-on or software reset.
    pub const EXTCLK: u8 = 0x40;
    /// Register auto-increment.
    pub const AI: u8 = 0x20;
    /// Low-power mode, oscillator off.
    pub const SLEEP: u8 = 0x10;
    /// Responds to sub-address 1.
    pub const SUB1: u8 = 0x08;
    /// Responds to sub-address 2.
    pub const SUB2: u8 = 0x04;
    /// Responds to sub-address 3.
    pub const SUB3: u8 = 0x02;
    /// Responds to the all-call address.
    pub const ALLCALL: u8 = 0x01;
    /// Value after power-on reset.
    pub const RESET: u8 = SLEEP | ALLCALL;
}

/// Bits of MODE2 [7.3.2].
pub mod mode2 {
    /// Output logic inverted (counts only with OE low).
    pub const INVRT: u8 = 0x10;
    /// Outputs change on ACK rather than on STOP.
    pub const OCH: u8 = 0x08;
    /// Totem pole rather than open drain.
    pub const OUTDRV: u8 = 0x04;
    /// State of outputs while OE is high: two bits.
    pub const OUTNE: u8 = 0x03;
    /// Value after power-on reset.
    pub const RESET: u8 = OUTDRV;
}

/// Bit 4 of ON_H / OFF_H: full on / full off [7.3.3].
pub const FULL: u8 = 0x10;
/// PRE_SCALE after power-on reset: 200 Hz nominal, 196.89 Hz in truth.
pub const PRE_SCALE_RESET: u8 = 0x1E;
/// SUBADR1..3 and ALLCALLADR after power-on reset: the 7-bit address in the upper seven bits.
pub const SUBADR_RESET: [u8; 4] = [0xE2, 0xE4, 0xE8, 0xE0];
/// The all-call address after reset, 7 bit.
pub const ALLCALL_ADDRESS: u8 = 0x70;
/// Software reset: general-call address and its data byte [7.6].
pub const SOFTWARE_RESET: (u8, u8) = (0x00, 0x06);
/// Oscillator start-up after SLEEP is cleared, microseconds [7.3.1.1].
pub const WAKE_US: u64 = 500;
/// Channels of one chip.
pub const CHANNELS: u8 = 16;

/// Register address of channel `n`'s ON_L.
pub const fn led(n: u8) -> u8 {
    LED0_ON_L + 4 * n
}
