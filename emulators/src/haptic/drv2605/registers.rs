//! Registers of a DRV2605L (TI data sheet SLOS854, register map).

pub use palpate_core::codec::drv2605::*;

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
    const fn get(self, register: u8) -> u8 {
        self.0[register as usize]
    }

    /// True for a linear resonant actuator, false for an eccentric rotating mass.
    pub const fn is_lra(self) -> bool {
        self.get(FEEDBACK) & 0x80 != 0
    }

    /// True where the motor is driven without feedback.
    pub const fn is_open_loop(self) -> bool {
        let bit = if self.is_lra() { 0x01 } else { 0x20 };
        self.get(CONTROL3) & bit != 0
    }

    /// Half a period that a resonant actuator is expected to have, or time between two looks at a rotating one, s.
    pub fn drive_s(self) -> f64 {
        let steps = f64::from(self.get(CONTROL1) & 0x1F);
        match self.is_lra() {
            true => 0.5e-3 + 0.1e-3 * steps,
            false => 1e-3 + 0.2e-3 * steps,
        }
    }

    /// Peak voltage of full drive in a closed loop, V. `hz` is the resonance of an actuator.
    pub fn rated_v(self, hz: f64) -> f64 {
        let code = f64::from(self.get(RATED_VOLTAGE));
        if !self.is_lra() {
            return 21.18e-3 * code;
        }
        let sample = [150e-6, 200e-6, 250e-6, 300e-6][usize::from(self.get(CONTROL2) >> 4 & 3)];
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
        per_code * f64::from(self.get(OD_CLAMP))
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
        let gain = self.emf_gains()[usize::from(self.get(FEEDBACK) & 3)];
        f64::from(self.get(A_CAL_BEMF)) / EMF_PER_V / gain
    }

    /// Drive that a value of real-time playback asks for: -1 to 1 of full drive.
    pub fn asked(self, value: u8) -> f64 {
        let unsigned = self.get(CONTROL3) & 0x08 != 0;
        // Bidirectional data count in a closed loop only; an open loop always takes both signs.
        let both = self.get(CONTROL2) & 0x80 != 0 || self.is_open_loop();
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
        [1.0, 2.0, 4.0, 8.0][usize::from(self.get(FEEDBACK) >> 2 & 3)]
    }

    /// Brake over drive in a closed loop; 0 where the brake is off.
    pub fn brake(self) -> f64 {
        [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 16.0, 0.0][usize::from(self.get(FEEDBACK) >> 4 & 7)]
    }

    /// Length of a calibration, s: the middle of what the data sheet states.
    pub fn calibration_s(self) -> f64 {
        [0.25, 0.35, 0.6, 1.1][usize::from(self.get(CONTROL4) >> 4 & 3)]
    }

    /// Frequency of a resonant actuator without feedback, Hz.
    pub fn open_hz(self) -> f64 {
        let period = f64::from(self.get(OPEN_PERIOD).max(1)) * PERIOD_S;
        1.0 / period
    }
}
