//! Haptic drivers and motors: DRV2605L chips, alone or behind a TCA9548A multiplexer, with the motors that they drive, and
//! voice coils on the channels of a sound card.
//!
//! [`I2cSegment::with_haptics`](crate::display::i2c::I2cSegment::with_haptics) puts them on a bus. Every chip owns its
//! motor: time that passes for the chip moves the mass and warms the coil.

pub mod card;
pub mod contact;
pub mod drv2605;
pub mod erm;
pub mod exposure;
pub mod lra;
pub mod tca9548a;
pub mod voice_coil;

use erm::Erm;
use lra::Lra;

/// Output of a driver over a stretch of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drive {
    /// No current path: the motor coasts.
    Open,
    /// A steady voltage; 0 shorts the motor, which brakes it.
    Steady(f64),
    /// `peak` cos(`omega` t + `phase`), V, with t from the beginning of the stretch.
    Wave {
        /// Amplitude, V.
        peak: f64,
        /// Angular frequency, rad/s.
        omega: f64,
        /// Phase at the beginning of the stretch, rad.
        phase: f64,
    },
}

impl Drive {
    /// Voltage `t` seconds into the stretch.
    pub fn volts(&self, t: f64) -> f64 {
        match *self {
            Self::Open => 0.0,
            Self::Steady(volts) => volts,
            Self::Wave { peak, omega, phase } => peak * libm::cos(omega * t + phase),
        }
    }
}

/// Fault of a motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MotorFault {
    /// The coil or a lead is broken: no current flows.
    Open,
    /// The leads touch: the driver sees too large a current.
    Short,
    /// The mass is jammed: current flows and nothing moves.
    Stuck,
}

/// A motor at the output of a driver.
#[derive(Clone, Debug, PartialEq)]
pub enum Motor {
    /// A linear resonant actuator.
    Lra(Lra),
    /// An eccentric rotating mass.
    Erm(Erm),
}

impl Motor {
    /// Lets `seconds` pass under a drive.
    pub fn pass(&mut self, drive: &Drive, seconds: f64) {
        match self {
            Self::Lra(lra) => lra.pass(drive, seconds),
            Self::Erm(erm) => erm.pass(drive, seconds),
        }
    }

    /// Amplitude of the moving mass as it is now, m.
    pub fn amplitude_m(&self) -> f64 {
        match self {
            Self::Lra(lra) => lra.amplitude_m(),
            Self::Erm(erm) => erm.amplitude_m(),
        }
    }

    /// Frequency of the motion as it is now, Hz.
    pub fn hz(&self) -> f64 {
        match self {
            Self::Lra(lra) => lra.parameters().resonance_hz,
            Self::Erm(erm) => erm.hz(),
        }
    }

    /// Amplitude of the back-EMF as it is now, V.
    pub fn emf(&self) -> f64 {
        match self {
            Self::Lra(lra) => lra.emf(),
            Self::Erm(erm) => erm.emf(),
        }
    }

    /// Temperature of the coil over that of the air, K.
    pub const fn coil_rise_k(&self) -> f64 {
        match self {
            Self::Lra(lra) => lra.coil.rise_k(),
            Self::Erm(erm) => erm.coil.rise_k(),
        }
    }

    /// The motor's fault; `None` of a whole one.
    pub const fn fault(&self) -> Option<MotorFault> {
        match self {
            Self::Lra(lra) => lra.fault,
            Self::Erm(erm) => erm.fault,
        }
    }

    /// The coil.
    pub const fn coil_mut(&mut self) -> &mut Coil {
        match self {
            Self::Lra(lra) => &mut lra.coil,
            Self::Erm(erm) => &mut erm.coil,
        }
    }

    /// Breaks the motor, or repairs it.
    pub const fn set_fault(&mut self, fault: Option<MotorFault>) {
        match self {
            Self::Lra(lra) => lra.fault = fault,
            Self::Erm(erm) => erm.fault = fault,
        }
    }
}

/// Rise of a covered coil over that of a free one, 1.
const COVERED: f64 = 10.0;

/// A coil that its losses warm: one heat capacity to the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coil {
    /// Resistance, ohm.
    pub ohm: f64,
    /// Rise at rest per watt of loss, K/W.
    pub kelvin_per_watt: f64,
    /// Time constant of the rise, s.
    pub warming_s: f64,
    /// Temperature of the air, degrees C.
    pub air_c: f64,
    /// Temperature of the coil, degrees C.
    pub celsius: f64,
}

impl Coil {
    /// A coil at the temperature of the air. Rises and time constants are assumed: data sheets of coin motors state none.
    pub const fn new(ohm: f64) -> Self {
        Self {
            ohm,
            kelvin_per_watt: 150.0,
            warming_s: 20.0,
            air_c: 25.0,
            celsius: 25.0,
        }
    }

    /// Covers the coil, so that it loses heat ten times worse than one that hangs free, or uncovers it.
    pub const fn set_covered(&mut self, covered: bool) {
        let free = Self::new(self.ohm).kelvin_per_watt;
        self.kelvin_per_watt = if covered { COVERED * free } else { free };
    }

    /// Temperature over that of the air, K.
    pub const fn rise_k(&self) -> f64 {
        self.celsius - self.air_c
    }

    /// Lets `seconds` pass with a mean loss, W.
    fn warm(&mut self, watts: f64, seconds: f64) {
        let end = self.air_c + self.kelvin_per_watt * watts;
        self.celsius = end + (self.celsius - end) * libm::exp(-seconds / self.warming_s);
    }
}

#[cfg(test)]
#[path = "published_tests.rs"]
mod published;
