//! The exact solver against Dormand and Prince's 8(5,3) from another library at 1e-12, restarted at
//! every edge (its sparse output: the dense one is wrong at the end points of short segments).

use super::*;
use crate::display::finger::{NODES, ThermalNetwork};
use ode_solvers::dop853::Dop853;
use ode_solvers::{OutputType, System};
use palpate_core::physics::{Alloy, SHARES, TissueParameters, WireParameters};

type State = ode_solvers::SVector<f64, NODES>;

/// Plain right-hand side at a constant stress with the martensite's shares written out anew: between two edges the wire
/// only heats or only cools, so that every share follows from the one at the edge.
struct Plain<'a> {
    network: &'a ThermalNetwork,
    wire: &'a WireParameters,
    shares: &'a [Alloy],
    watts: f64,
    memory: Vec<f64>,
}

impl Plain<'_> {
    fn share(&self, k: usize, t: f64) -> f64 {
        let a = &self.shares[k];
        let hot = (a.austenite_finish_c - t) / (a.austenite_finish_c - a.austenite_start_c);
        let cold = (a.martensite_start_c - t) / (a.martensite_start_c - a.martensite_finish_c);
        self.memory[k]
            .max(cold.clamp(0.0, 1.0))
            .min(hot.clamp(0.0, 1.0))
    }

    fn all(&self, t: f64) -> Vec<f64> {
        (0..SHARES).map(|k| self.share(k, t)).collect()
    }

    /// Latent heat per kelvin of one share, J/kgK.
    fn latent(&self, k: usize, t: f64) -> f64 {
        let (a, p) = (&self.shares[k], self.share(k, t));
        let heating = p < self.memory[k] && t < a.austenite_finish_c;
        let cooling = p > self.memory[k] && t > a.martensite_finish_c;
        let width = if heating {
            a.austenite_finish_c - a.austenite_start_c
        } else if cooling {
            a.martensite_start_c - a.martensite_finish_c
        } else {
            return 0.0;
        };
        self.wire.latent_heat / SHARES as f64 / width
    }
}

impl System<f64, State> for Plain<'_> {
    fn system(&self, _: f64, y: &State, dy: &mut State) {
        let nodes: [f64; NODES] = core::array::from_fn(|i| y[i]);
        let w = self.wire;
        let latent: f64 = (0..SHARES).map(|k| self.latent(k, nodes[0])).sum();
        let capacity = w.mass() * (w.specific_heat + latent);
        let rate = self
            .network
            .rate(&nodes, self.watts * w.wire_share, capacity);
        for i in 0..NODES {
            dy[i] = rate[i];
        }
    }
}

/// Bands of the martensite's shares under the wire's stress.
fn shares(wire: &WireParameters) -> Vec<Alloy> {
    let whole = wire.alloy.under(wire.bias_stress_pa);
    let part = |from: f64, to: f64, k: usize| from + (to - from) * k as f64 / SHARES as f64;
    let share = |k: usize| Alloy {
        austenite_start_c: part(whole.austenite_start_c, whole.austenite_finish_c, k),
        austenite_finish_c: part(whole.austenite_start_c, whole.austenite_finish_c, k + 1),
        martensite_start_c: part(whole.martensite_finish_c, whole.martensite_start_c, k + 1),
        martensite_finish_c: part(whole.martensite_finish_c, whole.martensite_start_c, k),
        ..whole
    };
    (0..SHARES).map(share).collect()
}

