//! Pulses of eight wires: what a PWM period costs, and how far a minute's density is from (3.1).

use std::hint::black_box;

use palpate_core::contact::Levels;
use palpate_core::schedule::Stimulus;
use palpate_core::texture::{Control, Draw, Pulses};
use palpate_core::units::{Board, Duration, Instant, Milliamps, Prescale, Ticks};

use super::{FAMILY, Samples};
use crate::bench::Row;
use crate::bench::timing::Race;
use crate::failure::Failure;
use crate::{clock, plan};
use palpate_files::{Setup, load_activation};

pub(super) const CASE: &str = "a PWM period, 8 wires";
/// The thimble's wires, in gaps along the finger.
const GAPS: [f32; 8] = [0.0, 1.0, 2.0, 3.0, 1.0, 2.0, 1.0, 2.0];
/// Periods of a sample.
const PERIODS: u64 = 1000;

/// Both draws.
///
/// # Errors
/// None with the shipped file.
pub(super) fn measure() -> Result<Vec<Row>, Failure> {
    let file = load_activation("assumed")?.value;
    let activation = file
        .activation()
        .ok_or_else(|| Failure::Input("activation `assumed`: expected a sum below 1".into()))?;
    let carrier = Prescale::new(30);
    // Every period is one of f_PWM: the dearest there is.
    let control = Control {
        delta_mu: Duration::from_millis(100),
        sigma: Duration::from_millis(30),
        rate_mhz: 200_000,
    };
    let draws = [
        ("Bernoulli", Draw::Bernoulli),
        ("error diffusion", Draw::Diffusion),
    ];
    let mut race = Race::default();
    let make = |draw| Pulses::new(activation, draw, carrier, &GAPS, 1);
    for (_, draw) in draws {
        let mut pulses = make(draw);
        race.enter(move || {
            (0..PERIODS).fold(0, |sum, _| sum + usize::from(pulses.next(&control)[0]))
        });
    }
    let samples = race.run(200, std::time::Duration::from_secs(2));
    let row = |((name, draw), samples): ((&str, Draw), &Samples)| {
        let mut pulses = make(draw);
        let (mut found, mut expected) = (0.0, 0.0);
        while pulses.at() < Instant::from_micros(60_000_000) {
            let within = pulses.at().as_micros() % (file.interval_ms * 1e3) as u64;
            let within = Duration::from_micros(within);
            expected += GAPS
                .iter()
                .map(|&gap| activation.probability(within, gap, &control))
                .sum::<f64>();
            found += pulses.next(&control).iter().filter(|fired| **fired).count() as f64;
        }
        Row {
            family: FAMILY,
            case: CASE.into(),
            method: name.into(),
            error: (found - expected).abs() / expected,
            error_unit: "of a minute's pulses",
            median_us: samples.median() / PERIODS as f64,
            peer: false,
        }
    };
    let mut rows: Vec<Row> = draws.into_iter().zip(&samples).map(row).collect();
    rows.push(guarded(make(Draw::Bernoulli), &control)?);
    Ok(rows)
}

/// A period of a texture through the guard: whether wires have time, and the stimuli of those that do.
fn guarded(mut pulses: Pulses, control: &Control) -> Result<Row, Failure> {
    let plan = plan::untextured(&Setup::load("texture-wood", "emulated")?, 1, Levels::Off)?;
    let mut guard = plan.guard;
    let mut samples = Samples::default();
    let mut stimuli = Vec::with_capacity(GAPS.len());
    let mut begun = clock::now();
    for period in 1..=50 * PERIODS {
        let at = pulses.at();
        let fired = pulses.next(control);
        stimuli.clear();
        let until = at + Duration::from_micros(5_079);
        let wires = fired.iter().zip(0..).filter(|(fired, _)| **fired);
        stimuli.extend(
            wires
                .filter(|(_, wire)| guard.has_time(usize::from(*wire), at, until))
                .map(|(_, wire)| Stimulus {
                    wire,
                    width: Ticks::new(60),
                    peak: Milliamps(990),
                    at,
                    until,
                }),
        );
        guard.hear(at);
        black_box(guard.admit(at, Board(0), &stimuli, |entry| {
            black_box(entry);
        }));
        if period.is_multiple_of(PERIODS) {
            samples.push(begun.elapsed().as_secs_f64() * 1e6 / PERIODS as f64);
            begun = clock::now();
        }
    }
    Ok(Row {
        family: FAMILY,
        case: CASE.into(),
        method: "Bernoulli, and the guard".into(),
        error: f64::NAN,
        error_unit: "",
        median_us: samples.median(),
        peer: false,
    })
}
