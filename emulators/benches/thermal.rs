//! What eight wires and their skin cost per simulated second: `cargo bench -p palpate-emulators --bench thermal`.
#![allow(
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a benchmark times and prints"
)]
#![allow(
    clippy::unwrap_used,
    reason = "a benchmark's parameters are known to be good"
)]

use std::time::Instant;

use palpate_core::physics::{Alloy, Hysteresis, SkinParameters, WireParameters};
use palpate_emulators::time::Nanos;
use palpate_emulators::wire::Wire;

const PERIOD: u64 = 4096 * 1240;
const PULSE: u64 = 100 * 1240;

/// Ten seconds of bursts of seven pulses, one wire after another; a dwelling wire has them all.
fn run(parameters: &WireParameters, amps: f64, dwell: bool, dose: bool) -> f64 {
    let make = || {
        let w = Wire::new(parameters, &SkinParameters::DEFAULT, 33.0).unwrap();
        if dose { w.with_dose() } else { w }
    };
    let mut wires: Vec<Wire> = (0..8).map(|_| make()).collect();
    let mut burst = 0_u64;
    while burst * 58_500_000 < 10_000_000_000 {
        for (i, wire) in wires.iter_mut().enumerate() {
            if dwell || burst % 8 == i as u64 {
                for pulse in 0..7 {
                    let t = burst * 58_500_000 + pulse * PERIOD;
                    wire.set_current(Nanos(t), amps);
                    wire.set_current(Nanos(t + PULSE), 0.0);
                }
            }
        }
        burst += 1;
    }
    wires
        .iter_mut()
        .map(|w| w.temperature(Nanos(10_000_000_000)))
        .sum()
}

fn report(name: &str, work: impl Fn() -> f64) {
    // `-- TEXT` runs what has TEXT in its name.
    if std::env::args()
        .skip(1)
        .any(|a| !a.starts_with("--") && !name.contains(&a))
    {
        return;
    }
    let mut times: Vec<f64> = (0..21)
        .map(|_| {
            let start = Instant::now();
            std::hint::black_box(work());
            start.elapsed().as_secs_f64() / 10.0 * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!(
        "{name:44} {:8.4} ms per simulated second (median of 21)",
        times[10]
    );
}

fn main() {
    let play = WireParameters::FINAL;
    let plays = WireParameters {
        hysteresis: Hysteresis::Plays {
            count: 5,
            narrowest: 0.1,
        },
        ..play
    };
    let cosine = WireParameters {
        hysteresis: Hysteresis::Cosine { pieces: 16 },
        ..play
    };
    let ratio = WireParameters {
        austenite_ratio: 1.25,
        ..play
    };
    // Transformation where the ripple is: every pulse passes phase events.
    let mut alloy = Alloy::LOW;
    (alloy.austenite_start_c, alloy.austenite_finish_c) = (56.0, 60.0);
    (alloy.martensite_start_c, alloy.martensite_finish_c) = (55.0, 51.0);
    let cycling = WireParameters { alloy, ..play };
    for (name, p) in [
        ("play", play),
        ("five plays", plays),
        ("cosine", cosine),
        ("play, R(xi)", ratio),
        ("cycling", cycling),
    ] {
        report(&format!("8 wires round-robin, {name}"), || {
            run(&p, 1.97, false, false)
        });
        report(&format!("8 wires all on, {name}"), || {
            run(&p, 1.97, true, false)
        });
    }
    report("8 wires round-robin, play, dose", || {
        run(&play, 1.97, false, true)
    });
    report("8 wires all on, play, dose", || {
        run(&play, 1.97, true, true)
    });
    let wire = Wire::new(&play, &SkinParameters::DEFAULT, 33.0).unwrap();
    report("8 idle wires (asked once in 10 s)", || {
        (0..8)
            .map(|_| wire.clone().temperature(Nanos(10_000_000_000)))
            .sum()
    });
    report("building 8 wires (times 10)", || {
        (0..8)
            .map(|_| {
                Wire::new(&play, &SkinParameters::DEFAULT, 33.0)
                    .unwrap()
                    .temperature(Nanos::ZERO)
            })
            .sum()
    });
}
