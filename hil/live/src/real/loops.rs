//! The loops of several fingers on a real bench: a thread each, which stands for its own part of the heartbeat.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration as Elapsed;

use palpate_buses::pacer::{Pacer, RunClock, Watch};
use palpate_buses::signals::Signals;
use palpate_core::projector::Cause;
use palpate_core::units::{Duration, Instant};
use palpate_files::Real;
use palpate_records::readings::Readings;
use palpate_run::display_end::DisplayEnd;
use palpate_run::picture::Wants;
use palpate_run::skin_end::SkinEnd;
use palpate_run::{Failure, Policy, Session, Turn};

use super::ends::{RealSkin, Sensed, Watched, goes_on, left_on, switch_off, switch_off_again};
use super::priority;
use super::records::{Records, Said};
use super::turns::Done;
use super::warden::{FingerEnd, Warden};
use crate::interfaces::lines;
use crate::progress::Progress;
use crate::views::Wish;

/// The records are looked after this often where no finger says anything.
const ROUND: Elapsed = Elapsed::from_millis(50);
/// A loop that waits for the other fingers' loops to be ready looks this often.
const WAIT: Duration = Duration::from_millis(1);
/// A loop says at least this often how far it is.
const SAY: Duration = Duration::from_millis(10);
/// Another finger's transfer that holds a bus for longer has failed: adapters with a limit get as long.
const HELD_UP: Duration = Duration::from_millis(20);

/// What all loops look at.
pub(super) struct Shared<'a> {
    pub(super) real: &'a Real,
    pub(super) warden: &'a Warden,
    pub(super) signals: &'a Signals,
    pub(super) clock: RunClock,
    pub(super) end: Instant,
    /// All fingers are to end.
    pub(super) over: AtomicBool,
    /// Loops that are ready for their first turn, and whether they may take it.
    pub(super) ready: AtomicUsize,
    pub(super) go: AtomicBool,
    pub(super) watched: bool,
}

/// A finger's loop that has ended, and why its wires may still be on.
pub(super) type Ended = (Done<RealSkin, FingerEnd>, Option<String>);

/// A finger's session on hardware.
pub(super) type RealSession = Session<RealSkin, FingerEnd>;

