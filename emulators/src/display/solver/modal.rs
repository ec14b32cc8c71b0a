//! The exact solution between two edges: eigen-decomposition of the symmetrised network.
//!
//! With u = T - T_body, C u' = -G u + e_0 p has a symmetric form S = C^-1/2 G C^-1/2 = V L V^T. In the
//! coordinates z = V^T C^1/2 u every node decays on its own: z' = -lambda z + g p, so that a step of any length
//! is seventeen multiply-adds and has no truncation error.

// Indices name nodes and modes, several arrays of them at once.
#![allow(clippy::needless_range_loop)]

use super::decay::decays;
use super::eigen::Eigen;
use super::lanes::dot;
use super::sum::Sum;
use crate::display::finger::{NODES, ThermalNetwork};
use palpate_core::vector::{Scalar, Vectors};

/// The variable part of a mode: all else in a network is constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeKey {
    /// Latent heat that a kelvin takes up or releases, J/K; 0 with every phase at rest.
    pub latent: f64,
    /// Rise of the electrical heat with the wire's temperature (I^2 dR/dT), W/K.
    pub feedback: f64,
}

/// One linear regime of wire and tissue.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Key of the regime.
    pub key: ModeKey,
    /// Decay rates, rising, 1/s.
    pub lambda: [f64; NODES],
    /// Time constants 1 / lambda, s.
    times: [f64; NODES],
    /// Gain from heat into the wire to each coordinate; not negative.
    pub gain: [f64; NODES],
    /// Node temperatures from coordinates: `shape[node][k]`.
    shape: [[f64; NODES]; NODES],
    /// The shape transposed: `columns[k][node]`.
    columns: [[f64; NODES]; NODES],
    /// Heat capacity of each node, J/K, latent heat included.
    capacity: [f64; NODES],
    /// Tissue at 0.1 mm from coordinates.
    pub shallow: [f64; NODES],
    /// Tissue at 0.4 mm from coordinates.
    pub deep: [f64; NODES],
    vectors: Vectors,
}

impl Mode {
    /// Decomposes a network in the regime `key`.
    pub fn new(network: &ThermalNetwork, key: ModeKey) -> Self {
        let mut capacity = network.capacity;
        capacity[0] += key.latent;
        // Slowest first, the wire last: QL converges sooner and loses fewer digits where small entries come first.
        let (mut diagonal, mut beside) = ([0.0; NODES], [0.0; NODES]);
        for i in 0..NODES {
            let mut out = network.chain[i];
            out += match i {
                0 => network.air + network.ends - key.feedback,
                _ => network.chain[i - 1],
            };
            diagonal[NODES - 1 - i] = out / capacity[i];
            if i + 1 < NODES {
                let root = libm::sqrt(capacity[i] * capacity[i + 1]);
                beside[NODES - 2 - i] = -network.chain[i] / root;
            }
        }
        let eigen = Eigen::new(diagonal, beside);
        let roots = capacity.map(libm::sqrt);
        let mut order: [usize; NODES] = core::array::from_fn(|i| i);
        order.sort_unstable_by(|a, b| eigen.values[*a].total_cmp(&eigen.values[*b]));
        let mut mode = Self {
            key,
            lambda: [0.0; NODES],
            times: [0.0; NODES],
            gain: [0.0; NODES],
            shape: [[0.0; NODES]; NODES],
            columns: [[0.0; NODES]; NODES],
            capacity,
            shallow: [0.0; NODES],
            deep: [0.0; NODES],
            vectors: Vectors::widest(),
        };
        for (k, &place) in order.iter().enumerate() {
            // Only electrical runaway brings a rate near zero; keep it off the singular point.
            let rate = eigen.values[place];
            mode.lambda[k] = if rate.abs() < 1e-9 { 1e-9 } else { rate };
            mode.times[k] = 1.0 / mode.lambda[k];
            let vector = &eigen.vectors[place];
            let sign = if vector[NODES - 1] < 0.0 { -1.0 } else { 1.0 };
            for i in 0..NODES {
                let entry = sign * vector[NODES - 1 - i] / roots[i];
                (mode.shape[i][k], mode.columns[k][i]) = (entry, entry);
            }
            mode.gain[k] = mode.shape[0][k];
        }
        for (depth, row) in [(network.shallow, 0), (network.deep, 1)] {
            let near = mode.shape[depth.node];
            let far = mode.shape[depth.node + 1];
            for k in 0..NODES {
                let v = near[k] * (1.0 - depth.weight) + far[k] * depth.weight;
                if row == 0 {
                    mode.shallow[k] = v
                } else {
                    mode.deep[k] = v
                }
            }
        }
        mode
    }

