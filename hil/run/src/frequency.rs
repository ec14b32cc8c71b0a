//! Frequency response of a bench's wire: one pulse per period at one mean power, as a vibrometer shows it first.

use core::f64::consts::TAU;

use palpate_emulators::display::solver::stretch::Stretch;
use palpate_emulators::display::wire::Wire;
use palpate_emulators::person::channels::{Levels, Perceiver, sine_threshold_um};
use palpate_emulators::time::Nanos;
use palpate_files::Setup;

use crate::failure::Failure;
use crate::plan;

/// Mean electrical power at every frequency, W: half of what the limit table leaves a wire.
pub const RESPONSE_W: f64 = 0.01;
/// Time until wire and tissue have got warm, s.
const WARM_S: f64 = 8.0;
/// Time for which a person has felt the pulses when it is measured, and shortest time of a measurement, s.
const FELT_S: f64 = 1.0;
const MEASURED_S: f64 = 0.5;
/// Lowest frequency: a pulse every ten seconds.
const LEAST_HZ: f64 = 0.1;
/// Fewest periods of a measurement.
const PERIODS: u64 = 10;

/// Motion of the skin under one wire at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResponsePoint {
    /// Pulses per second.
    pub hz: f64,
    /// Width of a pulse, s.
    pub width_s: f64,
    /// Displacement of the skin from end to end, um.
    pub swing_um: f64,
    /// Amplitude of its part at this frequency, um.
    pub amplitude_um: f64,
    /// Amplitude of a long sine at this frequency that the person just feels, um.
    pub threshold_um: f64,
    /// Levels of the person over threshold, with all harmonics.
    pub levels: Levels,
    /// Hottest wire, degrees C.
    pub wire_c: f64,
}

/// Frequencies from `low` to `high` Hz, evenly in their logarithm; none for ends that are no frequencies in order.
pub fn frequencies(low: f64, high: f64, count: usize) -> Vec<f64> {
    if !(low > 0.0 && high >= low && high.is_finite()) {
        return Vec::new();
    }
    let step = libm::log(high / low) / count.saturating_sub(1).max(1) as f64;
    (0..count)
        .map(|n| low * libm::exp(step * n as f64))
        .collect()
}

/// Responses of a setup's wire, felt by its person, at these frequencies.
///
/// # Errors
/// [`Failure::Input`] for a wire or person that cannot be, and a frequency at which the current would never pause.
pub fn frequency_response(setup: &Setup, hz: &[f64]) -> Result<Vec<ResponsePoint>, Failure> {
    let instead = "a motor shakes at its own frequency; `hil run` and `hil sweep` show its level";
    plan::wires_only(&setup.bench, instead)?;
    hz.iter().map(|&hz| point(setup, hz)).collect()
}

/// Pulses at one frequency.
struct Train {
    amps: f64,
    period_ns: u64,
    width_ns: u64,
    /// Pulses so far.
    count: u64,
}

impl Train {
    fn new(setup: &Setup, hz: f64) -> Result<Self, Failure> {
        let bench = &setup.bench.value;
        let amps = bench.drive.current_ma * 1e-3;
        let watts = amps * amps * plan::wire(setup).resistance_ohm;
        let period_ns = libm::round(1e9 / hz) as u64;
        let width_ns = libm::round(RESPONSE_W / watts * period_ns as f64) as u64;
        if !(hz >= LEAST_HZ && (1..period_ns).contains(&width_ns)) {
            return Err(Failure::Input(format!(
                "bench `{}`: expected a frequency and a current whose pulses give {:.0} mW and pause, found {hz} Hz and {watts:.3} W while on",
                bench.name,
                RESPONSE_W * 1e3
            )));
        }
        Ok(Self {
            amps,
            period_ns,
            width_ns,
            count: 0,
        })
    }

    /// Periods of at least this time.
    fn periods(&self, seconds: f64) -> u64 {
        libm::ceil(seconds * 1e9 / self.period_ns as f64) as u64
    }

