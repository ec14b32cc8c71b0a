//! The loops of a run in real time: a thread for each finger, which answers for its own part of the heartbeat.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration as Elapsed;

use palpate_buses::pacer::{Lateness, Pacer, RunClock, Watch};
use palpate_buses::signals::Signals;
use palpate_core::projector::Cause;
use palpate_core::units::{Duration, Instant};
use palpate_files::Setup;
use palpate_records::readings::Readings;
use palpate_run::picture::Wants;
use palpate_run::{Failure, Session, Turn, Wish};

use super::ends::{Sensed, Watched, goes_on, part, switch_off};
use super::records::{Records, Said};
use super::{panicked, passed, priority};
use crate::interfaces::lines;
use crate::lock::held;
use crate::output::note;
use crate::progress::Progress;
use crate::views::{STOPPED_BY_PAGE, Wanted};

/// Time between two looks at the records while no finger reports.
const ROUND: Elapsed = Elapsed::from_millis(50);
/// Time between two looks of a loop that waits for the other fingers' loops to be ready.
const WAIT: Duration = Duration::from_millis(1);
/// Longest time between two reports of a loop.
const SAY: Duration = Duration::from_millis(10);
/// Shortest time between two pictures for views.
const SHOW: Duration = Duration::from_millis(4);
/// Longest time for which another finger's transfer may hold a bus before it counts as failed: adapters with a limit
/// get as long.
const HELD_UP: Duration = Duration::from_millis(20);

/// State that all loops share.
pub(super) struct Shared<'a> {
    /// The bench's CAN interfaces.
    pub(super) can: &'a [String],
    /// Real-time priority: `true` insists on it, `false` does without, `None` takes it where the system allows.
    pub(super) realtime: Option<bool>,
    setup: &'a Setup,
    pub(super) signals: &'a Signals,
    pub(super) wanted: Wanted<'a>,
    pub(super) clock: RunClock,
    pub(super) end: Instant,
    /// `true` where views are open.
    pub(super) watched: bool,
    /// All fingers are to end.
    over: AtomicBool,
    /// Loops that are ready for their first turn, and whether they may take it.
    ready: AtomicUsize,
    go: AtomicBool,
    /// Loops that still make turns.
    turning: AtomicUsize,
    /// Number of wishes so far, and the newest one.
    wishes: AtomicUsize,
    wish: Mutex<Option<Wish>>,
}

/// A loop that has ended.
pub(super) struct Done<S, D> {
    pub(super) session: Session<S, D>,
    pub(super) lateness: Lateness,
    pub(super) realtime: bool,
    pub(super) end: Instant,
    /// `true` where everything is known to be off.
    pub(super) is_off: bool,
    /// `true` where STOP on a page ended the loop, and the stop is kept.
    pub(super) is_kept: bool,
}

impl<'a> Shared<'a> {
    /// Common state of loops that have not begun: interfaces and priority of their bench, and the end of the run.
    pub(super) fn new(
        setup: &'a Setup,
        (signals, wanted): (&'a Signals, Wanted<'a>),
        (clock, end): (RunClock, Instant),
        watched: bool,
    ) -> Self {
        let real = setup.bench.value.real.as_ref();
        Self {
            can: real.map_or(&[], |real| &real.can),
            realtime: real.and_then(|real| real.realtime),
            setup,
            signals,
            wanted,
            clock,
            end,
            watched,
            over: AtomicBool::new(false),
            ready: AtomicUsize::new(0),
            go: AtomicBool::new(false),
            turning: AtomicUsize::new(0),
            wishes: AtomicUsize::new(0),
            wish: Mutex::default(),
        }
    }

    /// Runs every loop on its own thread, until the scene's end, a signal, or the end of all of them. Returns with them
    /// whether a person who watched has ended the run.
    pub(super) fn drive<S: Sensed + Send, D: Watched + Send>(
        &self,
        sessions: Vec<Session<S, D>>,
        records: &mut Records,
    ) -> Result<(Vec<Done<S, D>>, bool), Failure> {
        let (say, said) = channel();
        let count = sessions.len();
        self.turning.store(count, Ordering::Relaxed);
        std::thread::scope(|scope| {
            let mut threads = Vec::new();
            for (finger, session) in sessions.into_iter().enumerate() {
                let turns = Turns::new(self, finger, say.clone());
                let thread = std::thread::Builder::new()
                    .name("loop".into())
                    .spawn_scoped(scope, || turns.whole(session));
                match thread {
                    Ok(thread) => threads.push(thread),
                    Err(e) => {
                        // A session that is dropped leaves its finger off, and the guardian without a good-bye.
                        self.end_all();
                        return Err(Failure::Device(format!("a loop's thread: {e}")));
                    }
                }
            }
            drop(say);
            while self.ready.load(Ordering::Relaxed) < count && !self.is_over() {
                self.clock.sleep_until(self.clock.now() + WAIT);
            }
            self.go.store(true, Ordering::Relaxed);
            let ended = self.listen(&said, records);
            let done = threads
                .into_iter()
                .map(|thread| thread.join().ok().flatten().ok_or_else(panicked));
            Ok((done.collect::<Result<_, _>>()?, ended))
        })
    }

