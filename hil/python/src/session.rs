//! The loop, held open: readings are pushed or touches change, virtual time goes on, and events are handed out.

use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use palpate_core::skin::ModuleScan;
use palpate_core::units::{Instant, Point};
use palpate_emulators::sensor::Press;
use palpate_run::wires::EmulatedDisplay;
use palpate_run::{
    Activations, EmulatedEnd, EmulatedMotors, Failure, Hand, Live, SessionOn, Turn, Wish, header,
    plan,
};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::{self, free};
use crate::happened::Happened;
use crate::places::{taxels, wire};
use crate::setup::Setup;
use crate::shown::Shown;
use crate::tables::About;

/// The session behind a loop.
struct Held {
    session: Box<dyn Live>,
    /// The hand on each module of an emulated skin; none where readings are pushed.
    hands: Option<Vec<Hand>>,
}

/// State of a loop.
struct State {
    /// The session and its hands; none once it is closed, or left by a panic.
    held: Option<Box<Held>>,
    /// Time at which the boards have started.
    ready: Instant,
    about: About,
    /// Module of each taxel, and where it lies there, mm.
    taxels: Vec<(u16, f64, f64)>,
    /// Places of the wires on the display, mm.
    wires: Vec<(f64, f64)>,
    /// Time of the newest scan of each module, microseconds.
    newest: Vec<Option<u64>>,
    axes: usize,
    /// A scan in the loop's own form.
    counts: Vec<[u16; 3]>,
    /// Activations of the wires in place of the scene's illusion, where they come from outside.
    activations: Option<Activations>,
    /// Time from onset to onset, microseconds.
    soa_us: u64,
    /// Setup of the loop, for its page.
    setup: palpate_files::Setup,
    seed: u64,
    /// Pictures of the loop's page, where one is shown.
    shown: Option<Box<Shown>>,
    /// Exception that a signal raised.
    raised: Option<PyErr>,
}

/// Virtual time between two looks for Ctrl-C, microseconds: some milliseconds of computing.
const PIECE_US: u64 = 1_000_000;

/// A loop between readings or touches and an emulated display, in virtual time.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct Loop(Mutex<State>);

fn input(text: impl Into<String>) -> Failure {
    Failure::Input(text.into())
}

fn closed() -> Failure {
    input("Loop: expected one that is open, found a closed one; make another")
}

/// Takes a turn. The error is the failure that ended the loop before its time.
fn turn(session: &mut dyn Live, now: Option<Instant>, until: Instant) -> Result<(), Failure> {
    let turned = match now {
        Some(now) => session.turn(now)?,
        None => session.advance(until)?,
    };
    match turned {
        Turn::Next(_) => Ok(()),
        Turn::Last => Err(session
            .take_failure()
            .unwrap_or_else(|| Failure::Device("the loop ended".into()))),
    }
}

impl State {
    fn held(&self) -> Result<&Held, Failure> {
        self.held.as_deref().ok_or_else(closed)
    }

    fn session(&mut self) -> Result<&mut dyn Live, Failure> {
        let held = self.held.as_deref_mut().ok_or_else(closed)?;
        Ok(&mut *held.session)
    }

    fn grant(&mut self, wish: Wish) -> Result<Happened, Failure> {
        self.session()?.grant(wish);
        self.happened()
    }

    fn now(&self) -> Result<u64, Failure> {
        Ok(self.held()?.session.now().as_micros())
    }

    fn happened(&mut self) -> Result<Happened, Failure> {
        let (events, dropped) = self.session()?.drain();
        if let Some(shown) = &mut self.shown {
            shown.add(&events, dropped);
        }
        Ok(Happened {
            events,
            about: self.about.clone(),
            dropped,
            time_us: self.now()?,
        })
    }

    fn advance(&mut self, until_us: u64) -> Result<(), Failure> {
        let now = self.now()?;
        if until_us < now {
            return Err(input(format!(
                "until_us: expected a time from {now} us on, found {until_us} us"
            )));
        }
        self.pass(until_us)?;
        self.turn_at(until_us)
    }

