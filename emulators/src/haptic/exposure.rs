//! Exposure of a hand to vibration, by the measure of ISO 5349-1, against the values of Directive 2002/44/EC.

use core::f64::consts::{SQRT_2, TAU};

/// Daily exposure from which an employer has to act, m/s2 over eight hours (Directive 2002/44/EC, article 3).
pub const ACTION_M_S2: f64 = 2.5;
/// Length of the day that exposures are related to, s.
const DAY_S: f64 = 8.0 * 3600.0;

/// Weight W_h of ISO 5349-1 (annex A) for an acceleration of this frequency, 1.
pub fn weight(hz: f64) -> f64 {
    // Squared gain of a Butterworth filter of second order is 1 / (1 + x^4), nearly, with Q = 0.71.
    let second = |x: f64, q: f64| libm::hypot(1.0 - x * x, x / q);
    let high = hz / 6.310;
    let low = hz / 1258.9;
    let band = high * high / second(high, 0.71) / second(low, 0.71);
    let x = hz / 15.915;
    band * libm::hypot(1.0, x) / second(x, 0.64)
}

/// Exposure of one hand so far: motors add up as if each shook all of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exposure {
    /// Integral of the squared weighted acceleration, m2/s3.
    squares: f64,
}

impl Exposure {
    /// Adds a sine of this amplitude, m, over a time.
    pub fn add(&mut self, amplitude_m: f64, hz: f64, seconds: f64) {
        let omega = TAU * hz;
        let rms = weight(hz) * amplitude_m * omega * omega / SQRT_2;
        self.squares += rms * rms * seconds;
    }

    /// Daily exposure A(8) if nothing else shook the hand that day, m/s2.
    pub fn daily_m_s2(&self) -> f64 {
        libm::sqrt(self.squares / DAY_S)
    }

    /// Time until the action value, s, by repeating these `seconds`; infinite for a hand at rest.
    pub fn until_action_s(&self, seconds: f64) -> f64 {
        ACTION_M_S2 * ACTION_M_S2 * DAY_S / self.squares * seconds
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of table A.2 of ISO 5349-1.
    #[test]
    fn weights_are_those_of_the_standards_table() {
        let table = [
            (8.0, 0.873),
            (16.0, 0.896),
            (31.5, 0.519),
            (63.0, 0.256),
            (125.0, 0.127),
            (250.0, 0.0634),
            (500.0, 0.0314),
            (1000.0, 0.0135),
        ];
        for (hz, listed) in table {
            let found = weight(hz);
            assert!(
                (found / listed - 1.0).abs() < 0.05,
                "{hz} Hz: {found} {listed}"
            );
        }
    }

    #[test]
    fn eight_hours_of_a_steady_sine_give_its_weighted_acceleration() {
        let mut hand = Exposure::default();
        hand.add(100e-6, 175.0, DAY_S);
        let rms = 100e-6 * (TAU * 175.0) * (TAU * 175.0) / SQRT_2 * weight(175.0);
        assert!((hand.daily_m_s2() / rms - 1.0).abs() < 1e-12);
        // A quarter of the time gives half of it.
        let mut short = Exposure::default();
        short.add(100e-6, 175.0, DAY_S / 4.0);
        assert!((short.daily_m_s2() / rms - 0.5).abs() < 1e-12);
        let until = short.until_action_s(DAY_S / 4.0);
        assert!((until / (DAY_S * (ACTION_M_S2 / rms) * (ACTION_M_S2 / rms)) - 1.0).abs() < 1e-12);
        assert!(Exposure::default().until_action_s(1.0).is_infinite());
    }
}
