//! Sessions of one's own, without an end: on an emulated skin that a scene or a hand touches, or fed with readings.
//!
//! Events wait until they are drained. Where they are not, the oldest are dropped, so a session that is held for
//! days stays as large as it is.

use palpate_core::skin::{ModuleScan, ScanError, UskinCan};
use palpate_emulators::sensor::Press;
use palpate_emulators::sensor::can::faults::Faulty;
use palpate_emulators::sensor::rig::Handle;
use palpate_files::Setup;
use palpate_records::trace::Event;

use crate::display_end::{DisplayEnd, EmulatedDisplay};
use crate::failure::Failure;
use crate::hand::Hand;
use crate::levels::dynamic_levels;
use crate::policy::Policy;
use crate::recorder::{Recorder, Truth};
use crate::runner::build;
use crate::session::Session;
use crate::skin_end::{SkinEnd, Tap};
use crate::{plan, skin};

/// Events that wait to be drained at most: a minute or two of touches, 6 MB.
const MOST_EVENTS: usize = 1 << 16;

/// A session on emulated boards and an emulated display.
pub type EmulatedSession = Session<UskinCan<Tap<Faulty<Handle>>>, EmulatedDisplay>;
/// A session that readings are pushed into, on an emulated display.
pub type FedSession = Session<(), EmulatedDisplay>;

impl EmulatedSession {
    /// A setup's scene with its touches and faults, run by the policy of any bench.
    ///
    /// # Errors
    /// [`Failure::Input`] for what fits no emulated hardware.
    pub fn scene(setup: &Setup, seed: u64, policy: Policy) -> Result<Self, Failure> {
        let truth = Truth::of(setup);
        let layout = plan::layout(&setup.sensor.value)?;
        let boards = skin::emulated(setup, &layout, seed)?;
        Self::on(setup, seed, boards, truth, policy)
    }

    /// A setup's hardware under a hand, which presses on every module as [`Hand::press`] says. The scene's own
    /// touches do not come. One hand per module, in the order of the layout.
    ///
    /// # Errors
    /// [`Failure::Input`] for what fits no emulated hardware.
    pub fn touched(setup: &Setup, seed: u64) -> Result<(Self, Vec<Hand>), Failure> {
        let layout = plan::layout(&setup.sensor.value)?;
        let hands: Vec<Hand> = layout.modules().iter().map(|_| Hand::default()).collect();
        let boards = skin::under(setup, &layout, seed, |module| {
            Box::new(hands[module].clone())
        })?;
        let truth = hands.get(setup.scene.value.drives).cloned();
        let truth = truth.map_or(Truth::Unknown, Truth::Hand);
        let policy = Policy::emulated(setup.bench.value.unit.is_some());
        let session = Self::on(setup, seed, boards, truth, policy)?;
        Ok((session, hands))
    }

    fn on(
        setup: &Setup,
        seed: u64,
        boards: Handle,
        truth: Truth,
        policy: Policy,
    ) -> Result<Self, Failure> {
        let projector = build(setup, seed, dynamic_levels(&setup.scene.value.compression))?;
        let bus = Tap::new(Faulty::new(boards, seed, "sensor bus"), false);
        let skin = skin::source(setup, projector.layout(), bus);
        let display = EmulatedDisplay::new(setup, &projector, seed)?;
        let recorder = Recorder::new(truth, projector.layout()).bounded(MOST_EVENTS);
        Ok(Self::new(
            projector,
            (skin, display),
            policy,
            recorder,
            None,
        ))
    }
}

impl FedSession {
    /// A setup's loop and emulated display, for readings of any skin.
    ///
    /// # Errors
    /// [`Failure::Input`] for what fits no loop.
    pub fn fed(setup: &Setup, seed: u64) -> Result<Self, Failure> {
        let projector = build(setup, seed, dynamic_levels(&setup.scene.value.compression))?;
        let display = EmulatedDisplay::new(setup, &projector, seed)?;
        let recorder = Recorder::new(Truth::Unknown, projector.layout()).bounded(MOST_EVENTS);
        let ends = ((), display);
        let policy = Policy::emulated(setup.bench.value.unit.is_some());
        Ok(Self::new(projector, ends, policy, recorder, None))
    }

    /// Takes one module's scan; what it makes due happens with the next turn.
    ///
    /// # Errors
    /// A scan that is not of the setup's layout; nothing has changed then.
    pub fn push(&mut self, scan: &ModuleScan<'_>) -> Result<(), ScanError> {
        let (_, projector, recorder) = self.all();
        projector.push(scan, recorder)
    }
}

impl<S: SkinEnd, D: DisplayEnd> Session<S, D> {
    /// What happened since the last time, in the order in which it was noticed, and how many events before that were
    /// dropped because nothing drained them.
    pub fn drain(&mut self) -> (Vec<Event>, u64) {
        let recorder = self.recorder();
        (
            std::mem::take(&mut recorder.events),
            std::mem::take(&mut recorder.dropped),
        )
    }
}

/// A press of `force_n` by something round, `diameter_mm` wide, at a place on a module.
#[must_use]
pub const fn press(x_mm: f32, y_mm: f32, force_n: f64, diameter_mm: f64) -> Press {
    Press {
        at: palpate_core::units::Point::new(x_mm, y_mm),
        force_n,
        diameter_mm,
    }
}