    /// Drives a wire for so many periods, and hands its stretches on.
    fn drive(&mut self, wire: &mut Wire, periods: u64, mut with: impl FnMut(&Stretch)) {
        for _ in 0..periods {
            let at = self.count * self.period_ns;
            wire.set_current(Nanos(at), self.amps);
            wire.set_current(Nanos(at + self.width_ns), 0.0);
            self.count += 1;
            wire.take_stretches(Nanos(self.count * self.period_ns), &mut with);
        }
    }
}

fn point(setup: &Setup, hz: f64) -> Result<ResponsePoint, Failure> {
    let person = plan::emulated_person(setup);
    let mut perceiver = Perceiver::new(person, &[(0.0, 0.0)])
        .map_err(|e| Failure::Input(format!("person `{}`: {e}", setup.person.value.name)))?;
    let (mut wire, mut train) = (plan::felt_wire(setup)?, Train::new(setup, hz)?);
    train.drive(&mut wire, train.periods(WARM_S), |_| {});
    let felt = train.periods(FELT_S);
    train.drive(&mut wire, felt, |stretch| perceiver.pass(0, stretch));
    perceiver.settle();
    perceiver.onset();
    let periods = train.periods(MEASURED_S).max(PERIODS);
    let mut tone = Tone::new(1e9 / train.period_ns as f64);
    train.drive(&mut wire, periods, |stretch| {
        perceiver.pass(0, stretch);
        tone.pass(stretch);
    });
    perceiver.settle();
    let felt = perceiver.felt(setup.bench.value.tissue.rest_c);
    Ok(ResponsePoint {
        hz,
        width_s: train.width_ns as f64 * 1e-9,
        swing_um: felt.map_or(0.0, |felt| felt.skin_um),
        amplitude_um: tone.amplitude_um(),
        threshold_um: sine_threshold_um(&person, hz),
        levels: felt.map_or(Levels::SILENT, |felt| felt.levels),
        wire_c: wire.peaks(wire.now()).wire_c,
    })
}

/// Part of a displacement at one frequency, over a whole number of periods. Each term of the displacement's rate has a
/// closed form.
struct Tone {
    omega: f64,
    seconds: f64,
    /// Integral of the rate times exp(-i omega t), um.
    sum: [f64; 2],
    /// Displacement at the end from that at the start, um.
    drift_um: f64,
}

impl Tone {
    fn new(hz: f64) -> Self {
        Self {
            omega: TAU * hz,
            seconds: 0.0,
            sum: [0.0; 2],
            drift_um: 0.0,
        }
    }

    fn pass(&mut self, stretch: &Stretch) {
        let (omega, length) = (self.omega, stretch.seconds);
        let turned = |t: f64| libm::sincos(-omega * t);
        let ((sin, cos), (end_sin, end_cos)) = (turned(self.seconds), turned(length));
        for (rate, slope) in stretch.rates.iter().zip(stretch.slopes) {
            let um_per_s = slope * stretch.um_per_k;
            if um_per_s == 0.0 {
                continue;
            }
            // (1 - e^(-(r + i w) T)) / (r + i w), then turned by where the stretch begins.
            let fallen = libm::exp(-rate * length);
            let [a, b] = [1.0 - fallen * end_cos, -fallen * end_sin];
            let square = rate * rate + omega * omega;
            let [re, im] = [
                (a * rate + b * omega) / square,
                (b * rate - a * omega) / square,
            ];
            self.sum[0] += um_per_s * (re * cos - im * sin);
            self.sum[1] += um_per_s * (re * sin + im * cos);
            self.drift_um += um_per_s
                * match *rate == 0.0 {
                    true => length,
                    false => -libm::expm1(-rate * length) / rate,
                };
        }
        self.seconds += length;
    }

    /// Amplitude, um: the integral by parts, without the drift over the whole time.
    fn amplitude_um(&self) -> f64 {
        if self.seconds == 0.0 {
            return 0.0;
        }
        let [re, im] = self.sum;
        2.0 * libm::hypot(re - self.drift_um, im) / (self.omega * self.seconds)
    }
}

#[cfg(test)]
#[path = "frequency_tests.rs"]
mod tests;
