//! Pulses of eight wires: what a PWM period costs, and how far a minute's density is from (3.1).

use std::hint::black_box;

use palpate_core::contact::Levels;
use palpate_core::schedule::Stimulus;
use palpate_core::texture::{Control, Draw, Pulses};
use palpate_core::units::{Board, Duration, Instant, Milliamps, Prescale, Ticks};

use palpate_files::{Setup, load_activation};
use palpate_live::clock;
use palpate_run::{Failure, plan};

use crate::findings::{Findings, NO_ERROR};
use crate::timing::{Race, Samples};

const CASE: &str = "a PWM period, 8 wires";
/// The thimble's wires, in gaps along the finger.
const GAPS: [f32; 8] = [0.0, 1.0, 2.0, 3.0, 1.0, 2.0, 1.0, 2.0];
/// Periods of a sample.
const PERIODS: u64 = 1000;

/// Both draws, and the guard after one; the median of a period by the Bernoulli draw comes back, microseconds.
///
/// # Errors
/// None with the shipped file.
pub(super) fn measure(found: &mut Findings) -> Result<f64, Failure> {
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
    let period = |samples: &Samples| samples.median() / PERIODS as f64;
    for ((name, draw), samples) in draws.into_iter().zip(&samples) {
        let mut pulses = make(draw);
        let (mut fired, mut expected) = (0.0, 0.0);
        while pulses.at() < Instant::from_micros(60_000_000) {
            let within = pulses.at().as_micros() % (file.interval_ms * 1e3) as u64;
            let within = Duration::from_micros(within);
            expected += GAPS
                .iter()
                .map(|&gap| activation.probability(within, gap, &control))
                .sum::<f64>();
            fired += pulses.next(&control).iter().filter(|fired| **fired).count() as f64;
        }
        let error = (fired - expected).abs() / expected;
        let error = (error, "of a minute's pulses");
        found.row(CASE, name, error, period(samples));
    }
    let guarded = guarded(make(Draw::Bernoulli), &control)?;
    let method = "Bernoulli, and the guard";
    found.row(CASE, method, NO_ERROR, guarded.median());
    Ok(period(&samples[0]))
}

/// A period of a texture through the guard: whether wires have time, and the stimuli of those that do.
fn guarded(mut pulses: Pulses, control: &Control) -> Result<Samples, Failure> {
    let plan = plan::untextured(
        &Setup::load("texture-wood", "emulated")?,
        1,
        Levels::Off,
        &plan::Responses::default(),
    )?;
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
    Ok(samples)
}
