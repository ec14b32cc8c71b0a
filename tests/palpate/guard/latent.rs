//! What latent heat adds: a wire that transforms back gives off later what it took up, so the skin may come out
//! hotter than without. Running maxima are compared, since at one instant it may be hotter in any case.

use palpate_core::physics::{RPhase, WireParameters};
use palpate_core::random::RandomStream;
use palpate_emulators::display::wire::Wire;
use palpate_emulators::time::Nanos;

use super::kernel::sized;
use super::rig::{Parameters, pick};
use super::table::LATENT_K;

/// Nominal period of the pulses, ns.
const PERIOD: u64 = 5_079_040;

#[test]
fn latent_heat_adds_less_than_the_table_allows() {
    adds_less(|s| {
        let p = Parameters::draw(s);
        let wire = WireParameters {
            latent_heat: pick(s, 12e3, 24e3),
            ..p.wire
        };
        Parameters { wire, ..p }
    });
}

/// A loose wire transforms around the skin's own temperature, and has two phases to take heat up and give it off.
#[test]
fn latent_heat_of_a_loose_wire_adds_less_as_well() {
    adds_less(|s| Parameters::draw(s).loose(s));
}

/// A thick and long wire has the most of it, a short and thin one warms tissue most, and a cold or warm finger lies otherwise
/// to the alloy's bands.
#[test]
fn latent_heat_of_other_wires_and_fingers_adds_less_as_well() {
    adds_less(|s| {
        let sized = |s: &mut RandomStream| {
            let (um, mm) = (pick(s, 50.0, 100.0), pick(s, 3.0, 20.0));
            let wire = sized(um, mm);
            Parameters::draw(s).sized(wire, pick(s, 26.0, 36.0))
        };
        let p = sized(s);
        if s.next_u64().is_multiple_of(2) {
            return p.loose(s);
        }
        let latent_heat = pick(s, 12e3, 24e3);
        let wire = WireParameters {
            latent_heat,
            ..p.wire
        };
        Parameters { wire, ..p }
    });
}

fn adds_less(draw: impl Fn(&mut RandomStream) -> Parameters) {
    let mut s = RandomStream::new(1, "latent");
    let mut worst = [0.0f64; 3];
    for _ in 0..600 {
        let p = draw(&mut s);
        let with = p.wire;
        let cold = |r: RPhase| RPhase {
            latent_heat: 0.0,
            ..r
        };
        let without = WireParameters {
            latent_heat: 0.0,
            r_phase: with.r_phase.map(cold),
            ..with
        };
        let mut pair = [with, without].map(|w| Wire::new(&w, &p.skin, p.skin.body_c).unwrap());
        let mut sums = [0.0f64; 2];
        let mut t = 0;
        for _ in 0..1 + s.next_u64() % 12 {
            let (amps, width) = (0.5 + 2.0 * s.uniform(), 20_000 + s.next_u64() % 180_000);
            let length = 5_000_000 + s.next_u64() % 45_000_000;
            for pulse in 0..length / PERIOD {
                for wire in &mut pair {
                    wire.set_current(Nanos(t + pulse * PERIOD), amps);
                    wire.set_current(Nanos(t + pulse * PERIOD + width), 0.0);
                }
            }
            let long = s.next_u64().is_multiple_of(3);
            t += length + 20_000_000 + s.next_u64() % if long { 600_000_000 } else { 40_000_000 };
        }
        // Of the mean over the 10 s that begin with the first pulse only what follows the last one, where the
        // heat comes back: before that it is missing.
        for (wire, sum) in pair.iter_mut().zip(&mut sums) {
            let mut now = t;
            while now < 10_000_000_000 {
                *sum += 20e-3 * (wire.tissue(Nanos(now)).0 - p.skin.body_c) / 10.0;
                now += 20_000_000;
            }
        }
        let [a, b] = pair.map(|mut w| w.peaks(Nanos(t.max(10_000_000_000))));
        if b.shallow_c > 44.0 {
            continue; // far above what the guard passes
        }
        let more = [
            a.shallow_c - b.shallow_c,
            sums[0] - sums[1],
            a.deep_c - b.deep_c,
        ];
        for (worst, more) in worst.iter_mut().zip(more) {
            *worst = worst.max(more);
        }
    }
    println!("latent heat adds at most {worst:.3?} K");
    for (worst, most) in worst.iter().zip(LATENT_K) {
        assert!(*worst < most);
    }
}