    /// Runs the turns that are due before `until_us`; between pieces of them Python may raise a signal.
    fn pass(&mut self, until_us: u64) -> Result<(), Failure> {
        let mut piece_us = self.now()?.saturating_add(PIECE_US);
        loop {
            let until = Instant::from_micros(piece_us.min(until_us));
            turn(self.session()?, None, until)?;
            if piece_us >= until_us {
                return Ok(());
            }
            piece_us = piece_us.saturating_add(PIECE_US);
            if let Err(raised) = Python::attach(|py| py.check_signals()) {
                self.raised = Some(raised);
                return Err(Failure::Stopped("a signal".into()));
            }
        }
    }

    /// Takes a turn at this time, unless it is later already, or the boards are not ready.
    fn turn_at(&mut self, at_us: u64) -> Result<(), Failure> {
        let at = Instant::from_micros(at_us.max(self.now()?));
        if at < self.ready {
            return Ok(());
        }
        turn(self.session()?, Some(at), at)
    }

    fn push(&mut self, module: usize, time_us: u64, counts: &[u8]) -> Result<(), Failure> {
        if self.held()?.hands.is_some() {
            let text =
                "Loop.push: expected skin=\"pushed\", found an emulated skin, which is touched";
            return Err(input(text));
        }
        let modules = self.newest.len();
        let newest = self.newest.get_mut(module);
        let newest = newest.ok_or_else(|| {
            input(format!(
                "module: expected less than {modules}, found {module}"
            ))
        })?;
        if let Some(before) = newest.filter(|before| time_us <= *before) {
            return Err(input(format!(
                "time_us: expected more than {before} us, the time of the scan before, found {time_us} us"
            )));
        }
        *newest = Some(time_us);
        // The time before the scan passes without it.
        self.pass(time_us)?;
        let axes = self.axes;
        self.counts.clear();
        for reading in counts.chunks_exact(2 * axes) {
            let mut taxel = [0; 3];
            for (axis, bytes) in taxel[3 - axes..].iter_mut().zip(reading.chunks_exact(2)) {
                *axis = u16::from_le_bytes([bytes[0], bytes[1]]);
            }
            self.counts.push(taxel);
        }
        let at = Instant::from_micros(time_us);
        let scan = ModuleScan::whole(module as u16, at, &self.counts);
        let held = self.held.as_mut().ok_or_else(closed)?;
        let pushed = held.session.push(&scan);
        pushed.map_err(|e| input(format!("Loop.push: {e}")))?;
        self.turn_at(time_us)
    }

    fn touch(&self, module: usize, presses: &[[f64; 4]]) -> Result<(), Failure> {
        let hands = self.held()?.hands.as_ref().ok_or_else(|| {
            input("Loop.touch: expected skin=\"emulated\", found a loop whose readings are pushed")
        })?;
        let hand = hands.get(module).ok_or_else(|| {
            input(format!(
                "module: expected less than {}, found {module}",
                hands.len()
            ))
        })?;
        let press = |&[x, y, force_n, diameter_mm]: &[f64; 4]| Press {
            at: Point::new(x as f32, y as f32),
            force_n,
            diameter_mm,
        };
        let presses: Vec<Press> = presses.iter().map(press).collect();
        hand.press(&presses);
        Ok(())
    }

    fn activate(&self, values: &[f32], pulses: Option<&[u8]>) -> Result<(), Failure> {
        let own = self.own()?;
        own.set(values)?;
        own.set_pulses(pulses)
    }

    fn own(&self) -> Result<&Activations, Failure> {
        let own = self.activations.as_ref();
        own.ok_or_else(|| {
            input("Loop.activate: expected illusion=\"own\", found the scene's illusion")
        })
    }

    /// Scores the newest onset by its sensation until now. Later sensation is never reported for it.
    fn conclude(&mut self) -> Result<(), Failure> {
        self.session()?.score();
        Ok(())
    }

    /// Change of every taxel from its reference, counts; NaN for one that is left out. Empty before the first frame.
    fn changes(&self) -> Result<Vec<f32>, Failure> {
        Ok(self.held()?.session.counts().to_vec())
    }

