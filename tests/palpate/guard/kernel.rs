//! Where the guard's table comes from: what a joule of electrical pulse does to the skin, from above over the
//! whole stated range of parameters, and the sums of decays that bound it.

use microlp::{ComparisonOp, OptimizationDirection, Problem, Variable};
use palpate_core::physics::{AIR_POWER, TissueParameters, WireParameters};
use palpate_emulators::display::finger::{NODES, ThermalNetwork};
use palpate_emulators::display::solver::modal::{Mode, ModeKey};

/// Decays of the guard's reduced model. The slowest is the finger's own; each is twice as fast as the one
/// before, so that the guard needs one exponential for all.
pub const DECAYS: usize = 14;

/// One corner of the range: the impulse responses of both depths to electrical energy.
pub struct Corner {
    lambda: [f64; NODES],
    /// At 0.1 and at 0.4 mm.
    responses: [[f64; NODES]; 2],
}

impl Corner {
    /// The impulse responses of the full model without latent heat.
    pub fn new(wire: &WireParameters, skin: &TissueParameters) -> Self {
        let network = ThermalNetwork::new(wire, skin).unwrap();
        let at_rest = ModeKey {
            latent: 0.0,
            feedback: 0.0,
        };
        let mode = Mode::new(&network, at_rest);
        let response =
            |row: &[f64; NODES]| core::array::from_fn(|k| wire.wire_share * row[k] * mode.gain[k]);
        Self {
            lambda: mode.lambda,
            responses: [response(&mode.shallow), response(&mode.deep)],
        }
    }

    /// Response at a depth to a joule `t` seconds after it, K.
    pub fn response(&self, depth: usize, t: f64) -> f64 {
        let terms = self.responses[depth].iter().zip(&self.lambda);
        terms.map(|(c, rate)| c * libm::exp(-rate * t)).sum()
    }
}

impl Corner {
    /// Response at a depth to joules that came evenly in `length_s`, so long after their end, K.
    pub fn of_burst(&self, depth: usize, joules: f64, length_s: f64, after_s: f64) -> f64 {
        let terms = self.responses[depth].iter().zip(&self.lambda);
        let left = |rate: f64| -libm::expm1(-rate * length_s) / (rate * length_s);
        let sum = terms.map(|(c, rate)| c * left(*rate) * libm::exp(-rate * after_s));
        joules * sum.sum::<f64>()
    }
}

/// Heat transfer to still air, W/m2K: that of the final module's wire, by Morgan's law for a cylinder in still air.
pub fn air_h(diameter_m: f64) -> f64 {
    let final_wire = WireParameters::FINAL;
    final_wire.air_h * libm::pow(diameter_m / final_wire.diameter_m, AIR_POWER)
}

/// A wire of some size, its other values the final module's; infinitely long: its ends take nothing, and a joule is one per
/// 5 mm.
pub fn sized(diameter_um: f64, length_mm: f64) -> WireParameters {
    let diameter_m = diameter_um * 1e-6;
    let base = WireParameters {
        diameter_m,
        air_h: air_h(diameter_m),
        ..WireParameters::FINAL
    };
    if length_mm.is_infinite() {
        return WireParameters {
            conductivity: 0.0,
            ..base
        };
    }
    WireParameters {
        length_m: length_mm * 1e-3,
        ..base
    }
}

/// Every combination of the ends of the stated range and of values between, for one wire.
pub fn corners(base: &WireParameters) -> Vec<Corner> {
    let mut all = Vec::new();
    for wire_share in [0.6, 0.8, 1.0] {
        for specific_heat in [322.0, 400.0, 500.0, 640.0, 837.0] {
            for contact_h in [1000.0, 2000.0, 4000.0, 7000.0, 10_000.0] {
                for contact_fraction in [0.1, 0.2, 0.35, 0.5] {
                    let wire = WireParameters {
                        wire_share,
                        specific_heat,
                        ..*base
                    };
                    let skin = TissueParameters {
                        contact_h,
                        contact_fraction,
                        ..TissueParameters::DEFAULT
                    };
                    all.push(Corner::new(&wire, &skin));
                }
            }
        }
    }
    all
}

