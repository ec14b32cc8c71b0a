//! Sessions of one's own, without an end: on an emulated skin that a scene or a hand touches, or fed with readings.
//!
//! Events wait until they are drained. Where they are not, the oldest are dropped, so a session that is held for
//! days stays as large as it is.

use palpate_core::contact::{Contact, Levels};
use palpate_core::driver::DriverError;
use palpate_core::projector::{ForeignContacts, Projector};
use palpate_core::skin::{ModuleScan, ScanError};
use palpate_core::units::{Duration, Instant};
use palpate_emulators::sensor::Press;
use palpate_files::Setup;
use palpate_records::trace::Event;

use crate::activations::{self, Activations};
use crate::display_end::DisplayEnd;
use crate::emulated_end::EmulatedEnd;
use crate::failure::Failure;
use crate::fingers::Fingers;
use crate::hand::Hand;
use crate::levels::dynamic_levels;
use crate::loops::build;
use crate::picture::{State, Wants};
use crate::policy::Policy;
use crate::recorder::{Recorder, Truth};
use crate::runner::passed;
use crate::session::{Session, Turn};
use crate::skin::EmulatedSkin;
use crate::skin_end::{Elsewhere, SkinEnd};
use crate::wires::EmulatedDisplay;
use crate::wish::Wish;
use crate::{plan, skin};

/// Events that wait to be drained at most: a minute or two of touches, 6 MB.
const MOST_EVENTS: usize = 1 << 16;

/// A session between an emulated skin, or readings that are pushed, and an emulated display of any kind.
pub type SessionOn<D> = Session<EmulatedSkin, D>;
/// Such a session on wires.
pub type EmulatedSession = SessionOn<EmulatedDisplay>;
/// A session that contacts are handed to, on a display of any kind.
pub type HeldSession<D = EmulatedDisplay> = Session<Elsewhere, D>;

impl<D: EmulatedEnd> SessionOn<D> {
    /// A setup's scene with its touches and faults, run by the policy of any bench.
    ///
    /// # Errors
    /// [`Failure::Input`] for what fits no emulated hardware.
    pub fn scene(setup: &Setup, seed: u64, policy: Policy) -> Result<Self, Failure> {
        let (setup, _) = passed(setup, seed)?;
        let setup = &*setup;
        let truth = Truth::of_scene(setup);
        let skin = skin::scene(setup, seed, None)?;
        Self::on(setup, seed, of_setup(setup, seed)?, (skin, truth), policy)
    }

    /// A setup's scene with its touches and faults, and fingers that join them while it runs. The scene's end is no end
    /// here. A run of the scene with [`Fingers::touches`] among its own, and dynamic levels, comes to the same bits.
    ///
    /// # Errors
    /// [`Failure::Input`] for what fits no emulated hardware.
    pub fn played(setup: &Setup, seed: u64) -> Result<(Self, Fingers), Failure> {
        let (setup, _) = passed(setup, seed)?;
        let setup = &*setup;
        let fingers = Fingers::default();
        let skin = skin::scene(setup, seed, Some(&fingers))?;
        let truth = Truth::played(setup, &fingers);
        let policy = Policy::emulated(setup.bench.value.unit.is_some());
        let projector = of_setup(setup, seed)?;
        let session = Self::on(setup, seed, projector, (skin, truth), policy)?;
        Ok((session, fingers))
    }

    /// A setup's hardware under a hand, which presses on every module as [`Hand::press`] says. The scene's own
    /// touches do not come. One hand per module, in the order of the layout.
    ///
    /// # Errors
    /// [`Failure::Input`] for what fits no emulated hardware.
    pub fn touched(setup: &Setup, seed: u64) -> Result<(Self, Vec<Hand>), Failure> {
        let (setup, _) = passed(setup, seed)?;
        let setup = &*setup;
        let projector = of_setup(setup, seed)?;
        Self::under_hands(setup, seed, projector)
    }

    /// A session with activations from outside in place of the scene's illusion.
    ///
    /// # Errors
    /// Errors of [`Self::touched`]; a scene whose illusion chooses pulses by itself.
    pub fn activated(setup: &Setup, seed: u64) -> Result<(Self, Vec<Hand>, Activations), Failure> {
        let (setup, _) = passed(setup, seed)?;
        let setup = &*setup;
        let levels = dynamic_levels(&setup.scene.value.compression);
        let (projector, activations) = activations::build(setup, seed, levels)?;
        let (mut session, hands) = Self::under_hands(setup, seed, projector)?;
        session.recorder().counts = Some(Vec::new());
        Ok((session, hands, activations))
    }

