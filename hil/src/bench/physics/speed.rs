//! What eight wires and their finger cost, a simulated second; the error is what the energy ledger misses.

use std::time::Duration;

use palpate_core::physics::{Hysteresis, ParameterError, SkinParameters, WireParameters};
use palpate_emulators::time::Nanos;
use palpate_emulators::wire::Wire;

use super::train::{Bursts, Case, START_C, ms};
use crate::bench::timing::Race;
use crate::bench::{Findings, Row, table};

const WIRES: usize = 8;
/// Simulated seconds of a sample: construction and first decompositions are spread over them.
const SECONDS: u64 = 10;
/// Burst after burst, this long from one to the next.
const SOA: Nanos = Nanos(58_500_000);

/// Power from a time on, W, by wire.
type Edges = Vec<(Nanos, usize, f64)>;

/// Eight equal wires and what drives them.
struct Load {
    name: &'static str,
    wire: WireParameters,
    edges: Edges,
    dose: bool,
    target_us: Option<f64>,
}

fn loads() -> Result<Vec<Load>, ParameterError> {
    let play = WireParameters::FINAL;
    let five = Hysteresis::Plays {
        count: 5,
        narrowest: 0.2,
    };
    let plays = WireParameters {
        hysteresis: five,
        ..play
    };
    let load = |name, wire, edges: &Edges, target_us| Load {
        name,
        wire,
        edges: edges.clone(),
        dose: false,
        target_us,
    };
    let (turns, together) = (bursts(false), bursts(true));
    let end = ms(1000 * SECONDS);
    let (held, held_plays) = (Case::held(Hysteresis::Play, end)?, Case::held(five, end)?);
    let all = |case: &Case| -> Edges {
        let each = |&(at, watts): &(Nanos, f64)| (0..WIRES).map(move |wire| (at, wire, watts));
        case.edges.iter().flat_map(each).collect()
    };
    let dosed = load("8 wires, 1 s, round-robin, with dose", play, &turns, None);
    Ok(vec![
        load("8 wires, 1 s, round-robin", play, &turns, Some(300.0)),
        Load {
            dose: true,
            ..dosed
        },
        load("8 wires, 1 s, round-robin, five plays", plays, &turns, None),
        load("8 wires, 1 s, all in every burst", play, &together, None),
        load(
            "8 wires, 1 s, phase-cycling at every pulse",
            held.wire,
            &all(&held),
            Some(3000.0),
        ),
        load(
            "8 wires, 1 s, phase-cycling at every pulse, five plays",
            held_plays.wire,
            &all(&held_plays),
            None,
        ),
    ])
}

/// Burst after burst in the order of time: on one wire after another, or on all of them each time.
fn bursts(all: bool) -> Edges {
    let end = ms(1000 * SECONDS);
    let one = Bursts {
        burst: ms(35),
        cycle: end,
        end: ms(35),
    };
    let one = one.edges();
    let mut out = Vec::new();
    let (mut start, mut turn) = (Nanos::ZERO, 0);
    while start < end {
        let driven = (0..WIRES).filter(|w| all || *w == turn % WIRES);
        let driven: Vec<usize> = driven.collect();
        for &(at, watts) in &one {
            out.extend(driven.iter().map(|&wire| (start + at, wire, watts)));
        }
        (start, turn) = (start + SOA, turn + 1);
    }
    out
}

impl Load {
    fn wires(&self) -> Result<Vec<Wire>, String> {
        let make = || Wire::new(&self.wire, &SkinParameters::DEFAULT, START_C);
        let wires = (0..WIRES).map(|_| make().map(|w| if self.dose { w.with_dose() } else { w }));
        wires.collect::<Result<_, _>>().map_err(|e| e.to_string())
    }

    fn run(&self) -> Result<Vec<Wire>, String> {
        let mut wires = self.wires()?;
        for &(at, wire, watts) in &self.edges {
            wires[wire].set_power(at, watts);
        }
        for wire in &mut wires {
            wire.advance(ms(1000 * SECONDS));
        }
        Ok(wires)
    }
}

/// What the ledger of a wire misses, relative to what it got.
fn missing(wire: &mut Wire) -> f64 {
    let e = wire.energy(ms(1000 * SECONDS));
    let gone = e.air_j + e.ends_j + e.body_j;
    (e.wire_j - e.stored_j - e.latent_j - gone).abs() / e.wire_j.abs().max(1e-12)
}

/// Times every load beside the others.
///
/// # Errors
/// A wire that cannot be computed.
pub fn measure(findings: &mut Findings) -> Result<(), String> {
    let loads = loads().map_err(|e| e.to_string())?;
    let mut errors = Vec::new();
    let mut race = Race::default();
    for load in &loads {
        // At the start everything is at 33 C, where neither store counts anything: martensite, no latent heat.
        let mut wires = load.run()?;
        errors.push(wires.iter_mut().map(missing).fold(0.0, f64::max));
        race.enter(move || load.run().map(|w| w.len()));
    }
    let idle = loads[0].wires()?;
    race.enter(move || {
        let ask = |wire: &Wire| wire.clone().temperature(ms(1000));
        idle.iter().map(ask).sum::<f64>()
    });
    let unasked = loads[0].wires()?;
    race.enter(move || unasked.iter().map(|w| w.now().0).sum::<u64>());
    let samples = race.run(41, Duration::from_secs(6));
    let mut row = |case: &str, error: f64, us: f64, target: Option<f64>| {
        findings.rows.push(Row {
            family: "physics",
            case: case.into(),
            method: "default".into(),
            error,
            error_unit: "of the energy",
            median_us: us,
            peer: false,
        });
        if let Some(most) = target {
            findings.words.push(format!(
                "{case}: {}, target {} {}.",
                table::time(us),
                table::time(most),
                if us <= most { "met" } else { "MISSED" }
            ));
        }
    };
    for ((load, error), samples) in loads.iter().zip(errors).zip(&samples) {
        let us = samples.median() / SECONDS as f64;
        row(load.name, error, us, load.target_us);
    }
    let rest = &samples[loads.len()..];
    row(
        "8 wires, 1 s, idle, asked at the end",
        0.0,
        rest[0].median(),
        None,
    );
    row(
        "8 wires, 1 s, idle, unasked",
        0.0,
        rest[1].median(),
        Some(1.0),
    );
    Ok(())
}