/// Times at which responses are compared, s: every millisecond at first, then 1 % apart, to a quarter of an hour.
pub fn times() -> Vec<f64> {
    let mut t: Vec<f64> = (0..200).map(|i| f64::from(i) * 1e-3).collect();
    let mut next = 0.2;
    while next < 900.0 {
        t.push(next);
        next *= 1.01;
    }
    t
}

/// The largest response of any corner at each time or later, K/J.
pub fn envelope(corners: &[Corner], depth: usize, times: &[f64]) -> Vec<f64> {
    let largest = |t: &f64| {
        corners
            .iter()
            .map(|c| c.response(depth, *t))
            .fold(0.0, f64::max)
    };
    let mut all: Vec<f64> = times.iter().map(largest).collect();
    for i in (1..all.len()).rev() {
        all[i - 1] = all[i - 1].max(all[i]);
    }
    all
}

/// Rates of the decays, 1/s.
pub fn rates(corners: &[Corner]) -> [f64; DECAYS] {
    let slowest = corners.iter().map(|c| c.lambda[0]);
    let mut rate = slowest.fold(f64::INFINITY, f64::min) / 2.0;
    core::array::from_fn(|_| {
        rate *= 2.0;
        rate
    })
}

/// What a sum of decays comes to, K/J.
pub fn sum(rates: &[f64; DECAYS], coefficients: &[f64; DECAYS], t: f64) -> f64 {
    let terms = rates.iter().zip(coefficients);
    terms.map(|(rate, c)| c * libm::exp(-rate * t)).sum()
}

/// The smallest falling sum of decays that is nowhere below `target`, which falls: a linear programme.
pub fn fit(rates: &[f64; DECAYS], times: &[f64], target: &[f64]) -> [f64; DECAYS] {
    // Relative excess counts from the length of a burst to half a minute, where bursts add up, evenly in the
    // logarithm of time; before and after it counts little.
    let weight = |t: f64| if (0.02..30.0).contains(&t) { 1.0 } else { 0.1 };
    let spans = times.windows(2).zip(target).skip(1); // the first begins at zero
    let size = |rate: f64| -> f64 {
        let part = |(t, v): (&[f64], &f64)| {
            weight(t[0]) * libm::log(t[1] / t[0]) * libm::exp(-rate * t[0]) / v
        };
        spans.clone().map(part).sum()
    };
    let mut problem = Problem::new(OptimizationDirection::Minimize);
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    // Scaled by the top of the target, so that the solver sees numbers near one.
    let c: [Variable; DECAYS] = rates.map(|rate| problem.add_var(size(rate) * target[0], free));
    // Terms a hundred thousand times smaller than others would only disturb the solver.
    let terms = |row: [f64; DECAYS]| {
        let felt = c.iter().copied().zip(row).filter(|(_, x)| *x > 1e-5);
        felt.collect::<Vec<_>>()
    };
    for (t, v) in times.iter().zip(target) {
        let decays = rates.map(|rate| libm::exp(-rate * t) * target[0] / v);
        problem.add_constraint(terms(decays), ComparisonOp::Ge, 1.0);
        let slopes: [f64; DECAYS] = core::array::from_fn(|k| rates[k] * decays[k]);
        let scale = slopes.iter().copied().fold(0.0, f64::max);
        problem.add_constraint(terms(slopes.map(|s| s / scale)), ComparisonOp::Ge, 0.0);
    }
    let solution = problem.solve().unwrap().into_solution().unwrap();
    let c = c.map(|c| solution[c] * target[0]);
    // What the solver's tolerance left below.
    let short = |(t, v): (&f64, &f64)| v / sum(rates, &c, *t);
    let short = times.iter().zip(target).map(short).fold(1.0, f64::max);
    c.map(|c| c * short)
}
