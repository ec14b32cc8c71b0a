//! What the guard costs an onset: `cargo bench -p palpate-core --bench guard`.
#![allow(
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a benchmark times and prints"
)]
#![allow(
    clippy::unwrap_used,
    reason = "a benchmark's parameters are known to be good"
)]

use std::hint::black_box;
use std::time::Instant as Wall;

use palpate_core::guard::{Guard, HARD, Plant};
use palpate_core::illusion::Wire;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Channel, Instant, Milliamps, Point, Prescale, Ticks};

const WIRES: u8 = 8;
const SOA_US: u64 = 58_500;
const ROUNDS: u64 = 20_000;

fn main() {
    let wire = |c: u8| Wire {
        place: Point::new(f32::from(c), 0.0),
        board: Board(0),
        channel: Channel(c),
    };
    let wires: Vec<Wire> = (0..WIRES).map(wire).collect();
    let plant = Plant {
        prescale: Prescale::new(30),
        wire_milliohm: 1900,
        peak: Milliamps(1970),
    };
    for driven in [1, WIRES] {
        let mut guard = Guard::new(HARD, plant, &wires).unwrap();
        let onset = |round: u64| {
            let at = Instant::from_micros(round * SOA_US);
            let until = Instant::from_micros(round * SOA_US + 35_000);
            let stimuli: Vec<Stimulus> = (0..driven)
                .map(|wire| Stimulus {
                    wire: u16::from(wire),
                    width: Ticks::new(100),
                    peak: Milliamps(1970),
                    at,
                    until,
                })
                .collect();
            let started = Wall::now();
            black_box(guard.admit(at, Board(0), &stimuli, |entry| {
                black_box(entry);
            }));
            black_box(guard.expire(until, Board(0)));
            started.elapsed().as_secs_f64() * 1e6
        };
        let mut times: Vec<f64> = (0..ROUNDS).map(onset).collect();
        times.sort_by(f64::total_cmp);
        println!(
            "{driven} of {WIRES} wires dwelling: median {:.2} us an onset and its end, {:.2} us at the 99th percentile",
            times[times.len() / 2],
            times[times.len() * 99 / 100]
        );
    }
}