    fn under_hands(
        setup: &Setup,
        seed: u64,
        projector: Projector,
    ) -> Result<(Self, Vec<Hand>), Failure> {
        let layout = plan::layout(&setup.sensor.value)?;
        let hands: Vec<Hand> = layout.modules().iter().map(|_| Hand::default()).collect();
        let skin = skin::under_hands(setup, &layout, seed, &hands)?;
        let truth = hands.get(setup.scene.value.drives).cloned();
        let truth = truth.map_or(Truth::Unknown, Truth::Hand);
        let policy = Policy::emulated(setup.bench.value.unit.is_some());
        let session = Self::on(setup, seed, projector, (skin, truth), policy)?;
        Ok((session, hands))
    }

    /// A setup's loop and emulated display, for readings of any skin.
    ///
    /// # Errors
    /// [`Failure::Input`] for what fits no loop.
    pub fn fed(setup: &Setup, seed: u64) -> Result<Self, Failure> {
        let (setup, _) = passed(setup, seed)?;
        let setup = &*setup;
        let policy = Policy::emulated(setup.bench.value.unit.is_some());
        let ends: (EmulatedSkin, Truth) = (Box::new(()), Truth::Unknown);
        Self::on(setup, seed, of_setup(setup, seed)?, ends, policy)
    }

    /// Takes one module's scan; stimuli that it makes due follow with the next turn.
    ///
    /// # Errors
    /// A scan that is not of the setup's layout; nothing has changed then.
    pub fn push(&mut self, scan: &ModuleScan<'_>) -> Result<(), ScanError> {
        let (_, projector, recorder) = self.all();
        projector.push(scan, recorder)
    }

    fn on(
        setup: &Setup,
        seed: u64,
        projector: Projector,
        (skin, truth): (EmulatedSkin, Truth),
        policy: Policy,
    ) -> Result<Self, Failure> {
        let display = D::at_rest(setup, &projector, seed)?;
        let mut recorder = Recorder::new(truth, projector.layout()).bounded(MOST_EVENTS);
        recorder.begin(setup);
        let mut session = Self::new(projector, (skin, display), policy, recorder, None);
        session.plan_passes(setup);
        Ok(session)
    }
}

/// A session on an emulated display, for a holder that serves benches of wires and of motors alike.
pub trait Live: Send {
    /// Starts as [`Session::start`] does.
    ///
    /// # Errors
    /// A board that does not answer.
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError>;

    /// Takes a turn as [`Session::turn`] does.
    ///
    /// # Errors
    /// An emulator that contradicts itself.
    fn turn(&mut self, now: Instant) -> Result<Turn, Failure>;

    /// Takes the turns before `until` as [`Session::advance`] does.
    ///
    /// # Errors
    /// An emulator that contradicts itself.
    fn advance(&mut self, until: Instant) -> Result<Turn, Failure>;

    /// Takes one module's scan as [`EmulatedSession::push`] does.
    ///
    /// # Errors
    /// A scan that is not of the setup's layout.
    fn push(&mut self, scan: &ModuleScan<'_>) -> Result<(), ScanError>;

    /// Grants a wish now, or refuses it; the trace says which.
    fn grant(&mut self, wish: Wish);

    /// Scores the newest onset by its sensation until now; later sensation is never reported for it.
    fn score(&mut self);

    /// Switches everything off, and waits until that has taken effect.
    ///
    /// # Errors
    /// A bus that does not take it; an emulator that contradicts itself.
    fn end(&mut self, at: Instant) -> Result<(), Failure>;

    /// Takes the failure that ended the session or will end it.
    fn take_failure(&mut self) -> Option<Failure>;

    /// Takes the events since the last time, and the number of those before them that were dropped.
    fn drain(&mut self) -> (Vec<Event>, u64);

    /// Time of the newest turn.
    fn now(&self) -> Instant;

    /// The loop.
    fn projector(&self) -> &Projector;

    /// Readings of all taxels, raw counts; empty until [`Self::keep_counts`] and the first frame.
    fn counts(&self) -> &[f32];

    /// Keeps the readings of all taxels from now on.
    fn keep_counts(&mut self);

    /// State now, with the parts that are wanted.
    fn state(&self, wants: Wants) -> State;

    /// Each wire and the skin under it now, degrees C; `None` for motors, which heat no skin.
    fn warmth_c(&mut self) -> Option<Vec<[f64; 2]>>;
}

impl<D: EmulatedEnd + Send> Live for SessionOn<D> {
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        self.start(now)
    }

