//! A converter of 12 bits on two thermistors, one in the face and one in the sink.

use palpate_core::peltier::{Reading, SensorFault};
use palpate_core::physics::{Thermistor, ZERO_CELSIUS_K};
use palpate_core::units::Instant;

use super::{CONVERSION, instant};
use crate::time::Nanos;

/// The converter and what it told last.
#[derive(Clone, Debug)]
pub(super) struct Converter {
    thermistor: Thermistor,
    newest: Reading,
    /// A defect of the face's thermistor.
    pub(super) defect: Option<SensorFault>,
}

impl Converter {
    pub(super) const fn new(thermistor: Thermistor) -> Self {
        Self {
            thermistor,
            // Before the first conversion its registers are zero: a short.
            newest: Reading {
                at: Instant::ZERO,
                face: 0,
                sink: 0,
            },
            defect: None,
        }
    }

    pub(super) const fn reading(&self) -> Reading {
        self.newest
    }

    /// Converts at `now`, where that is due, what both thermistors are at, degrees C.
    pub(super) fn take(&mut self, now: Nanos, [face_c, sink_c]: [f64; 2]) {
        let at = instant(now);
        let due = at.as_micros().is_multiple_of(CONVERSION.as_micros());
        if !due || self.defect == Some(SensorFault::Stale) {
            return;
        }
        let face = match self.defect {
            Some(SensorFault::Open) => Thermistor::FULL_SCALE,
            Some(SensorFault::Short) => 0,
            _ => self.code(face_c),
        };
        self.newest = Reading {
            at,
            face,
            sink: self.code(sink_c),
        };
    }

    /// The code of a temperature, degrees C.
    fn code(&self, celsius: f64) -> u16 {
        let t = &self.thermistor;
        let inverse_k = 1.0 / (celsius + ZERO_CELSIUS_K);
        let nominal_k = 1.0 / (Thermistor::NOMINAL_C + ZERO_CELSIUS_K);
        let ohm = t.nominal_ohm * libm::exp(t.beta_k * (inverse_k - nominal_k));
        let part = ohm / (ohm + t.series_ohm);
        libm::round(f64::from(Thermistor::FULL_SCALE) * part) as u16
    }
}
