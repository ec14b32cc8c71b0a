//! Registers of a DRV2605L (TI data sheet SLOS854; names in capitals are its fields), and the codes of voltages and times.
//!
//! Every chip has the same address: eight of them need a [switch](super::tca9548a). A rated and a clamp voltage are codes of
//! 8 bits, whose steps depend on the motor and the loop. A code is rounded down, so that it stands for no more than asked.

/// 7-bit address of every chip.
pub const ADDRESS: u8 = 0x5A;

/// Identity of the chip, results and faults.
pub const STATUS: u8 = 0x00;
/// Mode, standby and reset.
pub const MODE: u8 = 0x01;
/// Amplitude in real-time playback.
pub const RTP_INPUT: u8 = 0x02;
/// Library of effects, and the output's high impedance.
pub const LIBRARY: u8 = 0x03;
/// First of eight entries of the sequencer.
pub const SEQUENCE: u8 = 0x04;
/// Number of entries of the sequencer.
pub const ENTRIES: u8 = 8;
/// Begins a sequence, a diagnosis or a calibration.
pub const GO: u8 = 0x0C;
/// Voltage of full drive in a closed loop.
pub const RATED_VOLTAGE: u8 = 0x16;
/// Voltage that no overdrive exceeds, and that of full drive in an open loop.
pub const OD_CLAMP: u8 = 0x17;
/// Losses in the coil, as calibrated.
pub const A_CAL_COMP: u8 = 0x18;
/// Back-EMF at the rated voltage, as calibrated.
pub const A_CAL_BEMF: u8 = 0x19;
/// Kind of motor, brake, loop and gain of the back-EMF.
pub const FEEDBACK: u8 = 0x1A;
/// Drive time and more.
pub const CONTROL1: u8 = 0x1B;
/// Sample time and more.
pub const CONTROL2: u8 = 0x1C;
/// Open loops and data formats.
pub const CONTROL3: u8 = 0x1D;
/// Time of a calibration.
pub const CONTROL4: u8 = 0x1E;
/// Open-loop period of a resonant actuator.
pub const OPEN_PERIOD: u8 = 0x20;
/// Supply voltage, as measured.
pub const VBAT: u8 = 0x21;
/// Period of a resonant actuator, as measured.
pub const LRA_PERIOD: u8 = 0x22;
/// Number of registers.
pub const COUNT: usize = 0x23;

/// Period of a unit of the registers of periods, s.
pub const PERIOD_S: f64 = 98.46e-6;
/// Code of [`A_CAL_BEMF`] for a back-EMF of 1 V at a gain of 1.
pub const EMF_PER_V: f64 = 255.0 / 1.22;
/// Supply voltage of a unit of [`VBAT`], V.
pub const VBAT_V: f64 = 5.6 / 255.0;

/// Values after power-on and reset.
pub const RESET: [u8; COUNT] = [
    0xE0, 0x40, 0x00, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x05, 0x19, 0xFF, 0x19, 0xFF, 0x3E, 0x8C, 0x0C, 0x6C, 0x36, 0x93, 0xF5, 0xA0, 0x20, 0x80,
    0x33, 0x00, 0x00,
];

/// Bits of [`STATUS`].
pub mod status {
    /// Place of the device number.
    pub const DEVICE: u32 = 5;
    /// Device number of the DRV2605L.
    pub const DRV2605L: u8 = 7;
    /// A diagnosis or calibration failed.
    pub const DIAG_RESULT: u8 = 0x08;
    /// The chip was too hot.
    pub const OVER_TEMPERATURE: u8 = 0x02;
    /// The output was overloaded.
    pub const OVER_CURRENT: u8 = 0x01;
}

/// Values of [`MODE`].
pub mod mode {
    /// Bits that tell the mode.
    pub const KIND: u8 = 0x07;
    /// Standby: the output is off, registers stay.
    pub const STANDBY: u8 = 0x40;
    /// GO plays the sequencer's entries.
    pub const TRIGGER: u8 = 0;
    /// The level in RTP_INPUT drives the output.
    pub const REAL_TIME: u8 = 5;
    /// GO diagnoses the motor.
    pub const DIAGNOSE: u8 = 6;
    /// GO calibrates.
    pub const CALIBRATE: u8 = 7;
}

/// FEEDBACK of a motor in a closed loop: braking four times as strong as driving, medium gain.
pub const CLOSED_LOOP: u8 = 0x34;
/// Bit of FEEDBACK for a resonant actuator.
pub const LRA: u8 = 0x80;
/// BEMF_GAIN, two bits of FEEDBACK.
pub const BEMF_GAIN: u8 = 0x03;
/// DRIVE_TIME, five bits of CONTROL1.
pub const DRIVE_TIME: u8 = 0x1F;
/// CONTROL3: closed loop, signed levels, noise gate at 2 %.
pub const SIGNED_LEVELS: u8 = 0x40;

/// Step of RATED_VOLTAGE for a resonant actuator in a closed loop, V RMS: it depends on SAMPLE_TIME and the resonance, since
/// nothing drives the coil while its back-EMF is measured.
pub fn rated_step_lra(control2: u8, resonance_hz: f64) -> f64 {
    let sample_s = 150e-6 + 50e-6 * f64::from(control2 >> 4 & 3);
    let driven = 1.0 - (4.0 * sample_s + 300e-6) * resonance_hz;
    20.58e-3 / libm::sqrt(driven.max(0.05))
}

/// Step of RATED_VOLTAGE for a rotating motor in a closed loop, V.
pub const RATED_STEP_ERM: f64 = 21.18e-3;
/// Step of OD_CLAMP for a resonant actuator in a closed loop, V peak.
pub const CLAMP_STEP_LRA: f64 = 21.22e-3;
/// Step of OD_CLAMP for a rotating motor in a closed loop, V.
pub const CLAMP_STEP_ERM: f64 = 21.64e-3;

/// The largest code that stands for at most `volts`; `None` for less than one step, and beyond 8 bits.
pub fn code(volts: f64, step: f64) -> Option<u8> {
    let code = libm::floor(volts / step * (1.0 + 1e-12));
    (1.0..=255.0).contains(&code).then_some(code as u8)
}

/// DRIVE_TIME of a resonant actuator: half of its period, at most 3.6 ms.
pub fn drive_time_lra(resonance_hz: f64) -> u8 {
    libm::round((0.5e6 / resonance_hz - 500.0) / 100.0).clamp(0.0, 31.0) as u8
}

#[cfg(test)]
#[path = "drv2605_tests.rs"]
mod tests;