    /// Coordinates of node temperatures above the body's.
    pub fn project(&self, u: &[f64; NODES]) -> [f64; NODES] {
        self.vectors.run(
            #[inline(always)]
            || self.plain_project(u),
        )
    }

    #[inline(always)]
    fn plain_project(&self, u: &[f64; NODES]) -> [f64; NODES] {
        let mut z = [0.0; NODES];
        for i in 0..NODES {
            let heat = u[i] * self.capacity[i];
            for k in 0..NODES {
                z[k] += self.shape[i][k] * heat;
            }
        }
        z
    }

    /// Node temperatures above the body's.
    pub fn nodes(&self, z: &[f64; NODES]) -> [f64; NODES] {
        self.vectors.run(
            #[inline(always)]
            || self.plain_nodes(z),
        )
    }

    #[inline(always)]
    fn plain_nodes(&self, z: &[f64; NODES]) -> [f64; NODES] {
        let mut nodes = [0.0; NODES];
        for k in 0..NODES {
            for i in 0..NODES {
                nodes[i] += self.columns[k][i] * z[k];
            }
        }
        nodes
    }

    /// Temperature of the first shell above the body's, K.
    pub(super) fn first_shell(&self, z: &[f64; NODES]) -> f64 {
        dot(Scalar, &self.shape[1], z)
    }

    /// Row that gives the outermost shell.
    pub fn last(&self) -> &[f64; NODES] {
        &self.shape[NODES - 1]
    }

    /// Rate of change of the coordinates, 1/s of theirs.
    #[inline(always)]
    pub fn rate(&self, z: &[f64; NODES], power: f64) -> [f64; NODES] {
        let mut d = [0.0; NODES];
        for k in 0..NODES {
            d[k] = power * self.gain[k] - self.lambda[k] * z[k];
        }
        d
    }

    /// A watched temperature as a function of time: from `start` (K), with these terms of its slope.
    pub fn sum(&self, slopes: [f64; NODES], start: f64) -> Sum<'_> {
        Sum::new(&self.lambda, slopes, start, self.vectors)
    }
}

/// Effect of a span of time on the coordinates of a mode.
#[derive(Clone, Debug)]
pub struct Propagator {
    seconds: f64,
    /// exp(-lambda t).
    decay: [f64; NODES],
    /// (1 - exp(-lambda t)) / lambda, s.
    rise: [f64; NODES],
}

impl Propagator {
    /// Propagator over `t` seconds.
    pub fn new(mode: &Mode, t: f64) -> Self {
        mode.vectors.run(
            #[inline(always)]
            || Self::plain(mode, t),
        )
    }

    #[inline(always)]
    fn plain(mode: &Mode, t: f64) -> Self {
        let (decay, mut rise) = decays(&mode.lambda, t);
        for k in 0..NODES {
            rise[k] *= mode.times[k];
        }
        Self {
            seconds: t,
            decay,
            rise,
        }
    }

    /// Coordinates after the span under constant `power`.
    #[inline(always)]
    pub fn step(&self, mode: &Mode, z: &[f64; NODES], power: f64) -> [f64; NODES] {
        let mut out = [0.0; NODES];
        for k in 0..NODES {
            out[k] = self.decay[k] * z[k] + self.rise[k] * mode.gain[k] * power;
        }
        out
    }

    /// Further term (t - rise) / lambda, s2, for a step that turns out to be taken.
    #[inline(always)]
    pub fn ramp(&self, mode: &Mode) -> [f64; NODES] {
        let t = self.seconds;
        let mut ramp = [0.0; NODES];
        for k in 0..NODES {
            let x = mode.lambda[k] * t;
            // Where t and the rise are nearly equal their difference has no digits left.
            ramp[k] = if x.abs() < 1e-3 {
                let inner = 1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0));
                t * t / 2.0 * (1.0 - x / 3.0 * inner)
            } else {
                (t - self.rise[k]) * mode.times[k]
            };
        }
        ramp
    }

    /// Time integral of the coordinates over the span, for the energy ledger.
    #[inline(always)]
    pub fn integral(
        &self,
        mode: &Mode,
        ramp: &[f64; NODES],
        z: &[f64; NODES],
        power: f64,
    ) -> [f64; NODES] {
        let mut out = [0.0; NODES];
        for k in 0..NODES {
            out[k] = self.rise[k] * z[k] + ramp[k] * mode.gain[k] * power;
        }
        out
    }
}

#[cfg(test)]
#[path = "modal_tests.rs"]
mod tests;