    fn turn(&mut self, now: Instant) -> Result<Turn, Failure> {
        self.turn(now)
    }

    fn advance(&mut self, until: Instant) -> Result<Turn, Failure> {
        self.advance(until)
    }

    fn push(&mut self, scan: &ModuleScan<'_>) -> Result<(), ScanError> {
        self.push(scan)
    }

    fn grant(&mut self, wish: Wish) {
        self.grant(wish, self.now());
    }

    fn score(&mut self) {
        let (display, projector, recorder) = self.all();
        display.score(projector, recorder);
    }

    fn end(&mut self, at: Instant) -> Result<(), Failure> {
        let off = self.switch_off(at);
        off.map_err(|e| Failure::Device(e.to_string()))?;
        let (display, projector, recorder) = self.all();
        display.settle(at, projector, recorder)
    }

    fn take_failure(&mut self) -> Option<Failure> {
        self.take_failure()
    }

    fn drain(&mut self) -> (Vec<Event>, u64) {
        self.drain()
    }

    fn now(&self) -> Instant {
        self.now()
    }

    fn projector(&self) -> &Projector {
        self.projector()
    }

    fn counts(&self) -> &[f32] {
        self.seen().1.counts.as_deref().unwrap_or_default()
    }

    fn keep_counts(&mut self) {
        self.recorder().counts.get_or_insert_default();
    }

    fn state(&self, wants: Wants) -> State {
        self.look().2.state(wants)
    }

    fn warmth_c(&mut self) -> Option<Vec<[f64; 2]>> {
        self.display().warmth_c()
    }
}

/// The loop of a setup, with levels by the contacts so far.
fn of_setup(setup: &Setup, seed: u64) -> Result<Projector, Failure> {
    build(setup, seed, dynamic_levels(&setup.scene.value.compression))
}

impl HeldSession {
    /// A setup's loop and emulated display, for contacts that another machine finds on a skin of the setup's layout, with
    /// levels found there as `levels` are.
    ///
    /// # Errors
    /// [`Failure::Input`] for what fits no loop.
    pub fn held(setup: &Setup, seed: u64, levels: Levels, truth: Truth) -> Result<Self, Failure> {
        let (setup, _) = passed(setup, seed)?;
        let setup = &*setup;
        let projector = build(setup, seed, levels)?;
        let display = EmulatedDisplay::new(setup, &projector, seed)?;
        let policy = Policy::emulated(setup.bench.value.unit.is_some());
        let mut session = Self::held_on(projector, display, policy, truth)?;
        session.plan_passes(setup);
        Ok(session)
    }
}

impl<D: DisplayEnd> HeldSession<D> {
    /// A session of a loop and any display, for contacts that are handed to it.
    ///
    /// # Errors
    /// [`Failure::Device`] for a loop that has begun.
    pub fn held_on(
        mut projector: Projector,
        display: D,
        policy: Policy,
        truth: Truth,
    ) -> Result<Self, Failure> {
        let recorder = Recorder::new(truth, projector.layout()).bounded(MOST_EVENTS);
        // Until the first contacts come, none of its taxels is missing.
        let none = projector.hold(Instant::ZERO, Duration::ZERO, &[], &mut ());
        none.map_err(|e| Failure::Device(e.to_string()))?;
        let ends = (Elsewhere, display);
        Ok(Self::new(projector, ends, policy, recorder, None))
    }

    /// Takes all contacts as of `at`, the earliest time at which they may have been there; they likely were `later`
    /// after that. Stimuli that they make due follow with the next turn.
    ///
    /// # Errors
    /// Contacts that are not of the setup's layout and levels, or not newer; nothing has changed then.
    pub fn hold(
        &mut self,
        at: Instant,
        later: Duration,
        contacts: &[Contact],
    ) -> Result<(), ForeignContacts> {
        let (_, projector, recorder) = self.all();
        projector.hold(at, later, contacts, recorder)
    }
}

impl<S: SkinEnd, D: DisplayEnd> Session<S, D> {
    /// Takes the events since the last time, in the order in which they were noticed, and the number of events before
    /// them that were dropped because nothing drained them.
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
