//! Response of a wire to a pulse, by its width: the model of a run's own wire, felt by the model of a run's own person.

use std::cell::RefCell;

use palpate_core::guard::Guard;
use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_core::render::{Pattern, Response};
use palpate_core::units::{Duration, Prescale, Ticks};
use palpate_emulators::display::wire::Wire;
use palpate_emulators::person::channels::{Felt, Perceiver, Person};
use palpate_emulators::time::Nanos;
use palpate_files::Setup;

use crate::failure::Failure;

/// Widths that are computed; between two of them the amplitude is taken to be straight.
const SAMPLES: u16 = 12;
/// Bursts before the ones that count. The R phase of a wire ends while its mean temperature rises, and the same pulse then
/// moves it less, so no table by width alone is right at every burst. A contact that moves has a wire for a few bursts: among
/// those tried one burst before keeps level and place best (docs/render.md).
const BEFORE: u64 = 1;
/// Bursts that count.
const COUNTED: usize = 2;

/// A setup's emulated wire on a finger, at rest, whose motion is kept for a person to feel.
pub(crate) fn felt_wire(setup: &Setup) -> Result<Wire, Failure> {
    kept(setup, super::worn(setup))
}

/// A wire on a finger, at rest, whose motion is kept for a person to feel.
fn kept(
    setup: &Setup,
    (wire, tissue): (WireParameters, TissueParameters),
) -> Result<Wire, Failure> {
    let alone = Wire::new(&wire, &tissue, tissue.body_c).and_then(|wire| wire.worn(&tissue));
    let name = &setup.bench.value.name;
    let mut alone = alone.map_err(|e| Failure::Input(format!("bench `{name}`: {e}")))?;
    alone.keep_stretches();
    Ok(alone)
}

/// Response of a wire to a pulse, and the threshold of its wearer.
#[derive(Clone)]
pub(super) struct FeltResponse {
    /// Amplitudes by width: the root of the filtered energy per pulse, of bursts that come again and again.
    pub response: Response,
    /// The amplitude of which such bursts on one wire are at the wearer's threshold.
    pub threshold: f32,
}

/// Inputs of a response.
#[derive(PartialEq)]
struct Question {
    wire: WireParameters,
    tissue: TissueParameters,
    amps: f64,
    person: Person,
    widest: Ticks,
    pattern: Pattern,
}

/// Responses that are known already. Passes and fingers of one run mostly ask the same.
#[derive(Default)]
pub struct Responses(RefCell<Vec<(Question, FeltResponse)>>);

impl Responses {
    /// The response of a setup's wire, by what the loop believes of its wearer.
    pub(super) fn of(
        &self,
        setup: &Setup,
        guard: &Guard,
        pattern: &Pattern,
    ) -> Result<FeltResponse, Failure> {
        let bench = &setup.bench.value;
        let planned = match setup.drawn {
            Some(drawn) if drawn.is_identified => (drawn.wire, drawn.tissue),
            _ => (super::wire(setup), bench.tissue.parameters()),
        };
        let question = Question {
            wire: planned.0,
            tissue: planned.1,
            amps: bench.drive.current_ma * 1e-3,
            person: super::person::believed(setup)?,
            widest: guard.widest(),
            pattern: *pattern,
        };
        let mut known = self.0.borrow_mut();
        if let Some((_, felt)) = known.iter().find(|(asked, _)| *asked == question) {
            return Ok(felt.clone());
        }
        let felt = response(&Bursts::of(setup, planned, question.person)?, &question);
        known.push((question, felt.clone()));
        Ok(felt)
    }
}

fn response(bursts: &Bursts, question: &Question) -> FeltResponse {
    let (widest, pattern) = (question.widest.get(), &question.pattern);
    let (timing, pulses) = (pattern.timing(), u64::from(pattern.pulses(false)));
    let (mut known, mut threshold) = (vec![(0, 0.0)], None);
    for sample in 1..=SAMPLES {
        let width = (u32::from(widest) * u32::from(sample)).div_ceil(u32::from(SAMPLES)) as u16;
        if known.last().is_none_or(|(last, _)| width > *last) {
            let felt = bursts.felt(Ticks::new(width), pattern.prescale(), (pulses, timing.soa));
            let amplitudes =
                felt.map(|felt| libm::sqrt(felt.map_or(0.0, |f| f.energy / pulses as f64)));
            let [first, second] = amplitudes;
            // Their geometric mean, as levels are in dB.
            let amplitude = libm::sqrt(first * second);
            let db = felt[COUNTED - 1].map_or(0.0, |f| f.levels.db());
            known.push((width, amplitude as f32));
            // Levels go with amplitudes. Narrow pulses, which come first, warm the wire least: bursts there are alike.
            threshold.get_or_insert(amplitude * libm::pow(10.0, -db / 20.0));
        }
    }
    FeltResponse {
        response: Response::between(&known),
        threshold: threshold.map_or(f32::INFINITY, |amplitude| amplitude as f32),
    }
}

/// Bursts on one wire of a setup, alone, as a person feels them.
pub(crate) struct Bursts {
    wire: Wire,
    perceiver: Perceiver,
    amps: f64,
    /// The finger at rest, degrees C.
    rest_c: f64,
}

impl Bursts {
    /// Bursts of a setup's emulated wire and current on `person`.
    pub fn new(setup: &Setup, person: Person) -> Result<Self, Failure> {
        Self::of(setup, super::worn(setup), person)
    }

    /// Bursts of any wire on any finger with a setup's current.
    fn of(
        setup: &Setup,
        worn: (WireParameters, TissueParameters),
        person: Person,
    ) -> Result<Self, Failure> {
        let bench = &setup.bench.value;
        let perceiver = Perceiver::new(person, &[(0.0, 0.0)])
            .map_err(|e| Failure::Input(format!("bench `{}`: {e}", bench.name)))?;
        Ok(Self {
            wire: kept(setup, worn)?,
            perceiver,
            amps: bench.drive.current_ma * 1e-3,
            rest_c: worn.1.body_c,
        })
    }

    /// Sensations of two bursts of `pulses` pulses of this width, once wire and tissue have got warm.
    pub fn felt(
        &self,
        width: Ticks,
        prescale: Prescale,
        (pulses, soa): (u64, Duration),
    ) -> [Option<Felt>; COUNTED] {
        let (mut wire, mut perceiver) = (self.wire.clone(), self.perceiver.clone());
        let wide = Nanos(u64::from(width.get()) * prescale.tick_ns());
        let soa = soa.as_micros();
        let mut burst = |n: u64| {
            let start = Nanos::from_micros(n * soa);
            perceiver.onset();
            for pulse in 0..pulses {
                let at = start + Nanos(pulse * prescale.period_ns());
                wire.set_current(at, self.amps);
                wire.set_current(at + wide, 0.0);
            }
            let end = Nanos::from_micros((n + 1) * soa);
            wire.take_stretches(end, |stretch| perceiver.pass(0, stretch));
            perceiver.settle();
            perceiver.felt(self.rest_c)
        };
        for n in 0..BEFORE {
            burst(n);
        }
        core::array::from_fn(|n| burst(BEFORE + n as u64))
    }
}
