//! The pass that counts: the loop between the skin and the emulated display, turn by turn in virtual time.

use palpate_core::contact::Levels;
use palpate_core::driver::Banks;
use palpate_core::illusion::Drive;
use palpate_core::projector::{Cause, LoopError, Projector};
use palpate_core::units::{Duration, Instant, Prescale};
use palpate_emulators::display::{Display, OutputEdge, ThermalSample};
use palpate_emulators::i2c::Handle;
use palpate_emulators::i2c::fault::{I2cFault, I2cFaults, Shared};
use palpate_emulators::time::Nanos;
use palpate_records::trace::{Event, Ledger, Trace};

use super::effort::{Effort, FrameTimes};
use super::ends::{display, header};
use super::feel::{feel, sample_wires};
use super::recorder::{Onset, Recorder, milli_c};
use super::script::{Bench, Script};
use super::sensor::{Skin, Tapped};
use super::summary::TextureSummary;
use super::supervisor::Supervisor;
use super::{BusReport, Outcome, Summary, TICK, boards, build, margins, open_watch};
use crate::clock;
use crate::failure::Failure;
use crate::plan;
use crate::watch::Watch;
use palpate_files::{Setup, Touch};

/// The finger is looked at no less often than this, even where no stimulus comes.
const LOOK: Duration = Duration::from_millis(250);

/// Transfers kept of a run's actuator bus, the last ones: some hours of them.
const I2C_LOG: usize = 1 << 20;

/// Whether there is another turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Turn {
    /// There is.
    Next,
    /// Something ended the run before its time.
    Last,
}

/// A run between two turns.
struct Pass<'a, S> {
    setup: &'a Setup,
    skin: &'a mut Tapped<S>,
    drive: Drive,
    projector: Projector,
    display: Display,
    i2c: Shared<Handle>,
    bank: Banks<Shared<Handle>>,
    prescale: Prescale,
    script: Script,
    supervisor: Supervisor,
    recorder: Recorder,
    watch: Option<Watch>,
    now: Instant,
    /// The finger is looked at again then.
    look: Instant,
    /// The onset whose stimulus is still felt.
    pending: Option<Onset>,
    samples: Vec<ThermalSample>,
    times: FrameTimes,
    effort: Effort,
    failure: Option<Failure>,
}

/// Runs the loop until `end`. The whole run began at `started`, by the wall clock, and may be `watched`.
///
/// # Errors
/// [`Failure`] for input that fits no loop, or a live view that cannot be opened.
pub(super) fn project(
    setup: &Setup,
    seed: u64,
    levels: Levels,
    skin: &mut Tapped<impl Skin>,
    truth: Option<(Vec<Touch>, usize)>,
    end: Instant,
    (started, watched): (std::time::Instant, bool),
) -> Result<Outcome, Failure> {
    let mut pass = Pass::new(setup, seed, levels, skin, truth)?;
    if watched {
        pass.watch = open_watch(setup, seed, &pass.projector, end, true)?;
        pass.recorder.counts = pass.watch.is_some().then(Vec::new);
    }
    pass.start();
    let mut turn = Turn::Next;
    while pass.now < end && turn == Turn::Next {
        turn = pass.turn()?;
    }
    drop(pass.watch.take());
    let end = match turn {
        Turn::Next => end,
        Turn::Last => pass.now,
    };
    pass.switch_off(end)?;
    pass.outcome(seed, end, started)
}

fn device(e: &dyn std::fmt::Display) -> Failure {
    Failure::Device(e.to_string())
}

impl<'a, S: Skin> Pass<'a, S> {
    fn new(
        setup: &'a Setup,
        seed: u64,
        levels: Levels,
        skin: &'a mut Tapped<S>,
        truth: Option<(Vec<Touch>, usize)>,
    ) -> Result<Self, Failure> {
        let bench = &setup.bench.value;
        let projector = build(setup, seed, levels)?;
        let mut display = display(setup, projector.display().wires())?;
        display.keep_flows();
        if skin.keeps().i2c {
            let kept = display.bus().with(|bus| bus.keep_log(I2C_LOG));
            kept.map_err(|e| Failure::Device(format!("actuator bus: {e}")))?;
        }
        let i2c = Shared::new(I2cFault::new(
            display.bus(),
            I2cFaults::default(),
            seed,
            "actuator bus",
        ));
        let (boards, prescale) = (plan::boards(bench), plan::prescale(bench)?);
        Ok(Self {
            drive: plan::drive(&setup.scene.value.illusion),
            bank: Banks::new([(i2c.clone(), &*boards)], prescale),
            prescale,
            script: Script::new(&setup.scene.value.faults, projector.layout()),
            supervisor: Supervisor::default(),
            recorder: Recorder::new(truth, projector.layout()),
            watch: None,
            now: Instant::ZERO,
            look: Instant::ZERO,
            pending: None,
            samples: Vec::new(),
            times: FrameTimes::default(),
            effort: Effort::default(),
            failure: None,
            setup,
            skin,
            projector,
            display,
            i2c,
        })
    }

