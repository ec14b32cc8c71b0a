//! Cost of eight wires and their finger per simulated second; the error is the energy that the ledger misses.

use std::time::Duration;

use palpate_core::physics::{ParameterError, TissueParameters, WireParameters};
use palpate_emulators::display::wire::Wire;
use palpate_emulators::time::Nanos;

use super::train::{Bursts, Case, START_C, WIRE, ms};
use crate::findings::Findings;
use crate::timing::Race;

const WIRES: usize = 8;
/// Simulated seconds of a sample: construction and first decompositions are spread over them.
const SECONDS: u64 = 10;
/// From the start of one burst to the start of the next.
const SOA: Nanos = Nanos(58_500_000);
/// Most that an idle second may take, microseconds.
const IDLE_US: f64 = 1.0;

/// Power from a time on, W, by wire.
type Edges = Vec<(Nanos, usize, f64)>;

/// Eight equal wires and what drives them.
struct Load {
    name: &'static str,
    wire: WireParameters,
    edges: Edges,
    target_us: Option<f64>,
}

fn loads() -> Result<Vec<Load>, ParameterError> {
    let load = |name, wire, edges, target_us| Load {
        name,
        wire,
        edges,
        target_us,
    };
    let end = ms(1000 * SECONDS);
    let held = Case::held(end)?;
    let all = |case: &Case| -> Edges {
        let each = |&(at, watts): &(Nanos, f64)| (0..WIRES).map(move |wire| (at, wire, watts));
        case.edges.iter().flat_map(each).collect()
    };
    Ok(vec![
        load(
            "8 wires, 1 s, round-robin",
            WIRE,
            bursts(false),
            Some(300.0),
        ),
        load("8 wires, 1 s, all in every burst", WIRE, bursts(true), None),
        load(
            "8 wires, 1 s, phase-cycling at every pulse",
            held.wire,
            all(&held),
            Some(3000.0),
        ),
        load(
            "8 wires, 1 s, all in every burst, loose in their bows",
            WireParameters::FINAL,
            bursts(true),
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
        let make = || Wire::new(&self.wire, &TissueParameters::DEFAULT, START_C);
        let wires = (0..WIRES).map(|_| make());
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

/// Energy that the ledger of a wire misses, relative to the energy that the wire got.
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
    let mut cases = Vec::new();
    let mut race = Race::default();
    for load in &loads {
        // At the start everything is at 33 C, where neither store counts anything: martensite, no latent heat.
        let mut wires = load.run()?;
        let error = wires.iter_mut().map(missing).fold(0.0, f64::max);
        cases.push((load.name, error, load.target_us));
        race.enter(move || load.run().map(|w| w.len()));
    }
    let idle = loads[0].wires()?;
    race.enter(move || idle.iter().map(|w| w.now().0).sum::<u64>());
    cases.push(("8 wires, 1 s, idle", 0.0, Some(IDLE_US)));
    let samples = race.run(41, Duration::from_secs(6));
    for (i, ((case, error, target), samples)) in cases.into_iter().zip(&samples).enumerate() {
        let seconds = if i < loads.len() { SECONDS } else { 1 };
        let us = samples.median() / seconds as f64;
        findings.row(case, "default", (error, "of the energy"), us);
        if let Some(most) = target {
            findings.target(case, us, most);
        }
    }
    Ok(())
}