    /// Begins pictures for a page, or begins them anew. Returns the head, JSON.
    fn show(&mut self) -> Result<String, Failure> {
        let held = self.held.as_mut().ok_or_else(closed)?;
        let shown = Shown::new(&self.setup, self.seed, &mut *held.session)?;
        let head = shown.head();
        self.shown = Some(Box::new(shown));
        head
    }

    fn picture(&mut self) -> Result<String, Failure> {
        let shown = self.shown.as_mut();
        let shown = shown.ok_or_else(|| input("Loop: expected a page, found none"))?;
        let held = self.held.as_ref().ok_or_else(closed)?;
        shown.picture(&*held.session)
    }

    fn temperatures(&mut self) -> Result<Vec<(f64, f64)>, Failure> {
        let motors = || {
            input("Loop.temperatures: expected a bench of wires, found motors, which heat no skin")
        };
        let warm = self.session()?.warmth_c().ok_or_else(motors)?;
        Ok(warm.into_iter().map(|[wire, skin]| (wire, skin)).collect())
    }
}

/// A session that is open, the hands on its skin, and its activations from outside.
type Opened = (Box<dyn Live>, Option<Vec<Hand>>, Option<Activations>);

/// Opens a session on a display of this kind, fed or under hands (`emulated`), with the scene's illusion or another one's
/// (`activated`).
fn opened<D: EmulatedEnd + Send + 'static>(
    setup: &palpate_files::Setup,
    seed: u64,
    (emulated, activated): (bool, bool),
) -> Result<Opened, Failure> {
    if !emulated {
        let session = SessionOn::<D>::fed(setup, seed)?;
        return Ok((Box::new(session), None, None));
    }
    if activated {
        let (session, hands, own) = SessionOn::<D>::activated(setup, seed)?;
        return Ok((Box::new(session), Some(hands), Some(own)));
    }
    let (session, hands) = SessionOn::<D>::touched(setup, seed)?;
    Ok((Box::new(session), Some(hands), None))
}

impl Loop {
    /// The state, if no other thread is inside.
    fn state(&self) -> PyResult<MutexGuard<'_, State>> {
        match self.0.try_lock() {
            Ok(state) => Ok(state),
            Err(TryLockError::Poisoned(broken)) => Ok(PoisonError::into_inner(broken)),
            Err(TryLockError::WouldBlock) => Err(errors::raise(
                "BusyError",
                "Loop: expected one thread at a time, found another inside; use a lock, or a loop per thread",
            )),
        }
    }

    /// Works with the state, without the interpreter's lock.
    fn within<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut State) -> Result<T, Failure> + Send,
    ) -> PyResult<T> {
        let mut state = self.state()?;
        let state = &mut *state;
        let mut whole = false;
        let done = free(py, || {
            let done = work(state);
            whole = true;
            done
        });
        if !whole {
            // The state that a panic leaves between two turns is no loop.
            state.held = None;
        }
        match state.raised.take() {
            Some(raised) => Err(raised),
            None => done,
        }
    }
}

#[pymethods]
impl Loop {
    /// The loop of a setup; `emulated`: its skin is emulated and is touched.
    ///
    /// `activated`: its wires' activations come from outside.
    #[new]
    fn new(
        py: Python<'_>,
        setup: &Bound<'_, Setup>,
        seed: u64,
        emulated: bool,
        activated: bool,
    ) -> PyResult<Self> {
        let setup = setup.get().inner.clone();
        free(py, || {
            let taxels = taxels(&plan::layout(&setup.sensor.value)?);
            let open = match setup.bench.value.haptics {
                None => opened::<EmulatedDisplay>,
                Some(_) => opened::<EmulatedMotors>,
            };
            let (mut session, hands, own) = open(&setup, seed, (emulated, activated))?;
            let started = session.start(Instant::ZERO);
            let ready = started.map_err(|e| Failure::Device(e.to_string()))?;
            let header = header(&setup, seed, session.projector())?;
            let modules = session.projector().layout().modules().len();
            Ok(Self(Mutex::new(State {
                held: Some(Box::new(Held { session, hands })),
                ready,
                about: About::new(&header),
                taxels,
                wires: header.wires.iter().map(wire).collect(),
                newest: vec![None; modules],
                axes: usize::from(setup.sensor.value.axes),
                counts: Vec::new(),
                activations: own,
                soa_us: header.soa_us,
                setup,
                seed,
                shown: None,
                raised: None,
            })))
        })
    }