/// Largest distances in temperature and phase, with at least so many steps from edge to edge.
fn compare(wire: &WireParameters, train: &[(Nanos, f64)], end: Nanos, steps: f64) -> (f64, f64) {
    let tissue = TissueParameters::DEFAULT;
    let network = ThermalNetwork::new(wire, &tissue).unwrap();
    let mut exact = at_constant_stress(wire, &tissue);
    let mut y = State::repeat(33.0);
    let shares = shares(wire);
    // All cold, but for what 33 C lets turn.
    let mut start = Plain {
        network: &network,
        wire,
        shares: &shares,
        watts: 0.0,
        memory: vec![1.0; SHARES],
    };
    start.memory = start.all(33.0);
    let (mut watts, mut memory, mut now) = (0.0, start.memory, Nanos::ZERO);
    let mut worst = (0.0_f64, 0.0_f64);
    for &(t, next) in train.iter().chain([&(end, 0.0)]) {
        if t > now {
            let plain = Plain {
                network: &network,
                wire,
                shares: &shares,
                watts,
                memory: memory.clone(),
            };
            let span = t.since(now).as_secs_f64();
            let mut method = Dop853::from_param(
                plain,
                0.0,
                span,
                span,
                y,
                1e-13,
                1e-12,
                0.9,
                0.0,
                0.333,
                6.0,
                span / steps,
                span / steps,
                1_000_000,
                u32::MAX,
                OutputType::Sparse,
            );
            method.integrate().unwrap();
            y = *method.y_out().last().unwrap();
            memory = Plain {
                network: &network,
                wire,
                shares: &shares,
                watts,
                memory,
            }
            .all(y[0]);
            exact.advance(t);
            for (a, b) in exact.solver().nodes().iter().zip(y.iter()) {
                worst.0 = worst.0.max((a - b).abs());
            }
            let xi = memory.iter().sum::<f64>() / SHARES as f64;
            worst.1 = worst.1.max((exact.fraction(t) - xi).abs());
            now = t;
        }
        exact.set_power(t, next);
        watts = next;
    }
    worst
}

#[test]
fn agrees_with_another_method() {
    let full = WireParameters {
        wire_share: 1.0,
        ..WireParameters::FINAL.taut()
    };
    let ms = |n: u64| Nanos(n * 1_000_000);
    for (name, wire, train, end) in [
        (
            "round-robin",
            WireParameters::FINAL.taut(),
            edges(ms(35), ms(468), ms(1900)),
            ms(2000),
        ),
        (
            "dwelling",
            full,
            edges(ms(35), Nanos(58_500_000), ms(900)),
            ms(1000),
        ),
    ] {
        let (kelvin, fraction) = compare(&wire, &train, end, 1.0);
        println!("{name}: {kelvin:.2e} K, {fraction:.2e} of the phase");
        assert!(
            kelvin < 1e-6 && fraction < 1e-6,
            "{name} {kelvin} {fraction}"
        );
    }
}

/// An alloy that every pulse and every pause transform in part: its bands are so narrow that a general solver left to
/// its own steps jumps over them.
#[test]
fn agrees_with_another_method_where_every_pulse_transforms() {
    let alloy = Alloy {
        austenite_start_c: 90.0,
        austenite_finish_c: 91.0,
        martensite_start_c: 89.5,
        martensite_finish_c: 88.5,
        reference_stress_pa: 172e6,
        ..Alloy::LOW
    };
    let wire = WireParameters {
        alloy,
        ..WireParameters::FINAL.taut()
    };
    let mut held = at_constant_stress(&wire, &TissueParameters::DEFAULT);
    let (mut train, mut both_ways) = (Vec::new(), 0);
    for n in 0..60 {
        let start = Nanos(n * PERIOD.0);
        let before = held.fraction(start);
        let end = start
            + Nanos(if before > 0.5 {
                PULSE.0
            } else {
                PULSE.0 * 2 / 5
            });
        train.extend([(start, PULSE_W), (end, 0.0)]);
        held.set_power(start, PULSE_W);
        held.set_power(end, 0.0);
        let hot = held.fraction(end);
        let after = held.fraction(start + Nanos(PERIOD.0 - 1));
        both_ways += usize::from(hot < before && after > hot);
    }
    assert!(both_ways > 40, "{both_ways} pulses of 60");
    let (kelvin, fraction) = compare(&wire, &train, Nanos(60 * PERIOD.0), 200.0);
    println!("{kelvin:.2e} K, {fraction:.2e} of the phase");
    assert!(kelvin < 1e-6 && fraction < 1e-6, "{kelvin} {fraction}");
}
