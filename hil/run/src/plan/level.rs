//! The level at which a contact shall be felt, against the level that the limits leave one wire.

use palpate_core::guard::Guard;
use palpate_core::projector::Projector;
use palpate_core::render::RenderSettings;
use palpate_emulators::person::channels::Levels;
use palpate_files::{Setup, Wearer};

use super::response::Bursts;
use crate::failure::Failure;

/// Decibels of a part of an amplitude.
pub(crate) fn decibels(part: f32) -> f64 {
    20.0 * libm::log10(f64::from(part))
}

/// Sets full level to the one that the scene asks for. `settings` come with full level at the wearer's threshold.
///
/// # Errors
/// A wearer who feels nothing of one wire at the limits, and a level that it never has.
pub(super) fn ask(
    setup: &Setup,
    guard: &Guard,
    wires: usize,
    settings: &mut RenderSettings,
) -> Result<(), Failure> {
    let most_db = decibels(settings.borne(guard, wires).once).max(Levels::SILENT.db());
    let bench = &setup.bench.value.name;
    let wearer = setup.wearer.as_ref();
    let stated = |wearer: &Wearer| match (wearer.vibration_um, wearer.flutter_um) {
        (Some(_), _) => Some("vibration_um"),
        (None, Some(_)) => Some("flutter_um"),
        (None, None) => None,
    };
    let wearer = wearer.and_then(|w| Some((w, stated(&w.value)?)));
    if let Some((wearer, key)) = wearer.filter(|_| most_db < 0.0) {
        let expected = format!(
            "a wearer who feels one wire of bench `{bench}` at the limits: {:.1} dB are missing",
            -most_db
        );
        return Err(wearer.source.bad(key, expected).into());
    }
    settings.full = match setup.scene.value.illusion.level_db {
        None => settings.response.largest(),
        Some(db) if db > most_db => {
            let source = &setup.scene.source;
            let expected = match most_db > 0.0 {
                true => format!(
                    "at most {most_db:.1} dB, the most that one wire of bench `{bench}` ever has within the limits"
                ),
                false => format!(
                    "nothing: at the limits one wire of bench `{bench}` is {:.1} dB below the wearer's threshold",
                    -most_db
                ),
            };
            return Err(source.bad("illusion.level_db", expected).into());
        }
        Some(db) => settings.full * libm::pow(10.0, db / 20.0) as f32,
    };
    Ok(())
}

/// Level of the emulated person over threshold where one wire has the widest pulses that the guard passes, dB, in
/// bursts as the loop times them.
///
/// # Errors
/// [`Failure::Input`] for a wire or person that cannot be.
pub(crate) fn strongest(setup: &Setup, projector: &Projector) -> Result<f64, Failure> {
    let (guard, timing) = (projector.guard(), projector.timing());
    let pulses = (timing.duration.as_micros() * 1000).div_ceil(guard.prescale().period_ns());
    let bursts = Bursts::new(setup, super::emulated_person(setup))?;
    let [.., felt] = bursts.felt(guard.widest(), guard.prescale(), (pulses, timing.soa));
    Ok(felt.map_or(Levels::SILENT, |felt| felt.levels).db())
}
