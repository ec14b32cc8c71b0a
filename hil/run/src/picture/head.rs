//! The head of a session, from its files and its loop.

use palpate_core::contact::Scope;
use palpate_core::projector::Projector;
use palpate_core::skin::Module;
use palpate_core::units::{Point, Ticks};
use palpate_files::Setup;
use palpate_records::model;
use palpate_records::trace::Header;

use super::{Head, LimitsC, ModuleHead};

pub(super) fn pair(point: Point) -> [f32; 2] {
    [point.x, point.y]
}

/// Modules that a page shows: those whose contacts are found together with the driving one's.
pub(super) fn shown(setup: &Setup, projector: &Projector) -> Vec<usize> {
    let scene = &setup.scene.value;
    match scene.compression.scope {
        Scope::Skin => (0..projector.layout().modules().len()).collect(),
        Scope::Module => vec![scene.drives],
    }
}

/// Centre of a module on the plane that a page shows, mm.
pub(super) fn origin(setup: &Setup, module: &Module) -> [f32; 2] {
    match setup.scene.value.compression.scope {
        Scope::Skin => pair(module.origin()),
        Scope::Module => [0.0; 2],
    }
}

impl Head {
    /// Head of a session of a setup.
    #[must_use]
    pub fn new(setup: &Setup, header: &Header, projector: &Projector) -> Self {
        let scene = &setup.scene.value;
        let layout = projector.layout();
        let module = |number: usize| {
            let module = layout.modules().get(number)?;
            Some(ModuleHead {
                number,
                name: module.name().to_owned(),
                place_mm: origin(setup, module),
                taxels_mm: module.points().iter().copied().map(pair).collect(),
            })
        };
        let guard = projector.guard();
        let (prescale, limits) = (guard.prescale(), guard.limits());
        let celsius = |milli: u64| milli as f64 * 1e-3;
        let spacing = layout.modules().get(scene.drives).map(Module::spacing);
        let surface = setup.display.value.surface;
        Self {
            scene: scene.name.clone(),
            description: scene.description.clone(),
            bench: setup.bench.value.name.clone(),
            source: header.source.words(),
            seed: header.seed,
            skin: setup.sensor.value.name.clone(),
            display: setup.display.value.name.clone(),
            illusion: scene.illusion.model.name(),
            renderer: scene.illusion.render.name(),
            person: setup.person.value.name.clone(),
            wire: header.preset.clone(),
            motors: header.motors,
            contacts_most: scene.compression.most_contacts(),
            observed: setup.is_observed(),
            rate_hz: scene.rate_hz,
            soa_us: header.soa_us,
            tau_d_us: header.tau_d_us,
            period_ns: prescale.period_ns(),
            pwm_hz: 1e9 / prescale.period_ns() as f64,
            pitch_mm: f64::from(spacing.unwrap_or(1.0)),
            quiet_us: quiet_us(setup),
            scene_us: scene_us(setup),
            modules: shown(setup, projector)
                .into_iter()
                .filter_map(module)
                .collect(),
            drives: scene.drives,
            wires_mm: projector
                .display()
                .wires()
                .iter()
                .map(|w| pair(w.place))
                .collect(),
            wire_mm: match &setup.bench.value.haptics {
                Some(haptics) => haptics.face_mm,
                None => setup.wire.value.length_mm,
            },
            finger_mm: surface.map(|s| [s.diameter_mm, s.tip_mm]),
            widest_ticks: match header.motors {
                true => Ticks::PER_PERIOD,
                false => guard.widest().get(),
            },
            limits_c: LimitsC {
                mean: celsius(limits.skin_mean_mc),
                peak: celsius(limits.skin_peak_mc),
                deep: celsius(limits.skin_deep_mc),
            },
            model_c: [model::WIRE_C, model::TISSUE_C],
        }
    }
}

/// Time at which the reference has been taken, microseconds.
fn quiet_us(setup: &Setup) -> u64 {
    let scene = &setup.scene.value;
    let quiet_s = f64::from(scene.reference_frames + 1) / scene.rate_hz;
    (quiet_s * 1e6).ceil() as u64
}

/// Time at which the scene itself is over, microseconds; 0 for one without touches, strokes, faults and texture.
fn scene_us(setup: &Setup) -> u64 {
    let scene = &setup.scene.value;
    let idle = scene.touches.is_empty()
        && scene.strokes.is_empty()
        && scene.faults.is_empty()
        && scene.texture.is_none();
    match idle {
        true => 0,
        false => (scene.length_s * 1e6).ceil() as u64,
    }
}
