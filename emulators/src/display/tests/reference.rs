//! The exact solver against Dormand and Prince's 8(5,3) from another library at 1e-12, restarted at
//! every edge (its sparse output: the dense one is wrong at the end points of short segments).

use super::*;
use crate::display::finger::{NODES, ThermalNetwork};
use ode_solvers::dop853::Dop853;
use ode_solvers::{OutputType, System};
use palpate_core::physics::{Alloy, Hysteresis, Play, TissueParameters, WireParameters};

type State = ode_solvers::SVector<f64, NODES>;

/// Plain right-hand side with the plays written out anew: between two edges the wire only heats or only
/// cools, so that every share follows from the one at the edge.
struct Plain<'a> {
    network: &'a ThermalNetwork,
    wire: &'a WireParameters,
    plays: &'a [Play],
    watts: f64,
    memory: Vec<f64>,
}

impl Plain<'_> {
    fn share(&self, k: usize, t: f64) -> f64 {
        let a = &self.plays[k].bands;
        let hot = (a.austenite_finish_c - t) / (a.austenite_finish_c - a.austenite_start_c);
        let cold = (a.martensite_start_c - t) / (a.martensite_start_c - a.martensite_finish_c);
        self.memory[k]
            .max(cold.clamp(0.0, 1.0))
            .min(hot.clamp(0.0, 1.0))
    }

    fn shares(&self, t: f64) -> Vec<f64> {
        (0..self.plays.len()).map(|k| self.share(k, t)).collect()
    }

    /// Latent heat per kelvin of one play, J/kgK.
    fn latent(&self, k: usize, t: f64) -> f64 {
        let (a, p) = (&self.plays[k].bands, self.share(k, t));
        let heating = p < self.memory[k] && t < a.austenite_finish_c;
        let cooling = p > self.memory[k] && t > a.martensite_finish_c;
        let width = if heating {
            a.austenite_finish_c - a.austenite_start_c
        } else if cooling {
            a.martensite_start_c - a.martensite_finish_c
        } else {
            return 0.0;
        };
        self.plays[k].latent_heat / width
    }
}

impl System<f64, State> for Plain<'_> {
    fn system(&self, _: f64, y: &State, dy: &mut State) {
        let nodes: [f64; NODES] = core::array::from_fn(|i| y[i]);
        let w = self.wire;
        let latent: f64 = (0..self.plays.len())
            .map(|k| self.latent(k, nodes[0]))
            .sum();
        let capacity = w.mass() * (w.specific_heat + latent);
        let rate = self
            .network
            .rate(&nodes, self.watts * w.wire_share, capacity);
        for i in 0..NODES {
            dy[i] = rate[i];
        }
    }
}

/// Largest distances in temperature and phase, with at least so many steps from edge to edge.
fn compare(wire: &WireParameters, train: &[(Nanos, f64)], end: Nanos, steps: f64) -> (f64, f64) {
    let tissue = TissueParameters::DEFAULT;
    let network = ThermalNetwork::new(wire, &tissue).unwrap();
    let mut exact = Wire::new(wire, &tissue, 33.0).unwrap();
    let mut y = State::repeat(33.0);
    let plays = wire.plays().unwrap();
    // All cold, but for what 33 C lets turn.
    let mut start = Plain {
        network: &network,
        wire,
        plays: &plays,
        watts: 0.0,
        memory: vec![1.0; plays.len()],
    };
    start.memory = start.shares(33.0);
    let (mut watts, mut memory, mut now) = (0.0, start.memory, Nanos::ZERO);
    let mut worst = (0.0_f64, 0.0_f64);
    for &(t, next) in train.iter().chain([&(end, 0.0)]) {
        if t > now {
            let plain = Plain {
                network: &network,
                wire,
                plays: &plays,
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
                plays: &plays,
                watts,
                memory,
            }
            .shares(y[0]);
            exact.advance(t);
            for (a, b) in exact.solver().nodes().iter().zip(y.iter()) {
                worst.0 = worst.0.max((a - b).abs());
            }
            let xi: f64 = memory
                .iter()
                .zip(&plays)
                .map(|(p, play)| p * play.martensite)
                .sum();
            let strain: f64 = memory
                .iter()
                .zip(&plays)
                .map(|(p, play)| p * play.strain)
                .sum();
            worst.1 = worst.1.max((exact.fraction(t) - xi).abs());
            let whole: f64 = plays.iter().map(|play| play.strain).sum();
            worst.1 = worst.1.max((exact.strain(t).phase - strain).abs() / whole);
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
        ..WireParameters::FINAL
    };
    let ms = |n: u64| Nanos(n * 1_000_000);
    for (name, wire, train, end) in [
        (
            "round-robin",
            WireParameters::FINAL,
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
        ..Alloy::LOW
    };
    let wire = WireParameters {
        alloy,
        ..WireParameters::FINAL
    };
    let mut held = Wire::new(&wire, &TissueParameters::DEFAULT, 33.0).unwrap();
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

/// Parallel plays with strains and latent heats of their own: the loose wire, and one whose martensite is five plays.
#[test]
fn agrees_with_another_method_in_parallel_plays() {
    let ms = |n: u64| Nanos(n * 1_000_000);
    let five = WireParameters {
        hysteresis: Hysteresis::Plays {
            count: 5,
            narrowest: 0.2,
        },
        reversible: 0.3,
        ..WireParameters::FINAL.loose()
    };
    let part = |watts: f64, part: f64| if watts > 0.0 { watts * part } else { 0.0 };
    for (name, wire, drive) in [
        ("loose", WireParameters::FINAL.loose(), 0.25),
        ("loose, full drive", WireParameters::FINAL.loose(), 1.0),
        ("six plays and the R phase", five, 0.5),
    ] {
        let mut train = edges(ms(35), Nanos(58_500_000), ms(400));
        for (_, watts) in &mut train {
            *watts = part(*watts, drive);
        }
        let (kelvin, fraction) = compare(&wire, &train, ms(500), 200.0);
        println!("{name}: {kelvin:.2e} K, {fraction:.2e} of the phase and of its strain");
        assert!(
            kelvin < 1e-6 && fraction < 1e-6,
            "{name} {kelvin} {fraction}"
        );
    }
}
