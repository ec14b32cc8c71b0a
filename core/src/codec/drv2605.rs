//! DRV2605L register map and formulas (TI data sheet SLOS854; names in capitals are its fields).
//!
//! One haptic driver behind one fixed address: eight of them need a [switch](super::tca9548a). A rated and a clamp voltage
//! are codes of 8 bits, whose steps depend on the actuator and the loop. The functions here convert both ways.

/// The 7-bit address, the same for every chip.
pub const ADDRESS: u8 = 0x5A;
/// STATUS: device number, result of a diagnosis, two flags that a read clears.
pub const STATUS: u8 = 0x00;
/// MODE: reset, standby and what drives the output.
pub const MODE: u8 = 0x01;
/// RTP_INPUT: level of real-time playback.
pub const RTP_INPUT: u8 = 0x02;
/// LIBRARY_SEL and HI_Z.
pub const LIBRARY: u8 = 0x03;
/// WAV_FRM_SEQ1: the first of eight steps of the sequencer.
pub const SEQUENCE: u8 = 0x04;
/// GO: starts what the mode stands for, and reads 1 until that is over.
pub const GO: u8 = 0x0C;
/// ODT, SPT, SNT and BRT: signed offsets of a library effect's times.
pub const OFFSETS: u8 = 0x0D;
/// ATH_CONTROL: the first of five registers of audio-to-vibe.
pub const AUDIO: u8 = 0x11;
/// RATED_VOLTAGE: full scale of the closed loop.
pub const RATED_VOLTAGE: u8 = 0x16;
/// OD_CLAMP: bound of overdrive, and full scale of the open loop.
pub const OD_CLAMP: u8 = 0x17;
/// A_CAL_COMP: compensation for the coil's resistance, a result of the calibration.
pub const A_CAL_COMP: u8 = 0x18;
/// A_CAL_BEMF: back-EMF at the rated voltage, a result of the calibration.
pub const A_CAL_BEMF: u8 = 0x19;
/// Feedback control.
pub const FEEDBACK: u8 = 0x1A;
/// Control 1: start-up boost, coupling, drive time.
pub const CONTROL1: u8 = 0x1B;
/// Control 2: direction of the input, times of the back-EMF's measurement.
pub const CONTROL2: u8 = 0x1C;
/// Control 3: loop, format of the level, noise gate.
pub const CONTROL3: u8 = 0x1D;
/// Control 4: time of the calibration.
pub const CONTROL4: u8 = 0x1E;
/// Control 5: automatic open loop, playback interval.
pub const CONTROL5: u8 = 0x1F;
/// OL_LRA_PERIOD: period of an open loop, in steps of [`PERIOD_STEP_US`].
pub const OL_LRA_PERIOD: u8 = 0x20;
/// VBAT: supply, read only, 5.6 V / 255 a step.
pub const VBAT: u8 = 0x21;
/// LRA_PERIOD: the tracked period, read only, in steps of [`PERIOD_STEP_US`].
pub const LRA_PERIOD: u8 = 0x22;
/// Registers of one chip.
pub const REGISTERS: usize = 0x23;

/// Registers after power-up or DEV_RESET.
pub const DEFAULTS: [u8; REGISTERS] = [
    0xE0, 0x40, 0x00, 0x01, 0x01, 0, 0, 0, 0, 0, 0, 0, 0x00, 0, 0, 0, 0, 0x05, 0x19, 0xFF, 0x19,
    0xFF, 0x3E, 0x8C, 0x0C, 0x6C, 0x36, 0x93, 0xF5, 0xA0, 0x20, 0x80, 0x33, 0x00, 0x00,
];

/// Bits of STATUS.
pub mod status {
    /// Device number in the upper three bits.
    pub const DEVICE: u8 = 0xE0;
    /// Device number of the DRV2605L.
    pub const DRV2605L: u8 = 7;
    /// A diagnosis or calibration failed.
    pub const DIAG_RESULT: u8 = 0x08;
    /// The chip was too hot.
    pub const OVER_TEMP: u8 = 0x02;
    /// The output was overloaded.
    pub const OC_DETECT: u8 = 0x01;
}