impl Shared<'_> {
    /// Every loop on its own thread, until the scene's end, a signal, or the end of all of them.
    pub(super) fn drive(
        &self,
        sessions: Vec<RealSession>,
        records: &mut Records,
    ) -> Result<(Vec<Ended>, Option<Wish>), Failure> {
        let (say, said) = channel();
        std::thread::scope(|scope| {
            let count = sessions.len();
            let mut threads = Vec::new();
            for (finger, session) in sessions.into_iter().enumerate() {
                let turns = Turns::new(self, finger, session, say.clone());
                let thread = std::thread::Builder::new()
                    .name("loop".into())
                    .spawn_scoped(scope, || turns.whole());
                match thread {
                    Ok(thread) => threads.push(thread),
                    Err(e) => {
                        self.over.store(true, Ordering::Relaxed);
                        self.warden.give_up("a loop has no thread");
                        return Err(Failure::Device(format!("a loop's thread: {e}")));
                    }
                }
            }
            drop(say);
            while self.ready.load(Ordering::Relaxed) < count && !self.is_over() {
                self.clock.sleep_until(self.clock.now() + WAIT);
            }
            self.warden.begin(self.clock.now());
            self.go.store(true, Ordering::Relaxed);
            let stopped = self.listen(&said, records);
            // A loop that panicked has had the guardian switch everything off.
            let panicked =
                || Failure::Device("a loop panicked; the guardian switches everything off".into());
            let done = threads
                .into_iter()
                .map(|t| t.join().ok().flatten().ok_or_else(panicked));
            Ok((done.collect::<Result<_, _>>()?, stopped))
        })
    }

    fn is_over(&self) -> bool {
        self.over.load(Ordering::Relaxed)
    }

    /// Hands what loops say to the records until all have ended; what has stopped them before their time.
    fn listen(&self, said: &Receiver<Said>, records: &mut Records) -> Option<Wish> {
        let progress = Progress::of_part("run");
        let mut stopped = None;
        loop {
            match said.recv_timeout(ROUND) {
                Ok(said) => {
                    if let Some(wish) = records.take(said) {
                        stopped = Some(wish);
                        self.over.store(true, Ordering::Relaxed);
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return stopped,
            }
            if records.have_failed() {
                self.over.store(true, Ordering::Relaxed);
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
    session: RealSession,
    say: Sender<Said>,
    /// Events said so far, and when.
    told: usize,
    said: Instant,
    watch: Watch,
}

impl<'a> Turns<'a> {
    const fn new(
        shared: &'a Shared<'a>,
        finger: usize,
        session: RealSession,
        say: Sender<Said>,
    ) -> Self {
        Self {
            shared,
            finger,
            session,
            say,
            told: 0,
            said: Instant::ZERO,
            watch: Watch::new(),
        }
    }

    /// The loop; none where it panicked. Then the guardian switches everything off: the program is wrong.
    fn whole(self) -> Option<Ended> {
        let shared = self.shared;
        let done = catch_unwind(AssertUnwindSafe(|| self.run()));
        if done.is_err() {
            shared.over.store(true, Ordering::Relaxed);
            shared.warden.give_up("a loop panicked");
        }
        done.ok()
    }

    fn run(mut self) -> Ended {
        let shared = self.shared;
        let realtime = self.take_priority();
        shared.ready.fetch_add(1, Ordering::Relaxed);
        while !shared.go.load(Ordering::Relaxed) && !shared.is_over() {
            shared.clock.sleep_until(shared.clock.now() + WAIT);
        }
        let mut pacer = Pacer::new(shared.clock);
        let mut now = pacer.wait(shared.clock.now());
        let mut goes_on = self.session.failure().is_none();
        while goes_on && now < shared.end && self.goes_on(now) {
            match self.turn() {
                Ok(Turn::Next(next)) => now = pacer.wait(next),
                Ok(Turn::Last) => goes_on = false,
                Err(failure) => {
                    self.session.set_failure(failure);
                    goes_on = false;
                }
            }
        }
        let end = shared.clock.now();
        let mut left = switch_off(&mut self.session, end);
        if let Some(cause) = &left {
            self.session.set_failure(Failure::Device(cause.clone()));
        }
        if self.session.overrun().is_some() {
            // What passed a limit ends the whole run.
            shared.over.store(true, Ordering::Relaxed);
        }
        // Wires that could not be switched off are tried again for as long as other fingers go on, and where no guardian is left
        // until they are off.
        while left.is_some() && (self.is_alone() || now < shared.end && self.goes_on(now)) {
            now = pacer.wait(shared.clock.now() + Policy::REAL.retry);
            left = switch_off_again(&mut self.session, now);
        }
        // What was switched off is off by now.
        let end = shared.clock.now();
        let failed = self.session.failure().is_some();
        let off = left.map_or(Ok(()), |cause| Err(left_on(&mut self.session, cause)));
        let left = self.session.display().part(off, failed).err();
        let guard = self.session.projector().guard();
        shared.warden.heat.leave(self.finger, end, guard);
        self.tell(Instant::FAR_FUTURE);
        let lateness = pacer.lateness().clone();
        let session = self.session;
        (
            Done {
                session,
                lateness,
                realtime,
                not_recorded: 0,
                end,
            },
            left,
        )
    }

    /// Whether nobody else switches off what this finger leaves on.
    fn is_alone(&mut self) -> bool {
        !self.session.display().is_guarded()
    }

    /// As the bench says.
    fn take_priority(&mut self) -> bool {
        priority(self.shared.real.realtime).unwrap_or_else(|refused| {
            self.session.set_failure(refused);
            self.shared.over.store(true, Ordering::Relaxed);
            false
        })
    }

    /// Before a turn: this finger's part of the heartbeat, signals, records.
    fn goes_on(&mut self, now: Instant) -> bool {
        let shared = self.shared;
        let over = || shared.over.store(true, Ordering::Relaxed);
        if !goes_on(&mut self.session, &mut self.watch, now, over) {
            over();
            return false;
        }
        if shared.signals.caught().is_some() || shared.is_over() {
            return false;
        }
        assert!(
            self.finger > 0 || !shared.signals.wants_panic(),
            "a drill, by PALPATE_DRILL and SIGUSR1"
        );
        self.tell(now);
        true
    }

    /// A turn once the bus is free. A transfer of another finger that takes long has failed: this one is off as well,
    /// and its session brings it back.
    fn turn(&mut self) -> Result<Turn, Failure> {
        let clock = self.shared.clock;
        let asked = clock.now();
        self.session.display().wait();
        let now = clock.now();
        let latched = self.session.projector().guard().latched();
        if now.since(asked) > HELD_UP && latched.is_none() {
            let (end, projector, recorder) = self.session.all();
            let (banks, _) = end.parts();
            if let Err(error) = projector.all_off(now, Cause::ActuatorError, banks, recorder) {
                self.session.lose(&error);
            }
        }
        self.session.turn(now)
    }

    /// Hands what is new to the records.
    fn tell(&mut self, until: Instant) {
        let (finger, told) = (self.finger, self.told);
        let skin = self.session.skin();
        let frames = skin.take_frames();
        let buses = match self.shared.watched {
            true => lines(&self.shared.real.can, &skin.tallies()),
            false => Vec::new(),
        };
        let (_, _, look) = self.session.look();
        let state = self.shared.watched.then(|| look.state(Wants::READINGS));
        let recorder = self.session.recorder();
        let events = recorder.events.get(told..).unwrap_or_default().to_vec();
        let taxels = recorder
            .taxels
            .as_mut()
            .map(Readings::take_frames)
            .unwrap_or_default();
        let counts = recorder.counts.clone().unwrap_or_default();
        let is_new = !(events.is_empty() && frames.is_empty() && taxels.is_empty());
        if is_new || self.shared.watched || until.since(self.said) > SAY {
            self.told += events.len();
            self.said = until;
            // Records whose writer has failed end the run on their own.
            let _ = self.say.send(Said {
                finger,
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
}
