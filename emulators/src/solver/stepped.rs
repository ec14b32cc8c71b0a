//! Solvers to compare the exact one with, never used by the emulator: Euler, RK4, and the average over a
//! PWM period that hides what a pulse does. None of them locates phase events: where the heat capacity
//! jumps they are of first order in the step, whatever their order elsewhere.

use super::{Drive, Solver};
use crate::finger::{NODES, Network};
use crate::time::Nanos;
use crate::wire::phase::{Heading, Phase};
use palpate_core::physics::{ParameterError, SkinParameters, WireParameters};

/// How a step is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Explicit Euler.
    Euler,
    /// The classical Runge-Kutta method of order four.
    Rk4,
    /// RK4 on the mean power of each `step`: pulses are smeared.
    CycleAveraged,
}

/// A fixed-step solver that restarts at every edge (but the averaging one, which ignores them).
#[derive(Clone, Debug)]
pub struct Stepped {
    wire: WireParameters,
    network: Network,
    phase: Phase,
    heading: Heading,
    method: Method,
    step: Nanos,
    nodes: [f64; NODES],
    now: Nanos,
    drive: Drive,
    window: (Nanos, f64),
    peak: f64,
}

impl Stepped {
    /// Everything at `start_c`; `step` is the longest step, or the span averaged over. Resistance is taken as
    /// constant.
    ///
    /// # Errors
    /// A parameter that cannot be computed with, or a step of zero.
    pub fn new(
        wire: &WireParameters,
        skin: &SkinParameters,
        start_c: f64,
        method: Method,
        step: Nanos,
    ) -> Result<Self, ParameterError> {
        if step == Nanos::ZERO {
            return Err(ParameterError { name: "step" });
        }
        Ok(Self {
            wire: *wire,
            network: Network::new(wire, skin)?,
            phase: Phase::new(wire, start_c)?,
            heading: Heading::Up,
            method,
            step,
            nodes: [start_c; NODES],
            now: Nanos::ZERO,
            drive: Drive::Off,
            window: (Nanos::ZERO, 0.0),
            peak: start_c,
        })
    }

    fn watts(&self) -> f64 {
        match self.drive {
            Drive::Off => 0.0,
            Drive::Power(watts) => watts * self.wire.wire_share,
            Drive::Current(amps) => amps * amps * self.wire.resistance_ohm * self.wire.wire_share,
        }
    }

    fn rate(&self, nodes: &[f64; NODES], watts: f64) -> [f64; NODES] {
        let slope = self.phase.segment(nodes[0], self.heading).slope;
        let w = &self.wire;
        let capacity = w.mass() * (w.specific_heat - w.latent_heat * slope);
        self.network.rate(nodes, watts, capacity)
    }

    fn step_by(&mut self, watts: f64, seconds: f64) {
        let y = self.nodes;
        let k1 = self.rate(&y, watts);
        let heading = if k1[0] < 0.0 {
            Heading::Down
        } else {
            Heading::Up
        };
        if heading != self.heading {
            self.heading = heading;
            self.phase.turn(y[0], heading);
        }
        let k1 = self.rate(&y, watts);
        let along =
            |k: &[f64; NODES], part: f64| core::array::from_fn(|i| y[i] + k[i] * part * seconds);
        self.nodes = if self.method == Method::Euler {
            along(&k1, 1.0)
        } else {
            let k2 = self.rate(&along(&k1, 0.5), watts);
            let k3 = self.rate(&along(&k2, 0.5), watts);
            let k4 = self.rate(&along(&k3, 1.0), watts);
            core::array::from_fn(|i| {
                y[i] + seconds / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
            })
        };
        self.phase.commit(self.nodes[0]);
        self.peak = self.peak.max(self.nodes[0]);
    }

    /// Whole windows of mean power.
    fn average(&mut self, to: Nanos) {
        while self.now < to {
            let close = self.window.0 + self.step;
            let until = to.min(close);
            self.window.1 += self.watts() * until.since(self.now).as_secs_f64();
            self.now = until;
            if until == close {
                let seconds = self.step.as_secs_f64();
                let watts = self.window.1 / seconds;
                for _ in 0..16 {
                    self.step_by(watts, seconds / 16.0);
                }
                self.window = (close, 0.0);
            }
        }
    }
}

impl Solver for Stepped {
    fn drive(&mut self, at: Nanos, drive: Drive) {
        self.advance(at);
        self.drive = drive;
    }

    fn advance(&mut self, to: Nanos) {
        if self.method == Method::CycleAveraged {
            self.average(to);
            return;
        }
        let watts = self.watts();
        let span = to.since(self.now);
        let steps = span.0.div_ceil(self.step.0);
        for _ in 0..steps {
            self.step_by(watts, span.as_secs_f64() / steps as f64);
        }
        self.now = self.now.max(to);
    }

    fn nodes(&self) -> [f64; NODES] {
        self.nodes
    }

    fn fraction(&self) -> f64 {
        self.phase.fraction(self.nodes[0])
    }

    fn wire_peak(&self) -> f64 {
        self.peak
    }
}
