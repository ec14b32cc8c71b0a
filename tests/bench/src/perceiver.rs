//! Cost of the model of a person beside the wires that it feels, and its exactness beside another integrator.

use std::time::Duration;

use ode_solvers::dop853::Dop853 as Integrator;
use ode_solvers::{OutputType, SVector, System};
use palpate_core::physics::{ParameterError, TissueParameters, WireParameters};
use palpate_core::units::Prescale;
use palpate_emulators::display::finger::NODES;
use palpate_emulators::display::solver::stretch::Stretch;
use palpate_emulators::display::wire::Wire;
use palpate_emulators::person::channels::{Perceiver, Person};
use palpate_emulators::time::Nanos;
use palpate_run::Failure;

use crate::findings::Findings;
use crate::plot::{Mark, Plot, Series};
use crate::timing::Race;

/// Wires of the display, and how many of them every onset drives.
const WIRES: usize = 8;
const DRIVEN: usize = 3;
/// From onset to onset, and until when.
const SOA: Nanos = Nanos(58_500_000);
const END: Nanos = Nanos(1_000_000_000);
const AMPS: f64 = 0.99;
/// A loose wire, as on the default bench: its phases turn within each pulse.
const WIRE: WireParameters = WireParameters::FINAL;
const PERSON: Person = Person {
    vibration_um: 0.26,
    flutter_um: 5.0,
    np2_um: None,
    growth: [0.7, 1.0],
};
/// Tolerances of the other integrator.
const TOLERANCES: [f64; 4] = [1e-3, 1e-5, 1e-7, 1e-9];
/// The one of what all are held against.
const TRUTH: f64 = 1e-11;

/// Edges of the current, in the order of time.
type Edges = Vec<(Nanos, usize, f64)>;

/// Bursts of seven pulses on `driven` of `wires` wires at every onset, staggered and of unlike widths.
fn edges(wires: usize, driven: usize) -> Edges {
    let prescale = Prescale::new(30);
    let mut out = Vec::new();
    let mut start = Nanos::ZERO;
    while start + SOA <= END {
        let turn = (start.0 / SOA.0) as usize;
        for part in 0..driven {
            let wire = (turn + part) % wires;
            let width = Nanos(prescale.tick_ns() * (100 - 9 * (turn + 5 * part) as u64 % 70));
            for pulse in 0..7 {
                let at = start + Nanos(pulse * prescale.period_ns() + 700_000 * part as u64);
                out.push((at, wire, AMPS));
                out.push((at + width, wire, 0.0));
            }
        }
        start = start + SOA;
    }
    out.sort_by_key(|edge| edge.0);
    out
}

fn wires(count: usize, kept: bool) -> Result<Vec<Wire>, ParameterError> {
    let make = |_| {
        let tissue = TissueParameters::DEFAULT;
        // With its burn integrals, as on the emulated display.
        let mut wire = Wire::new(&WIRE, &tissue, 33.0)?.with_dose().worn(&tissue)?;
        if kept {
            wire.keep_stretches();
        }
        Ok(wire)
    };
    (0..count).map(make).collect()
}

/// Heat alone: what the person's model is held against.
fn heat(edges: &Edges, mut wires: Vec<Wire>) -> Vec<Wire> {
    for &(at, wire, amps) in edges {
        wires[wire].set_current(at, amps);
    }
    wires.iter_mut().for_each(|wire| wire.advance(END));
    wires
}

/// All stretches by wire.
fn stretches(edges: &Edges, count: usize) -> Result<Vec<Vec<Stretch>>, ParameterError> {
    let mut wires = heat(edges, wires(count, true)?);
    let take = |wire: &mut Wire| {
        let mut taken = Vec::new();
        wire.take_stretches(END, |stretch| taken.push(*stretch));
        taken
    };
    Ok(wires.iter_mut().map(take).collect())
}

fn perceive(stretches: &[Vec<Stretch>]) -> Result<Perceiver, ParameterError> {
    let mut perceiver = Perceiver::new(PERSON, &vec![(0.0, 0.0); stretches.len()])?;
    for (wire, all) in stretches.iter().enumerate() {
        all.iter().for_each(|stretch| perceiver.pass(wire, stretch));
    }
    perceiver.settle();
    Ok(perceiver)
}

/// The Pacinian filter as two band passes in a row, y'' + w y' + w^2 y = w x' each, and the leaky energy.
struct Channel<'a>(&'a Stretch);

/// The first band pass's slope and value, the second's, and the energy; then the slope of the wire's temperature by
/// rate: as states, since the integrator loses its order where the right side depends on time.
type State = SVector<f64, STATES>;
const STATES: usize = OWN + NODES;
const OWN: usize = 5;