    fn is_over(&self) -> bool {
        self.over.load(Ordering::Relaxed)
    }

    fn end_all(&self) {
        self.over.store(true, Ordering::Relaxed);
    }

    /// Hands the loops' reports to the records until all have ended. Returns whether a person who watched has ended
    /// them.
    fn listen(&self, said: &Receiver<Said>, records: &mut Records) -> bool {
        let progress = Progress::of_part("run");
        let mut ended = false;
        loop {
            match said.recv_timeout(ROUND) {
                Ok(said) => {
                    if records.take(said) {
                        ended = true;
                        self.end_all();
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return ended,
            }
            if let Some(wish) = records.wish() {
                // A display that was put on anew has cold wires, whatever becomes of this run.
                if wish == Wish::HotPass
                    && let Err(failure) = passed::keep(self.setup, false)
                {
                    note(&format!("the state of the wires is not kept: {failure}"));
                }
                *held(&self.wish) = Some(wish);
                self.wishes.fetch_add(1, Ordering::Relaxed);
            }
            if records.have_failed() {
                self.end_all();
            }
            let part = self.clock.now().as_micros() as f64 / self.end.as_micros().max(1) as f64;
            progress.part(part.min(1.0));
        }
    }
}

/// A finger's loop on its thread.
struct Turns<'a> {
    shared: &'a Shared<'a>,
    finger: usize,
    say: Sender<Said>,
    /// Events reported so far, and the times of the newest report and of the newest picture.
    told: usize,
    said: Instant,
    shown: Instant,
    watch: Watch,
    /// Wishes that were granted or refused, of those counted in [`Shared::wishes`].
    wishes: usize,
}

impl<'a> Turns<'a> {
    const fn new(shared: &'a Shared<'a>, finger: usize, say: Sender<Said>) -> Self {
        Self {
            shared,
            finger,
            say,
            told: 0,
            said: Instant::ZERO,
            shown: Instant::ZERO,
            watch: Watch::new(),
            wishes: 0,
        }
    }

    /// Runs the loop; `None` where it panicked. Its display end, dropped, has then told the guardian that the program
    /// is wrong.
    fn whole<S: Sensed, D: Watched>(self, session: Session<S, D>) -> Option<Done<S, D>> {
        let shared = self.shared;
        let done = catch_unwind(AssertUnwindSafe(|| self.run(session)));
        if done.is_err() {
            shared.end_all();
        }
        done.ok()
    }

    fn run<S: Sensed, D: Watched>(mut self, mut session: Session<S, D>) -> Done<S, D> {
        let shared = self.shared;
        let realtime = priority(shared.realtime).unwrap_or_else(|refused| {
            session.set_failure(refused);
            shared.end_all();
            false
        });
        shared.ready.fetch_add(1, Ordering::Relaxed);
        while !shared.go.load(Ordering::Relaxed) && !shared.is_over() {
            shared.clock.sleep_until(shared.clock.now() + WAIT);
        }
        let mut pacer = Pacer::new(shared.clock);
        let mut now = pacer.wait(shared.clock.now());
        let mut is_on = session.failure().is_none();
        while is_on && now < shared.end && self.goes_on(&mut session, now) {
            match self.turn(&mut session) {
                Ok(Turn::Next(next)) => now = pacer.wait(next),
                Ok(Turn::Last) => is_on = false,
                Err(failure) => {
                    session.set_failure(failure);
                    is_on = false;
                }
            }
        }
        let left = switch_off(&mut session, shared.clock.now());
        let is_kept = shared.wanted.is_stopped();
        if is_kept {
            let kept = session.display().keep_stopped(STOPPED_BY_PAGE);
            session.set_failure(kept);
        }
        let (end, is_off) = self.leave(&mut session, left);
        self.tell(&mut session, Instant::FAR_FUTURE);
        Done {
            session,
            lateness: pacer.lateness().clone(),
            realtime,
            end,
            is_off,
            is_kept,
        }
    }

