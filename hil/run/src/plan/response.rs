//! Response of a wire to a pulse, by its width: the model of a run's own wire, felt by the model of a run's own person.

use std::cell::RefCell;

use palpate_core::guard::Guard;
use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_core::render::{Pattern, Response};
use palpate_core::units::{Duration, Prescale, Ticks};
use palpate_emulators::display::wire::Wire;
use palpate_emulators::person::channels::{Felt, Perceiver, Person};
use palpate_emulators::time::Nanos;
use palpate_files::{Both, FeltBy, Setup};

use crate::failure::Failure;

/// Widths that are computed; between two of them the amplitude is taken to be straight.
const SAMPLES: u16 = 12;
/// Bursts before the ones that count. The R phase of a wire ends while its mean temperature rises, and the same pulse then
/// moves it less, so no table by width alone is right at every burst. A contact that moves has a wire for a few bursts: among
/// those tried one burst before keeps level and place best (docs/render.md).
const BEFORE: u64 = 1;
/// Roughnesses, even over their range, of which the response to a texture's passes is computed.
const PASSES: u32 = 5;
/// The square root of 2 pi: the area under a Gaussian of height and spread 1.
const GAUSSIAN: f64 = 2.506_628_274_631;
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

/// Bursts that come again and again.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Series {
    /// Pulses of a burst.
    pub pulses: u64,
    /// Time from pulse to pulse.
    pub spacing: Nanos,
    /// Time from burst to burst.
    pub every: Duration,
}

impl From<&Pattern> for Series {
    /// A vibration.
    fn from(pattern: &Pattern) -> Self {
        Self {
            pulses: u64::from(pattern.pulses(false)),
            spacing: Nanos(pattern.prescale().period_ns()),
            every: pattern.timing().soa,
        }
    }
}

/// Bursts that a scene's texture leaves, from the fewest pulses on; none without a texture. Of a contact's burst some pulses
/// are left out. With the display to itself a texture passes each wire once in the interval of (3.1).
fn woven(setup: &Setup, pattern: &Pattern) -> Vec<Series> {
    let (Some(felt), Some(stroked)) = (&setup.scene.value.texture, &setup.texture) else {
        return Vec::new();
    };
    let whole = Series::from(pattern);
    if felt.carrier == FeltBy::Contacts {
        let length = whole.spacing.0 * (whole.pulses - 1);
        let left = |pulses: u64| Series {
            pulses,
            spacing: Nanos(length / (pulses - 1)),
            every: whole.every,
        };
        return (2..=whole.pulses).map(left).collect();
    }
    let file = &stroked.activation.value;
    let pass = |step: u32| {
        let rough = 1.0 - f64::from(step) / f64::from(PASSES - 1);
        let between = |ends: Both| ends.smooth + (ends.rough - ends.smooth) * rough;
        let carrier_hz = 1e9 / whole.spacing.0 as f64;
        let densest_hz = file.beta * between(file.rate_hz).min(carrier_hz);
        let pulses = densest_hz * GAUSSIAN * between(file.sigma_ms) * 1e-3;
        Series {
            pulses: pulses.round().max(1.0) as u64,
            spacing: Nanos((1e9 / densest_hz.max(1.0)) as u64),
            every: Duration::from_micros((file.interval_ms * 1e3).round() as u64),
        }
    };
    let mut passes: Vec<Series> = (0..PASSES).map(pass).collect();
    passes.sort_by_key(|series| series.pulses);
    passes.dedup_by_key(|series| series.pulses);
    passes
}

/// Inputs of a response.
#[derive(PartialEq)]
struct Question {
    wire: WireParameters,
    tissue: TissueParameters,
    amps: f64,
    person: Person,
    widest: Ticks,
    prescale: Prescale,
    series: Series,
}

/// Responses that are known already. Passes and fingers of one run mostly ask the same.
#[derive(Default)]
pub struct Responses(RefCell<Vec<(Question, FeltResponse)>>);

impl Responses {
    /// The response of a setup's wire, by what the loop believes of its wearer.
    pub(super) fn response(
        &self,
        setup: &Setup,
        guard: &Guard,
        pattern: &Pattern,
    ) -> Result<FeltResponse, Failure> {
        self.to(setup, guard, (pattern.prescale(), pattern.into()))
    }

    /// Responses to the bursts that a scene's texture leaves, each with its number of pulses.
    pub(super) fn woven(
        &self,
        setup: &Setup,
        guard: &Guard,
        pattern: &Pattern,
    ) -> Result<Box<[(u8, Response)]>, Failure> {
        let row = |series: Series| {
            let felt = self.to(setup, guard, (pattern.prescale(), series))?;
            Ok((series.pulses.min(255) as u8, felt.response))
        };
        woven(setup, pattern).into_iter().map(row).collect()
    }

    /// The response to bursts that come again and again.
    fn to(
        &self,
        setup: &Setup,
        guard: &Guard,
        (prescale, series): (Prescale, Series),
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
            prescale,
            series,
        };
        let mut known = self.0.borrow_mut();
        if let Some((_, felt)) = known.iter().find(|(asked, _)| *asked == question) {
            return Ok(felt.clone());
        }
        let felt = response(&Bursts::worn(setup, planned, question.person)?, &question);
        known.push((question, felt.clone()));
        Ok(felt)
    }
}

fn response(bursts: &Bursts, question: &Question) -> FeltResponse {
    let (widest, series) = (question.widest.get(), question.series);
    let (mut known, mut threshold) = (vec![(0, 0.0)], None);
    for sample in 1..=SAMPLES {
        let width = (u32::from(widest) * u32::from(sample)).div_ceil(u32::from(SAMPLES)) as u16;
        if known.last().is_none_or(|(last, _)| width > *last) {
            let felt = bursts.felt(Ticks::new(width), question.prescale, series);
            let amplitudes =
                felt.map(|felt| libm::sqrt(felt.map_or(0.0, |f| f.energy / series.pulses as f64)));
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
        Self::worn(setup, super::worn(setup), person)
    }

    /// Bursts of any wire on any finger with a setup's current.
    fn worn(
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

    /// Sensations of two bursts of pulses of this width, once wire and tissue have got warm.
    pub fn felt(
        &self,
        width: Ticks,
        prescale: Prescale,
        series: Series,
    ) -> [Option<Felt>; COUNTED] {
        let (mut wire, mut perceiver) = (self.wire.clone(), self.perceiver.clone());
        let wide = Nanos(u64::from(width.get()) * prescale.tick_ns());
        let soa = series.every.as_micros();
        let mut burst = |n: u64| {
            let start = Nanos::from_micros(n * soa);
            perceiver.onset();
            for pulse in 0..series.pulses {
                let at = start + Nanos(pulse * series.spacing.0);
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
