//! A Peltier module on a fingertip: its two faces, the sink, the bridge that feeds it, the thermistors that watch it and
//! the thermostat that no program switches.
//!
//! One body a node: the face on the skin, the sink, and a lag for each thermistor. A step of a millisecond is solved by the
//! classical Runge-Kutta rule; the fastest time constant is that of a thermistor, 0.3 s.

mod bridge;
mod handle;
mod sensor;

pub use handle::PeltierHandle;

use core::convert::Infallible;

use palpate_core::driver::Actuators;
use palpate_core::peltier::{GuardedCurrent, LIMITS, Reading, SensorFault};
use palpate_core::physics::{PeltierParameters, Thermistor, ZERO_CELSIUS_K};
use palpate_core::units::{Duration, Instant};

use crate::time::Nanos;
use bridge::Bridge;
use sensor::Converter;

/// Step of the integration.
const STEP: Nanos = Nanos::from_micros(1000);
/// Step of the integration, s.
const STEP_S: f64 = 1e-3;
/// The body behind the skin, and a face before anything flows, degrees C.
const BODY_C: f64 = 33.0;

/// State of the module at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModuleState {
    /// The face on the skin, degrees C.
    pub face_c: f64,
    /// The sink, degrees C.
    pub sink_c: f64,
    /// Current through the module, mA; positive cools the face.
    pub milliamps: i32,
}

/// The worst of a run until now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeltierPeaks {
    /// Coldest and warmest face, degrees C.
    pub face_c: [f64; 2],
    /// Warmest sink, degrees C.
    pub sink_c: f64,
    /// Fastest change of the face over a tenth of a second, K/s.
    pub ramp_k_s: f64,
    /// Most current that heated and that cooled, mA.
    pub milliamps: [i32; 2],
    /// Electrical energy, J.
    pub electrical_j: f64,
}

/// Heat pumped out of the face, W.
fn pumped_w(of: &PeltierParameters, face_c: f64, sink_c: f64, amps: f64) -> f64 {
    of.seebeck_v_k * (face_c + ZERO_CELSIUS_K) * amps
        - amps * amps * of.resistance_ohm / 2.0
        - of.conductance_w_k * (sink_c - face_c)
}

/// Electrical power into the module, W.
pub fn electrical_w(of: &PeltierParameters, face_c: f64, sink_c: f64, amps: f64) -> f64 {
    amps * amps * of.resistance_ohm + of.seebeck_v_k * amps * (sink_c - face_c)
}

/// Temperatures of all nodes, degrees C: face, sink, and both thermistors.
type Nodes = [f64; 4];

/// An emulated module.
#[derive(Clone, Debug)]
pub struct Peltier {
    parameters: PeltierParameters,
    /// Air at the sink, degrees C.
    air_c: f64,
    nodes: Nodes,
    bridge: Bridge,
    converter: Converter,
    /// The thermostat has cut the bridge; it stays open.
    is_cut: bool,
    now: Nanos,
    peaks: PeltierPeaks,
    /// The face at the last hundred steps, degrees C.
    course: std::collections::VecDeque<f64>,
}

impl Peltier {
    /// A module whose face rests on skin, in air of this temperature.
    pub fn new(parameters: PeltierParameters, thermistor: Thermistor, air_c: f64) -> Self {
        let mut converter = Converter::new(thermistor);
        converter.take(Nanos::ZERO, [BODY_C, air_c]);
        Self {
            parameters,
            air_c,
            nodes: [BODY_C, air_c, BODY_C, air_c],
            bridge: Bridge::default(),
            converter,
            is_cut: false,
            now: Nanos::ZERO,
            peaks: PeltierPeaks {
                face_c: [BODY_C; 2],
                sink_c: air_c,
                ramp_k_s: 0.0,
                milliamps: [0; 2],
                electrical_j: 0.0,
            },
            course: std::collections::VecDeque::with_capacity(RAMP_STEPS),
        }
    }

    /// Lets time pass until `to`, in whole steps.
    pub fn advance(&mut self, to: Nanos) {
        while self.now + STEP <= to {
            self.step();
        }
    }

