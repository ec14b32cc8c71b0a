//! Both ends of a run on paper: the display that is built, the header that says what was run.

use palpate_core::illusion::Wire;
use palpate_core::physics::SkinParameters;
use palpate_core::projector::Projector;
use palpate_emulators::amplifier::AmplifierConfig;
use palpate_emulators::amplifier::supply::Source;
use palpate_emulators::display::{Display, DisplayConfig, Place};
use palpate_emulators::i2c::BusClock;
use palpate_emulators::time::Nanos;
use palpate_records::digest::short_digest;
use palpate_records::mcap::Attachment;
use palpate_records::trace::{self, Header, Limits, WireInfo};

use super::recorder::um;
use crate::failure::Failure;
use crate::plan;
use palpate_files::{BenchKind, Setup};

/// The emulated display of a bench.
pub(crate) fn display(setup: &Setup, wires: &[Wire]) -> Result<Display, Failure> {
    let bench = &setup.bench.value;
    let place = |w: &Wire| Place {
        at: w.place,
        board: w.board.0,
        channel: w.channel.0,
    };
    Display::new(&DisplayConfig {
        boards: plan::boards(bench)
            .into_iter()
            .map(|a| (a, bench.drive.oscillator))
            .collect(),
        wires: wires.iter().map(place).collect(),
        amplifier: AmplifierConfig {
            current: plan::milliamps(bench.drive.current_ma),
            rise: Nanos((bench.amplifier.rise_us * 1e3).round() as u64),
            on_ohm: bench.amplifier.on_ohm,
        },
        source: Source {
            volts: bench.amplifier.supply_v.unwrap_or(f64::INFINITY),
            ohm: bench.amplifier.supply_ohm,
        },
        wire: plan::wire(setup),
        skin: SkinParameters::DEFAULT,
        perceiver: plan::perceiver(&setup.perceiver.value),
        clock: BusClock::Fast,
    })
    .map_err(|e| Failure::Input(format!("bench `{}`: {e}", bench.name)))
}

/// The files that a run goes back to, as they were read.
pub fn attachments(setup: &Setup) -> Vec<Attachment> {
    let files = [
        ("scene", &setup.scene.source),
        ("sensor", &setup.sensor.source),
        ("bench", &setup.bench.source),
        ("display", &setup.display.source),
        ("limits", &setup.limits.source),
        ("wire", &setup.wire.source),
        ("alloy", &setup.alloy.source),
        ("perceiver", &setup.perceiver.source),
    ];
    let wearer = setup.wearer.as_ref().map(|w| ("wearer", &w.source));
    let attached = |(name, source): (&str, &palpate_files::Source)| Attachment {
        name: format!("{name}.toml"),
        media_type: "application/toml",
        text: source.text().into(),
    };
    files.into_iter().chain(wearer).map(attached).collect()
}

/// What was run, on what.
///
/// # Errors
/// [`Failure`] for a bench without a PWM frequency.
pub(super) fn header(setup: &Setup, seed: u64, projector: &Projector) -> Result<Header, Failure> {
    let (scene, bench) = (&setup.scene.value, &setup.bench.value);
    let limits = projector.guard().limits();
    let layout = plan::layout(&setup.sensor.value)?;
    let taxels = layout
        .modules()
        .get(scene.drives)
        .map(palpate_core::skin::Module::points);
    let wire = |w: &Wire| WireInfo {
        place: um(w.place),
        board: w.board.0,
        channel: w.channel.0,
    };
    Ok(Header {
        source: match bench.kind {
            BenchKind::Emulated => trace::Source::Emulated,
            BenchKind::Real => trace::Source::Real,
        },
        scene: scene.name.clone(),
        bench: bench.name.clone(),
        seed,
        scene_digest: short_digest(setup.scene.source.text().as_bytes()),
        limits_digest: short_digest(setup.limits.source.text().as_bytes()),
        pre_scale: plan::prescale(bench)?,
        tau_d_us: projector.timing().duration.as_micros(),
        soa_us: projector.timing().soa.as_micros(),
        illusion: plan::model(scene.illusion.model).name().into(),
        kc: u16::try_from(scene.compression.kc).unwrap_or(u16::MAX),
        limits: Limits {
            pulse_ns: Some(limits.pulse_width_ns),
            burst_us: Some(limits.burst.as_micros()),
            supply_ma: Some(limits.supply.0),
            fingertip_uw: u32::try_from(limits.fingertip_60s_uw).ok(),
            skin_milli_c: None,
        },
        taxels: taxels.unwrap_or_default().iter().copied().map(um).collect(),
        wires: projector.display().wires().iter().map(wire).collect(),
    })
}
