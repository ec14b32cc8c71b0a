//! Thermistors: a converter's code becomes a temperature, or the sensor's defect.

use crate::listed::listed;
use crate::physics::{Thermistor, ZERO_CELSIUS_K};

/// Codes above this are of no thermistor colder than -15 degrees C: the lead is open.
const OPEN_ABOVE: u16 = 3700;
/// Codes below this are of none hotter than 80 degrees C: the leads touch.
const SHORT_BELOW: u16 = 400;

listed! {
    /// Reasons for which a thermistor tells no temperature.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
    #[non_exhaustive]
    pub enum SensorFault: word {
        /// A lead is broken.
        #[error("thermistor: a lead is broken")]
        Open = "sensor-open",
        /// The leads touch.
        #[error("thermistor: the leads touch")]
        Short = "sensor-short",
        /// No conversion has come for too long.
        #[error("thermistor: no conversion has come for too long")]
        Stale = "sensor-stale",
    }
}

/// The temperature of a code, degrees C.
///
/// # Errors
/// An open or a shorted sensor.
pub(super) fn celsius(thermistor: &Thermistor, code: u16) -> Result<f64, SensorFault> {
    if code > OPEN_ABOVE {
        return Err(SensorFault::Open);
    }
    if code < SHORT_BELOW {
        return Err(SensorFault::Short);
    }
    let part = f64::from(code) / f64::from(Thermistor::FULL_SCALE);
    let ohm = thermistor.series_ohm * part / (1.0 - part);
    let inverse_k = 1.0 / (Thermistor::NOMINAL_C + ZERO_CELSIUS_K)
        + libm::log(ohm / thermistor.nominal_ohm) / thermistor.beta_k;
    Ok(1.0 / inverse_k - ZERO_CELSIUS_K)
}