/// Bits and values of MODE.
pub mod mode {
    /// Resets all registers; clears itself.
    pub const RESET: u8 = 0x80;
    /// Software standby: the output is off, registers stay.
    pub const STANDBY: u8 = 0x40;
    /// The three bits that choose a source.
    pub const SOURCE: u8 = 0x07;
    /// GO plays the sequencer.
    pub const INTERNAL: u8 = 0;
    /// An edge on the pin sets GO.
    pub const EXTERNAL_EDGE: u8 = 1;
    /// GO follows the pin.
    pub const EXTERNAL_LEVEL: u8 = 2;
    /// A PWM or analog signal on the pin.
    pub const PWM_ANALOG: u8 = 3;
    /// Audio on the pin.
    pub const AUDIO: u8 = 4;
    /// The level in RTP_INPUT.
    pub const REAL_TIME: u8 = 5;
    /// GO looks for an open or shorted actuator.
    pub const DIAGNOSE: u8 = 6;
    /// GO calibrates.
    pub const CALIBRATE: u8 = 7;
}

/// Bits of the feedback control register.
pub mod feedback {
    /// An LRA; otherwise an ERM.
    pub const LRA: u8 = 0x80;
    /// FB_BRAKE_FACTOR, three bits from bit 4: 4x.
    pub const BRAKE_4X: u8 = 0x30;
    /// LOOP_GAIN, two bits from bit 2: medium.
    pub const GAIN_MEDIUM: u8 = 0x04;
    /// BEMF_GAIN, two bits: 15x for an LRA, 1.365x for an ERM.
    pub const BEMF_DEFAULT: u8 = 0x02;
    /// Brake factors by FB_BRAKE_FACTOR; 0 disables braking.
    pub const BRAKES: [u8; 8] = [1, 2, 3, 4, 6, 8, 16, 0];
}

/// Bits of control registers 1 to 5.
pub mod control {
    /// Control 1: STARTUP_BOOST.
    pub const STARTUP_BOOST: u8 = 0x80;
    /// Control 1: DRIVE_TIME, five bits.
    pub const DRIVE_TIME: u8 = 0x1F;
    /// Control 2: BIDIR_INPUT, levels below the middle brake.
    pub const BIDIR_INPUT: u8 = 0x80;
    /// Control 3: ERM_OPEN_LOOP.
    pub const ERM_OPEN_LOOP: u8 = 0x20;
    /// Control 3: DATA_FORMAT_RTP, unsigned levels.
    pub const RTP_UNSIGNED: u8 = 0x08;
    /// Control 3: LRA_OPEN_LOOP.
    pub const LRA_OPEN_LOOP: u8 = 0x01;
    /// Control 3: NG_THRESH at 2 %.
    pub const NOISE_GATE_2: u8 = 0x40;
    /// Control 5: LRA_AUTO_OPEN_LOOP.
    pub const AUTO_OPEN_LOOP: u8 = 0x20;
    /// Control 5: PLAYBACK_INTERVAL of 1 ms; otherwise 5 ms.
    pub const INTERVAL_1_MS: u8 = 0x10;
}

/// Shortest times of a calibration by AUTO_CAL_TIME, ms; the longest are 200 ms more.
pub const CALIBRATION_MS: [u16; 4] = [150, 250, 500, 1000];
/// Step of LRA_PERIOD and OL_LRA_PERIOD, us.
pub const PERIOD_STEP_US: f64 = 98.46;
/// Full scale of A_CAL_BEMF before BEMF_GAIN, V.
const BEMF_FULL_SCALE: f64 = 1.22;
/// BEMF_GAIN of an LRA.
const LRA_GAIN: [f64; 4] = [3.75, 7.5, 15.0, 22.5];
/// BEMF_GAIN of an ERM.
const ERM_GAIN: [f64; 4] = [0.255, 0.7875, 1.365, 3.0];

/// Step of RATED_VOLTAGE for an LRA in a closed loop, V RMS at the actuator: it depends on SAMPLE_TIME and the resonance,
/// since nothing drives the coil while its back-EMF is measured.
pub fn rated_step_lra(control2: u8, resonance_hz: f64) -> f64 {
    let sample_s = 150e-6 + 50e-6 * f64::from(control2 >> 4 & 3);
    let driven = 1.0 - (4.0 * sample_s + 300e-6) * resonance_hz;
    20.58e-3 / libm::sqrt(driven.max(0.01))
}