impl System<f64, State> for &Channel<'_> {
    fn system(&self, _t: f64, y: &State, dy: &mut State) {
        let w = std::f64::consts::TAU * 250.0;
        let mut slope = 0.0;
        for (n, rate) in (OWN..).zip(self.0.rates) {
            slope += y[n];
            dy[n] = -rate * y[n];
        }
        dy[0] = w * (self.0.um_per_k * slope - y[0] - w * y[1]);
        dy[1] = y[0];
        dy[2] = w * (y[0] - y[2] - w * y[3]);
        dy[3] = y[2];
        dy[4] = (2.0 * y[3] * y[3] - y[4]) / 0.2;
    }
}

/// Leaky energy at the end by the other integrator, restarted at every stretch: it steps across edges otherwise.
fn integrated(stretches: &[Stretch], tolerance: f64) -> Result<f64, String> {
    let mut y = State::zeros();
    for stretch in stretches {
        let (channel, end) = (Channel(stretch), stretch.seconds);
        (OWN..)
            .zip(stretch.slopes)
            .for_each(|(n, slope)| y[n] = slope);
        let mut method = Integrator::from_param(
            &channel,
            0.0,
            end,
            end,
            y,
            tolerance,
            tolerance * 0.1,
            0.9,
            0.0,
            0.333,
            6.0,
            end,
            0.0,
            1_000_000,
            u32::MAX, // no test for stiffness: it would end the run
            OutputType::Sparse,
        );
        method.integrate().map_err(|e| e.to_string())?;
        y = *method.y_out().last().ok_or("no output")?;
    }
    Ok(y[4])
}

/// Times and errors of the family.
///
/// # Errors
/// A wire or a person that cannot be computed.
pub fn measure() -> Result<Findings, Failure> {
    let mut findings = Findings::new("perceiver");
    beside_heat(&mut findings).map_err(|e| Failure::Input(e.to_string()))?;
    beside_peers(&mut findings).map_err(Failure::Input)?;
    Ok(findings)
}

/// The person's share of a second of the display.
fn beside_heat(findings: &mut Findings) -> Result<(), ParameterError> {
    let edges = edges(WIRES, DRIVEN);
    let stretches = stretches(&edges, WIRES)?;
    let mut race = Race::default();
    race.enter(|| wires(WIRES, false).map(|wires| heat(&edges, wires).len()));
    race.enter(|| perceive(&stretches).map(|p| p.energy()));
    let samples = race.run(41, Duration::from_secs(6));
    let [heat_us, felt_us] = [samples[0].median(), samples[1].median()];
    let case = format!("{WIRES} wires, 1 s, {DRIVEN} in every burst");
    findings.row(&case, "heat of wires and tissue", (f64::NAN, ""), heat_us);
    findings.row(&case, "default", (f64::NAN, ""), felt_us);
    findings.target("the person beside the heat", felt_us, heat_us);
    Ok(())
}

/// One wire's second against the same filter by another integrator.
fn beside_peers(findings: &mut Findings) -> Result<(), String> {
    let edges = edges(1, 1);
    let stretches = stretches(&edges, 1).map_err(|e| e.to_string())?;
    let truth = integrated(&stretches[0], TRUTH)?;
    let apart = |energy: f64| (energy / truth - 1.0).abs();
    let perceive = || perceive(&stretches).map(|p| p.energy());
    let ours = apart(perceive().map_err(|e| e.to_string())?);
    let errors = TOLERANCES.map(|tolerance| integrated(&stretches[0], tolerance).map(apart));
    let mut race = Race::default();
    race.enter(perceive);
    for tolerance in TOLERANCES {
        let stretches = &stretches;
        race.enter(move || integrated(&stretches[0], tolerance));
    }
    let samples = race.run(21, Duration::from_secs(6));
    let (case, unit) = ("1 wire, 1 s, a burst every 58.5 ms", "of the leaky energy");
    findings.row(case, "default", (ours, unit), samples[0].median());
    let mut swept = Vec::new();
    for ((tolerance, error), samples) in TOLERANCES.iter().zip(errors).zip(&samples[1..]) {
        let (error, us) = (error?, samples.median());
        let method = format!("ode_solvers DOP853, {tolerance:e}");
        findings.peer(case, &method, (error, unit), us);
        swept.push((us, error));
    }
    let ours = vec![(samples[0].median(), ours)];
    let series = vec![
        Series::new("closed form and Gauss's rule", Mark::Ours, ours),
        Series::new("DOP853", Mark::Swept, swept),
    ];
    let plot = Plot::work_precision("relative error of the leaky energy", series);
    findings.figures.push(plot.figure(
        "filter",
        "One wire's leaky energy",
        "One second of bursts. The other integrator is restarted at every edge; its reference has a tolerance of 1e-11.",
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    //! Another integrator finds the same.

    use super::*;

    #[test]
    fn the_filter_agrees_with_another_integrator() {
        let stretches = stretches(&edges(1, 1), 1).unwrap();
        let truth = integrated(&stretches[0], TRUTH).unwrap();
        let found = perceive(&stretches).unwrap().energy();
        let apart = (found / truth - 1.0).abs();
        assert!(apart < 1e-6, "{apart}");
    }
}
