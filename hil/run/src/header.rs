//! Header of a run's trace: scene, bench, seed, and the files that the run goes back to.

use palpate_core::illusion::DisplayWire;
use palpate_core::projector::Projector;
use palpate_records::digest::short_digest;
use palpate_records::mcap::Attachment;
use palpate_records::trace::{self, Header, PlaceUm, WireInfo};

use crate::failure::Failure;
use crate::plan;
use palpate_files::{BenchKind, Setup, Source};

/// The files that a run goes back to, as they were read, and `changes.toml` where options had changed them.
pub fn attachments(setup: &Setup) -> Vec<Attachment> {
    let attached = |(name, source): (String, &Source)| Attachment {
        name: format!("{name}.toml"),
        media_type: "application/toml",
        text: source.text().into(),
    };
    let mut attached: Vec<_> = files(setup).into_iter().map(attached).collect();
    attached.extend(setup.changes().map(|text| Attachment {
        name: "changes.toml".into(),
        media_type: "application/toml",
        text,
    }));
    attached
}

/// The files that a run goes back to, by their names without an ending.
pub(crate) fn files(setup: &Setup) -> Vec<(String, &Source)> {
    let files = [
        ("scene", &setup.scene.source),
        ("sensor", &setup.sensor.source),
        ("bench", &setup.bench.source),
        ("display", &setup.display.source),
        ("limits", &setup.limits.source),
        ("wire", &setup.wire.source),
        ("alloy", &setup.alloy.source),
        ("person", &setup.person.source),
    ];
    let wearer = setup.wearer.as_ref().map(|w| ("wearer", &w.source));
    let own = files.into_iter().chain(wearer);
    let own = own.map(|(name, source)| (name.to_owned(), source));
    let of_fingers = setup.fingers.iter().flat_map(|finger| {
        let worn = finger.wearer.as_ref().map(|w| ("wearer", &w.source));
        let files = [
            ("display", &finger.display.source),
            ("person", &finger.person.source),
        ];
        let files = files.into_iter().chain(worn);
        files.map(|(name, source)| (format!("{}-{name}", finger.name), source))
    });
    own.chain(of_fingers).collect()
}

/// Header of a run's trace: scene, bench, files, wires and taxels.
///
/// # Errors
/// [`Failure`] for a bench without a PWM frequency.
pub fn header(setup: &Setup, seed: u64, projector: &Projector) -> Result<Header, Failure> {
    let (scene, bench) = (&setup.scene.value, &setup.bench.value);
    let layout = plan::layout(&setup.sensor.value)?;
    let taxels = layout
        .modules()
        .get(scene.drives)
        .map(palpate_core::skin::Module::points);
    let wire = |w: &DisplayWire| WireInfo {
        place: PlaceUm::from(w.place),
        board: w.board.0,
        channel: w.channel.0,
    };
    Ok(Header {
        source: match bench.kind {
            _ if bench.is_hardware() => trace::Source::Real,
            BenchKind::Emulated if setup.is_observed() => trace::Source::Observed,
            _ => trace::Source::Emulated,
        },
        scene: scene.name.clone(),
        bench: bench.name.clone(),
        seed,
        scene_digest: short_digest(&setup.scene.source.values()),
        limits_digest: short_digest(&setup.limits.source.values()),
        pre_scale: projector.guard().prescale(),
        tau_d_us: projector.timing().duration.as_micros(),
        soa_us: projector.timing().soa.as_micros(),
        person: setup.person.value.name.clone(),
        preset: match &bench.haptics {
            Some(haptics) => haptics.kind.name().to_owned(),
            None => setup.wire.value.name.clone(),
        },
        illusion: scene.illusion.model.name().into(),
        kc: u16::try_from(scene.compression.most_contacts()).unwrap_or(u16::MAX),
        taxels: taxels
            .unwrap_or_default()
            .iter()
            .copied()
            .map(PlaceUm::from)
            .collect(),
        wires: projector.display().wires().iter().map(wire).collect(),
        displays: Vec::new(),
        joints: scene.joints.iter().map(|j| j.name.clone()).collect(),
        warmth: bench.heat.is_some(),
        motors: bench.haptics.is_some(),
    })
}