/// Step of RATED_VOLTAGE for an ERM in a closed loop, V.
pub const RATED_STEP_ERM: f64 = 21.18e-3;
/// Step of OD_CLAMP for an LRA in a closed loop, V peak.
pub const CLAMP_STEP_LRA: f64 = 21.22e-3;
/// Step of OD_CLAMP for an ERM in an open loop, V.
pub const CLAMP_STEP_ERM_OPEN: f64 = 21.59e-3;

/// Step of OD_CLAMP for an LRA in an open loop, V RMS.
pub fn clamp_step_lra_open(frequency_hz: f64) -> f64 {
    21.32e-3 * libm::sqrt((1.0 - 800e-6 * frequency_hz).max(0.01))
}

/// Step of OD_CLAMP for an ERM in a closed loop, V: nothing drives it in IDISS_TIME and BLANKING_TIME.
pub fn clamp_step_erm(control1: u8, control2: u8) -> f64 {
    const TIMES_US: [f64; 4] = [45.0, 75.0, 150.0, 225.0];
    let drive = drive_time_us(control1, false);
    let idle = TIMES_US[usize::from(control2 >> 2 & 3)] + TIMES_US[usize::from(control2 & 3)];
    21.64e-3 * (drive - 300.0) / (drive + idle)
}

/// The code of a voltage in steps, rounded to the nearest; `None` for zero and below, and beyond 8 bits.
pub fn code(volts: f64, step: f64) -> Option<u8> {
    let code = libm::round(volts / step);
    (1.0..=255.0).contains(&code).then_some(code as u8)
}

/// Drive time of a control 1 register, us: half the period of an LRA, the time between two measurements of an ERM.
pub fn drive_time_us(control1: u8, lra: bool) -> f64 {
    let field = f64::from(control1 & control::DRIVE_TIME);
    if lra {
        500.0 + 100.0 * field
    } else {
        1000.0 + 200.0 * field
    }
}

/// DRIVE_TIME for an LRA: half of its period, at most 3.6 ms.
pub fn drive_time_lra(resonance_hz: f64) -> u8 {
    libm::round((0.5e6 / resonance_hz - 500.0) / 100.0).clamp(0.0, 31.0) as u8
}

/// The period of an LRA in steps of [`PERIOD_STEP_US`], at most 255.
pub fn period_code(frequency_hz: f64) -> u8 {
    libm::round(1e6 / frequency_hz / PERIOD_STEP_US).clamp(0.0, 255.0) as u8
}

/// Frequency of a period in steps, Hz; `None` for a period that was not measured.
pub fn frequency_hz(code: u8) -> Option<f64> {
    (code != 0).then(|| 1e6 / (f64::from(code) * PERIOD_STEP_US))
}

/// Voltage of one step of A_CAL_BEMF, V of back-EMF, by the feedback control register.
pub fn bemf_step(feedback: u8) -> f64 {
    let gains = if feedback & feedback::LRA != 0 {
        LRA_GAIN
    } else {
        ERM_GAIN
    };
    BEMF_FULL_SCALE / 255.0 / gains[usize::from(feedback & 3)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The example of TI's forum: a C10-100 of 2 V RMS at 175 Hz.
    #[test]
    fn a_rated_voltage_of_2_v_at_175_hz_is_0x53() {
        assert_eq!(code(2.0, rated_step_lra(0xF5, 175.0)), Some(0x53));
    }

    #[test]
    fn voltages_of_zero_and_beyond_8_bits_have_no_code() {
        assert_eq!(code(0.0, CLAMP_STEP_LRA), None);
        assert_eq!(code(5.5, CLAMP_STEP_LRA), None);
        assert_eq!(code(CLAMP_STEP_LRA, CLAMP_STEP_LRA), Some(1));
    }

    #[test]
    fn times_and_periods_convert_both_ways() {
        let time = drive_time_lra(175.0);
        assert_eq!((time, drive_time_us(time, true)), (24, 2900.0));
        let back = frequency_hz(period_code(175.0)).unwrap();
        assert!((back - 175.0).abs() < 1.5, "{back}");
        assert_eq!(frequency_hz(0), None);
    }
}
