//! Registers of a DRV2605L (TI data sheet SLOS854, register map).

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

/// Bits of each register that a write changes.
pub const WRITABLE: [u8; COUNT] = [
    0x00, 0xC7, 0xFF, 0x17, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x01, 0xFF, 0xFF, 0xFF,
    0xFF, 0x0F, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xBF, 0xFF, 0xFF, 0xF1, 0xFF,
    0x7F, 0x00, 0x00,
];

/// Settings as their registers state them.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a>(pub &'a [u8; COUNT]);

impl Settings<'_> {
    const fn of(self, register: u8) -> u8 {
        self.0[register as usize]
    }

    /// True for a linear resonant actuator, false for an eccentric rotating mass.
    pub const fn is_lra(self) -> bool {
        self.of(FEEDBACK) & 0x80 != 0
    }

    /// True where the motor is driven without feedback.
    pub const fn is_open_loop(self) -> bool {
        let bit = if self.is_lra() { 0x01 } else { 0x20 };
        self.of(CONTROL3) & bit != 0
    }

    /// Half a period that a resonant actuator is expected to have, or time between two looks at a rotating one, s.
    pub fn drive_s(self) -> f64 {
        let steps = f64::from(self.of(CONTROL1) & 0x1F);
        match self.is_lra() {
            true => 0.5e-3 + 0.1e-3 * steps,
            false => 1e-3 + 0.2e-3 * steps,
        }
    }

    /// Peak voltage of full drive in a closed loop, V. `hz` is the resonance of an actuator.
    pub fn rated_v(self, hz: f64) -> f64 {
        let code = f64::from(self.of(RATED_VOLTAGE));
        if !self.is_lra() {
            return 21.18e-3 * code;
        }
        let sample = [150e-6, 200e-6, 250e-6, 300e-6][usize::from(self.of(CONTROL2) >> 4 & 3)];
        let share = 1.0 - (4.0 * sample + 300e-6) * hz;
        // The data sheet's formula gives the root mean square.
        core::f64::consts::SQRT_2 * 20.58e-3 * code / libm::sqrt(share.max(0.05))
    }

    /// Peak voltage of overdrive and brake in a closed loop, and of full drive in an open loop, V.
    pub fn clamp_v(self) -> f64 {
        let per_code = match (self.is_lra(), self.is_open_loop()) {
            (true, _) => 21.22e-3,
            (false, true) => 21.59e-3,
            (false, false) => 21.64e-3,
        };
        per_code * f64::from(self.of(OD_CLAMP))
    }

    /// Gains of the back-EMF, by their setting.
    pub const fn emf_gains(self) -> [f64; 4] {
        match self.is_lra() {
            true => [3.75, 7.5, 15.0, 22.5],
            false => [0.255, 0.7875, 1.365, 3.0],
        }
    }

    /// Amplitude of the back-EMF that a closed loop takes for full drive, V.
    pub fn full_emf_v(self) -> f64 {
        let gain = self.emf_gains()[usize::from(self.of(FEEDBACK) & 3)];
        f64::from(self.of(A_CAL_BEMF)) / EMF_PER_V / gain
    }

    /// Drive that a value of real-time playback asks for: -1 to 1 of full drive.
    pub fn asked(self, value: u8) -> f64 {
        let unsigned = self.of(CONTROL3) & 0x08 != 0;
        // Bidirectional data count in a closed loop only; an open loop always takes both signs.
        let both = self.of(CONTROL2) & 0x80 != 0 || self.is_open_loop();
        match (unsigned, both) {
            (true, true) => (f64::from(value) - 128.0) / 127.0,
            (true, false) => f64::from(value) / 255.0,
            (false, true) => f64::from(value.cast_signed()) / 127.0,
            (false, false) => f64::from(value.cast_signed().max(0)) / 127.0,
        }
        .clamp(-1.0, 1.0)
    }

    /// Gain of a closed loop: volts per volt of missing back-EMF, as shares of full drive. Assumed: the data sheet only
    /// orders them.
    pub fn loop_gain(self) -> f64 {
        [1.0, 2.0, 4.0, 8.0][usize::from(self.of(FEEDBACK) >> 2 & 3)]
    }

    /// Brake over drive in a closed loop; 0 where the brake is off.
    pub fn brake(self) -> f64 {
        [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 16.0, 0.0][usize::from(self.of(FEEDBACK) >> 4 & 7)]
    }

    /// Length of a calibration, s: the middle of what the data sheet states.
    pub fn calibration_s(self) -> f64 {
        [0.25, 0.35, 0.6, 1.1][usize::from(self.of(CONTROL4) >> 4 & 3)]
    }

    /// Frequency of a resonant actuator without feedback, Hz.
    pub fn open_hz(self) -> f64 {
        let period = f64::from(self.of(OPEN_PERIOD).max(1)) * PERIOD_S;
        1.0 / period
    }
}