    /// Starts the boards: everything off, the period set.
    fn start(&mut self) {
        let bench = &self.setup.bench.value;
        for (board, _) in plan::boards(bench).iter().enumerate() {
            let board = board as u8; // at most 16
            self.recorder.events.push(Event::AllOff {
                t_us: 0,
                board,
                cause: "start",
            });
            self.recorder.events.push(Event::PreScale {
                t_us: 0,
                board,
                pre_scale: self.prescale.get(),
            });
        }
        self.faults(Script::step);
        self.now = match self.bank.start(Instant::ZERO) {
            Ok(ready) => ready,
            Err(e) => {
                self.lose(&e);
                Instant::ZERO
            }
        };
    }

    /// Does to the hardware what the scene's faults ask for now.
    fn faults(&mut self, act: fn(&mut Script, Instant, &mut Bench<'_>, &mut Vec<Event>)) {
        let mut hardware = Bench {
            skin: self.skin.emulated(),
            i2c: &self.i2c,
            display: &mut self.display,
            oscillator: self.setup.bench.value.drive.oscillator,
        };
        act(
            &mut self.script,
            self.now,
            &mut hardware,
            &mut self.recorder.events,
        );
    }

    fn lose(&mut self, error: &dyn std::fmt::Display) {
        let events = &mut self.recorder.events;
        self.supervisor.lose(self.now, error, &self.display, events);
    }

    /// Lets the display come to `until`.
    fn display_to(&mut self, until: Nanos) -> Result<(), Failure> {
        let edges = &mut self.recorder.events;
        let advanced = self.display.advance(until, &mut |e| edges.push(edge(&e)));
        advanced.map_err(|e| device(&e))
    }

    /// One call of the loop, and what goes on around it.
    fn turn(&mut self) -> Result<Turn, Failure> {
        self.skin.advance_to(self.now);
        self.display_to(Nanos::from(self.now))?;
        if self.supervisor.is_lost() {
            return Ok(self.recover());
        }
        let events = &mut self.recorder.events;
        self.supervisor
            .resume(self.now, &mut self.projector, &mut self.bank, events);
        let onset = match self.poll() {
            Ok(onset) => onset,
            Err(failure) => {
                self.failure = Some(failure);
                return Ok(Turn::Last);
            }
        };
        if onset {
            self.feel();
            self.pending = self.recorder.onset.take();
            sample_wires(
                self.now,
                &mut self.display,
                &self.projector,
                &mut self.recorder,
            );
        }
        if onset || self.now >= self.look {
            self.samples.extend(self.display.sample());
            self.look = self.now + LOOK;
        }
        let events = &mut self.recorder.events;
        self.supervisor
            .restart_boards(self.now, self.skin, &self.projector, events);
        if self.is_stopped() {
            let note = "ended by the person who watched".into();
            self.recorder.note(self.now, note);
            return Ok(Turn::Last);
        }
        self.faults(Script::step);
        self.now = self
            .projector
            .next()
            .min(self.now + TICK)
            .min(self.script.next());
        Ok(Turn::Next)
    }

    /// Tries to bring a lost bus back.
    fn recover(&mut self) -> Turn {
        let events = &mut self.recorder.events;
        let tried = self
            .supervisor
            .recover(self.now, &mut self.bank, &self.display, events);
        match tried {
            Ok(Some(ready)) => self.now = ready,
            Ok(None) => {
                self.faults(Script::step);
                self.now += TICK;
            }
            Err(failure) => {
                self.failure = Some(failure);
                return Turn::Last;
            }
        }
        Turn::Next
    }

    /// Calls the loop; returns whether a stimulus began. A bus that fails is lost, and brought back later.
    ///
    /// # Errors
    /// [`Failure::Device`] for a sensor end that is gone.
    fn poll(&mut self) -> Result<bool, Failure> {
        let before = self.recorder.frames;
        let begun = clock::now();
        let polled = self
            .projector
            .poll(self.now, self.skin, &mut self.bank, &mut self.recorder);
        let frames = self.recorder.frames - before;
        let work = self.projector.work();
        self.times.add(begun, frames, &work, &mut self.effort);
        let polled = match polled {
            // A chip that fell back to reset values answers, but sleeps: ask while wires should be driven.
            Ok(true) => self.bank.verify().map(|()| true).inspect_err(|_| {
                // The error is on its way; recovery finds out whether this helped.
                let _ = self.projector.all_off(
                    self.now,
                    Cause::ActuatorError,
                    &mut self.bank,
                    &mut self.recorder,
                );
            }),
            Ok(false) => Ok(false),
            Err(LoopError::Actuator(e)) => Err(e),
            Err(LoopError::Sensor(e)) => {
                return Err(Failure::Device(format!("sensor bus: {e:?}")));
            }
        };
        let retries = self.bank.retries();
        self.supervisor
            .retried(self.now, retries, &mut self.recorder.events);
        Ok(polled.unwrap_or_else(|e| {
            self.lose(&e);
            false
        }))
    }

    /// Scores what was felt of the onset before this one.
    fn feel(&mut self) {
        feel(
            self.pending.take(),
            &self.display,
            &self.projector,
            self.drive,
            &mut self.recorder,
        );
    }

    /// Shows the live view; whether the person in front of it wants no more.
    fn is_stopped(&mut self) -> bool {
        let Some(watch) = &mut self.watch else {
            return false;
        };
        let counts = self.recorder.counts.as_deref().unwrap_or_default();
        let buses = || self.skin.buses().iter().map(BusReport::words).collect();
        watch.turn(self.now, &self.recorder.events, counts, buses)
    }

    /// Switches everything off at `end` and waits until it is.
    fn switch_off(&mut self, end: Instant) -> Result<(), Failure> {
        self.feel();
        self.now = end;
        let off = self
            .projector
            .all_off(end, Cause::End, &mut self.bank, &mut self.recorder);
        if let Err(e) = off
            && self.failure.is_none()
        {
            self.lose(&e);
            self.failure = Some(device(&e));
        }
        self.faults(Script::finish);
        // Full off takes effect at the end of a period: wait for two of them.
        let period = self.prescale.period_ns();
        self.display_to(Nanos::from(end) + Nanos(2 * period))?;
        self.recorder.tell_taxels();
        self.samples.extend(self.display.sample());
        Ok(())
    }

    /// What the run came to.
    fn outcome(
        mut self,
        seed: u64,
        end: Instant,
        started: std::time::Instant,
    ) -> Result<Outcome, Failure> {
        let (setup, projector) = (self.setup, &mut self.projector);
        let i2c = boards::transfers(&self.display);
        let totals = self.display.totals();
        let mut events = std::mem::take(&mut self.recorder.events);
        events.sort_by_key(Event::t_ns);
        let ledger = Ledger {
            energy_uj: (totals.electrical_j * 1e6).round() as u64,
            peak_supply_ma: totals.peak_supply.0,
            hottest_wire: milli_c(totals.hottest_wire.0).map(|t| (t, totals.hottest_wire.1 as u16)),
            hottest_skin_milli_c: milli_c(totals.hottest_skin_c),
            limiter_events: self.recorder.limiter_events,
            length_us: end.as_micros(),
        };
        let trace = Trace {
            header: header(setup, seed, projector)?,
            events,
            ledger,
        };
        self.skin.advance_to(end);
        let mut summary = Summary::new(
            &trace,
            &self.recorder,
            &self.times.us,
            &projector.health(end),
            &setup.bench.value,
            started.elapsed(),
        );
        summary.texture = TextureSummary::of(&self.recorder, projector);
        summary.boards = boards::boards(projector);
        summary.buses = self.skin.buses();
        summary.faults = self.script.report();
        summary.taxels.list(projector, end);
        let wires = projector.display().wires().len();
        let course = margins::Course {
            flows: &self.display.take_flows(),
            samples: &self.samples,
            totals: &totals,
            wires,
        };
        let file = &setup.limits.value;
        summary.margins = margins::margins(&course, projector.guard().limits(), file);
        self.recorder.tell(&mut self.effort, wires);
        self.effort.traffic = self.bank.traffic();
        self.effort.calibrated = setup.scene.value.compression.ki > 1;
        Ok(Outcome {
            warmth: self.samples.iter().map(margins::warmth).collect(),
            skin_limits: margins::skin_limits(file),
            trace,
            summary,
            frame_us: self.times.us,
            effort: self.effort,
            failure: self.failure,
            can: self.skin.take(),
            i2c,
            notes: Vec::new(),
        })
    }
}

fn edge(e: &OutputEdge) -> Event {
    Event::Edge {
        t_ns: e.at.0,
        board: e.board,
        channel: e.channel,
        high: e.high,
    }
}