    fn step(&mut self) {
        let milliamps = match self.is_cut {
            true => 0,
            false => self.bridge.milliamps(self.now),
        };
        let amps = f64::from(milliamps) * 1e-3;
        let [face_c, sink_c, ..] = self.nodes;
        self.peaks.electrical_j +=
            electrical_w(&self.parameters, face_c, sink_c, amps).max(0.0) * STEP_S;
        self.nodes = self.after(amps);
        self.now = self.now + STEP;
        let [face_c, sink_c, face_read_c, sink_read_c] = self.nodes;
        self.converter.take(self.now, [face_read_c, sink_read_c]);
        self.is_cut |= face_c >= LIMITS.thermostat_c;
        let peaks = &mut self.peaks;
        peaks.face_c = [peaks.face_c[0].min(face_c), peaks.face_c[1].max(face_c)];
        peaks.sink_c = peaks.sink_c.max(sink_c);
        peaks.milliamps = [
            peaks.milliamps[0].max(-milliamps),
            peaks.milliamps[1].max(milliamps),
        ];
        if self.course.len() == RAMP_STEPS
            && let Some(before_c) = self.course.pop_front()
        {
            let ramp = (face_c - before_c).abs() / (RAMP_STEPS as f64 * STEP_S);
            peaks.ramp_k_s = peaks.ramp_k_s.max(ramp);
        }
        self.course.push_back(face_c);
    }

    /// Temperatures of all nodes a step later.
    fn after(&self, amps: f64) -> Nodes {
        let at = |slope: &Nodes, s: f64| -> Nodes {
            core::array::from_fn(|i| self.nodes[i] + slope[i] * s)
        };
        let first = self.rate(&self.nodes, amps);
        let second = self.rate(&at(&first, STEP_S / 2.0), amps);
        let third = self.rate(&at(&second, STEP_S / 2.0), amps);
        let last = self.rate(&at(&third, STEP_S), amps);
        core::array::from_fn(|i| {
            let slopes = first[i] + 2.0 * second[i] + 2.0 * third[i] + last[i];
            self.nodes[i] + slopes * STEP_S / 6.0
        })
    }

    /// Rate of each node's temperature, K/s.
    fn rate(&self, &[face_c, sink_c, face_read_c, sink_read_c]: &Nodes, amps: f64) -> Nodes {
        let p = &self.parameters;
        let pumped_w = pumped_w(p, face_c, sink_c, amps);
        let skin_w = p.skin_w_k * (face_c - BODY_C);
        let to_sink_w = pumped_w + electrical_w(p, face_c, sink_c, amps);
        let to_air_w = (sink_c - self.air_c) / p.sink_k_w;
        [
            (-pumped_w - skin_w) / p.face_j_k,
            (to_sink_w - to_air_w) / p.sink_j_k,
            (face_c - face_read_c) / p.sensor_s,
            (sink_c - sink_read_c) / p.sensor_s,
        ]
    }

    /// The newest conversion of both thermistors.
    pub const fn reading(&self) -> Reading {
        self.converter.reading()
    }

    /// Takes what the bridge's lines say, without a proof of a guard: this current, mA, for this length, and then none.
    /// It is for firmware, whose guard stands in front of its pins.
    pub fn receive(&mut self, milliamps: i32, length: Duration) {
        self.bridge.set(self.now, milliamps, length);
    }

    /// State of the module now.
    pub fn state(&self) -> ModuleState {
        let milliamps = match self.is_cut {
            true => 0,
            false => self.bridge.milliamps(self.now),
        };
        ModuleState {
            face_c: self.nodes[0],
            sink_c: self.nodes[1],
            milliamps,
        }
    }

    /// The worst until now.
    pub const fn peaks(&self) -> &PeltierPeaks {
        &self.peaks
    }

    /// Tells whether the thermostat has cut the bridge.
    pub const fn is_cut(&self) -> bool {
        self.is_cut
    }

    /// Breaks or repairs the face's thermistor.
    pub const fn set_sensor(&mut self, defect: Option<SensorFault>) {
        self.converter.defect = defect;
    }

    /// A transistor of the bridge is shorted, so that it heats with all that its supply gives, or is repaired.
    pub const fn set_shorted(&mut self, shorted: bool) {
        self.bridge.shorted = shorted;
    }
}

/// Steps over which a ramp is measured: a tenth of a second.
const RAMP_STEPS: usize = 100;

impl Actuators<GuardedCurrent> for Peltier {
    type Error = Infallible;

    fn apply(&mut self, update: &GuardedCurrent) -> Result<(), Infallible> {
        self.receive(update.milliamps(), update.until().since(update.at()));
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        self.bridge.off();
        Ok(())
    }
}

/// The time of a step, as core counts it.
const fn instant(at: Nanos) -> Instant {
    Instant::from_micros(at.0 / 1000)
}

/// Time between two conversions of the thermistors.
const CONVERSION: Duration = Duration::from_millis(5);

#[cfg(test)]
mod tests;