    /// One module's scan: its time, and the bytes of its counts (u16), taxel by taxel.
    fn push(
        &self,
        py: Python<'_>,
        module: usize,
        time_us: u64,
        counts: &[u8],
    ) -> PyResult<Happened> {
        self.within(py, |state| {
            state.push(module, time_us, counts)?;
            state.happened()
        })
    }

    /// Virtual time goes on.
    fn advance(&self, py: Python<'_>, until_us: u64) -> PyResult<Happened> {
        self.within(py, |state| {
            state.advance(until_us)?;
            state.happened()
        })
    }

    /// The reference of the skin is taken anew; not while anything is in contact, unless forced.
    fn rezero(&self, py: Python<'_>, forced: bool) -> PyResult<Happened> {
        self.within(py, |state| state.grant(Wish::Rezero { forced }))
    }

    /// The display was put on anew: its wires are passed at the next onsets without a contact.
    fn hot_pass(&self, py: Python<'_>) -> PyResult<Happened> {
        self.within(py, |state| state.grant(Wish::HotPass))
    }

    /// Sets the presses on a module from now on: x and y (mm), force (N), diameter (mm).
    fn touch(&self, py: Python<'_>, module: usize, presses: Vec<[f64; 4]>) -> PyResult<()> {
        self.within(py, |state| state.touch(module, &presses))
    }

    /// Sets each wire's activation from the next onset on, and its pulses.
    fn activate(&self, py: Python<'_>, values: Vec<f32>, pulses: Option<Vec<u8>>) -> PyResult<()> {
        self.within(py, |state| state.activate(&values, pulses.as_deref()))
    }

    /// The most pulses of a wire at an onset.
    fn most_pulses(&self, py: Python<'_>) -> PyResult<u8> {
        self.within(py, |state| Ok(state.own()?.most_pulses()))
    }

    /// Ends what is felt of the newest onset, and hands out what happened.
    fn conclude(&self, py: Python<'_>) -> PyResult<Happened> {
        self.within(py, |state| {
            state.conclude()?;
            state.happened()
        })
    }

    /// Differences of all taxels from their references, counts, as bytes (f32); NaN for a taxel that is left out.
    fn changes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let changes = self.within(py, |state| state.changes())?;
        Ok(PyBytes::new(py, bytemuck::cast_slice(&changes)))
    }

    /// Pictures for a page begin; returns what stays as it is, JSON.
    fn show(&self, py: Python<'_>) -> PyResult<String> {
        self.within(py, State::show)
    }

    /// Events since the last picture, and the present state, JSON.
    fn picture(&self, py: Python<'_>) -> PyResult<String> {
        self.within(py, State::picture)
    }

    /// Module of each taxel, and where it lies there, mm.
    fn taxels(&self, py: Python<'_>) -> PyResult<Vec<(u16, f64, f64)>> {
        self.within(py, |state| Ok(state.taxels.clone()))
    }

    /// Places of the wires on the display, mm.
    fn wires(&self, py: Python<'_>) -> PyResult<Vec<(f64, f64)>> {
        self.within(py, |state| Ok(state.wires.clone()))
    }

    /// Time from onset to onset, microseconds.
    fn soa_us(&self, py: Python<'_>) -> PyResult<u64> {
        self.within(py, |state| Ok(state.soa_us))
    }

    /// Temperature of each wire and of the skin under it, degrees C.
    fn temperatures(&self, py: Python<'_>) -> PyResult<Vec<(f64, f64)>> {
        self.within(py, State::temperatures)
    }

    /// Virtual time, microseconds.
    fn time_us(&self, py: Python<'_>) -> PyResult<u64> {
        self.within(py, |state| state.now())
    }

    /// Lets everything go.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        self.within(py, |state| {
            state.held = None;
            Ok(())
        })
    }
}
