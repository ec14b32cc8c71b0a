//! What a wire makes of a pulse, by its width: the model of a run's own wire, felt by the model of a run's own person.

use palpate_core::guard::Guard;
use palpate_core::render::{Pattern, Response};
use palpate_core::units::Ticks;
use palpate_emulators::display::wire::Wire;
use palpate_emulators::person::channels::Perceiver;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::START_C;
use palpate_files::Setup;

use crate::failure::Failure;

/// So many widths are computed; between two of them the amplitude is taken to be straight.
const SAMPLES: u16 = 12;
/// Bursts before the one that counts: wire and tissue have got warm.
const BEFORE: u64 = 7;

/// A setup's wire on a finger, at rest, whose motion is kept for a person to feel.
pub(crate) fn felt_wire(setup: &Setup) -> Result<Wire, Failure> {
    let (bench, wire) = (&setup.bench.value, super::wire(setup));
    let tissue = bench.tissue.parameters();
    let alone = Wire::new(&wire, &tissue, START_C).and_then(|wire| wire.worn(&tissue));
    let mut alone = alone.map_err(|e| Failure::Input(format!("bench `{}`: {e}", bench.name)))?;
    alone.keep_stretches();
    Ok(alone)
}

/// Amplitudes by width: the root of the filtered energy per pulse, of bursts that come again and again.
pub(super) fn response(
    setup: &Setup,
    guard: &Guard,
    pattern: &Pattern,
) -> Result<Response, Failure> {
    let widest = guard.widest().get();
    let bench = &setup.bench.value;
    let wire = felt_wire(setup)?;
    let perceiver = Perceiver::new(super::person(&setup.person.value), &[(0.0, 0.0)])
        .map_err(|e| Failure::Input(format!("bench `{}`: {e}", bench.name)))?;
    let amps = bench.drive.current_ma * 1e-3;
    let mut known = vec![(0, 0.0)];
    for sample in 1..=SAMPLES {
        let width = (u32::from(widest) * u32::from(sample)).div_ceil(u32::from(SAMPLES)) as u16;
        if known.last().is_none_or(|(last, _)| width > *last) {
            let worn = (wire.clone(), perceiver.clone());
            known.push((width, amplitude(worn, amps, pattern, Ticks::new(width))));
        }
    }
    let between = |pair: &[(u16, f32)]| {
        let [(from, low), (to, high)] = [pair[0], pair[1]];
        (from..to).map(move |w| low + (high - low) * f32::from(w - from) / f32::from(to - from))
    };
    let amplitudes = known.windows(2).flat_map(between);
    let last = known.last().map(|(_, amplitude)| *amplitude);
    Ok(Response::new(amplitudes.chain(last).collect()))
}

fn amplitude(
    (mut wire, mut perceiver): (Wire, Perceiver),
    amps: f64,
    pattern: &Pattern,
    width: Ticks,
) -> f32 {
    let (prescale, pulses) = (pattern.prescale(), pattern.pulses(false));
    let wide = Nanos(u64::from(width.get()) * prescale.tick_ns());
    let soa = pattern.timing().soa.as_micros();
    for burst in 0..=BEFORE {
        let start = Nanos::from_micros(burst * soa);
        if burst == BEFORE {
            wire.take_stretches(start, |stretch| perceiver.pass(0, stretch));
            perceiver.onset();
        }
        for pulse in 0..u64::from(pulses) {
            let at = start + Nanos(pulse * prescale.period_ns());
            wire.set_current(at, amps);
            wire.set_current(at + wide, 0.0);
        }
    }
    let end = Nanos::from_micros((BEFORE + 1) * soa);
    wire.take_stretches(end, |stretch| perceiver.pass(0, stretch));
    perceiver.settle();
    let energy = perceiver.felt(START_C).map_or(0.0, |felt| felt.energy);
    libm::sqrt(energy / f64::from(pulses)) as f32
}