    /// Takes leave of the guardian for a finger that was switched off, or was `left` on for this cause. Returns the
    /// time of that, and whether everything is known to be off.
    fn leave<S: Sensed, D: Watched>(
        &mut self,
        session: &mut Session<S, D>,
        left: Option<String>,
    ) -> (Instant, bool) {
        let shared = self.shared;
        if session.overrun().is_some() {
            // A loop that passed a limit ends the whole run.
            shared.end_all();
        }
        shared.turning.fetch_sub(1, Ordering::Relaxed);
        // Outputs that could not be switched off are tried again for as long as other fingers go on: the guardian would
        // end them.
        let (end, is_off) = part(session, shared.clock, left, |session| {
            let now = shared.clock.now();
            self.tell(session, now);
            shared.turning.load(Ordering::Relaxed) > 0
                && now < shared.end
                && self.goes_on(session, now)
        });
        let (display, projector, _) = session.all();
        if let Some((heat, fingertip)) = display.ledger() {
            heat.leave(fingertip, end, projector.guard());
        }
        (end, is_off)
    }

    /// Attends before a turn to this finger's part of the heartbeat, STOP, signals and records; returns whether the run goes on.
    fn goes_on<S: Sensed, D: Watched>(
        &mut self,
        session: &mut Session<S, D>,
        now: Instant,
    ) -> bool {
        let shared = self.shared;
        if !goes_on(session, &mut self.watch, now, || shared.end_all()) {
            shared.end_all();
            return false;
        }
        if shared.wanted.is_stopped() || shared.signals.caught().is_some() || shared.is_over() {
            return false;
        }
        assert!(
            self.finger > 0 || !shared.signals.wants_panic(),
            "a drill, by PALPATE_DRILL and SIGUSR1"
        );
        let wishes = shared.wishes.load(Ordering::Relaxed);
        // A lock that is taken is not waited for: the next turn comes within a millisecond.
        if self.wishes != wishes
            && let Ok(wish) = shared.wish.try_lock().map(|wish| *wish)
        {
            self.wishes = wishes;
            if let Some(wish) = wish {
                session.display().wait();
                session.grant(wish, shared.clock.now());
            }
        }
        self.tell(session, now);
        true
    }

    /// Takes a turn once the bus is free. A transfer of another finger that takes long has failed: this one is off as
    /// well, and its session brings it back.
    fn turn<S: Sensed, D: Watched>(&self, session: &mut Session<S, D>) -> Result<Turn, Failure> {
        let clock = self.shared.clock;
        let asked = clock.now();
        session.display().wait();
        let now = clock.now();
        let latched = session.projector().guard().latched();
        if now.since(asked) > HELD_UP && latched.is_none() {
            let (end, projector, recorder) = session.all();
            let (banks, _) = end.parts();
            if let Err(error) = projector.all_off(now, Cause::ActuatorError, banks, recorder) {
                session.lose(&error);
            }
        }
        session.turn(now)
    }

    /// Hands new events, frames and readings to the records.
    fn tell<S: Sensed, D: Watched>(&mut self, session: &mut Session<S, D>, until: Instant) {
        let shows = self.shared.watched && until.since(self.shown) >= SHOW;
        let skin = session.skin();
        let frames = skin.take_frames();
        let buses = match shows {
            true => lines(self.shared.can, &skin.tallies()),
            false => Vec::new(),
        };
        let (_, _, look) = session.look();
        let state = shows.then(|| look.state(Wants::READINGS));
        let recorder = session.recorder();
        let events = recorder.events.get(self.told..).unwrap_or_default();
        let events = events.to_vec();
        let taxels = recorder.taxels.as_mut().map(Readings::take_frames);
        let taxels = taxels.unwrap_or_default();
        let is_new = !(events.is_empty() && frames.is_empty() && taxels.is_empty());
        if !(is_new || shows || until.since(self.said) > SAY) {
            return;
        }
        self.told += events.len();
        self.said = until;
        let mut counts = Vec::new();
        if shows {
            self.shown = until;
            counts = recorder.counts.clone().unwrap_or_default();
        }
        // Records whose writer has failed end the run on their own.
        let _ = self.say.send(Said {
            finger: self.finger,
            until,
            events,
            frames,
            taxels,
            counts,
            buses,
            state,
        });
    }
}
