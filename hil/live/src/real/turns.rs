//! The loop of a run in real time, turn by turn.

use palpate_buses::pacer::{Lateness, Pacer, RunClock, Watch};
use palpate_buses::signals::Signals;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_records::readings::Readings;
use palpate_run::{Failure, Session, Truth, Turn};

use super::ends::{Sensed, Watched, assemble, begin, goes_on, leave};
use super::priority;
use crate::interfaces::lines;
use crate::progress::Progress;
use crate::record::Journal;
use crate::views::{STOPPED_BY_PAGE, Views, Wish};

/// What the loop leaves behind.
pub(super) struct Done<S, D> {
    pub(super) session: Session<S, D>,
    pub(super) lateness: Lateness,
    pub(super) realtime: bool,
    pub(super) not_recorded: u64,
    pub(super) end: Instant,
}

/// What paces a session on hardware and watches over it.
pub(super) struct Turns<'a> {
    /// The bench's CAN interfaces.
    pub(super) can: &'a [String],
    /// Whether real-time priority is insisted on, or done without.
    pub(super) realtime: Option<bool>,
    pub(super) clock: RunClock,
    pub(super) signals: Signals,
    pub(super) length: Instant,
    pub(super) drives: usize,
    pub(super) truth: Truth,
    /// Where decoded taxels are recorded.
    pub(super) taxels: Option<Readings>,
    pub(super) journal: Journal,
    pub(super) views: Views,
    pub(super) progress: Progress,
    pub(super) watch: Watch,
}

impl Turns<'_> {
    /// The loop on its own thread, until the scene's end, a signal, or a failure.
    pub(super) fn drive<S: Sensed, D: Watched>(
        mut self,
        projector: Projector,
        (skin, mut display): (S, D),
    ) -> Result<Done<S, D>, Failure> {
        let truth = std::mem::take(&mut self.truth);
        let realtime = priority(self.realtime).inspect_err(|_| {
            // Nothing is on yet: the good-bye cannot fail in a way that matters more than this.
            let _ = display.part(Ok(()), true);
        })?;
        let run_clock = self.clock;
        let mut session = assemble(
            (projector, self.drives),
            (skin, display),
            truth,
            self.taxels.take(),
            self.views.are_open(),
        );
        let ready = begin(&mut session, run_clock)?;
        session.skin().begin();
        let mut pacer = Pacer::new(run_clock);
        let mut now = pacer.wait(ready);
        let (begun, length) = (now, self.length.as_micros() as f64);
        let end = Instant::from_micros(self.length.as_micros().saturating_add(now.as_micros()));
        let mut is_kept = false;
        while now < end && self.goes_on(&mut session, now) {
            self.progress
                .part(now.since(begun).as_micros() as f64 / length);
            match session.turn(now)? {
                Turn::Next(next) => {
                    if let Some(wish) = self.show(&mut session) {
                        is_kept = wish == Wish::Stop;
                        break;
                    }
                    now = pacer.wait(next);
                }
                Turn::Last => break,
            }
        }
        // The screen may take its time; the outputs do not wait for it.
        let stops = is_kept.then_some(STOPPED_BY_PAGE);
        let end = leave(&mut session, run_clock, stops, |session| self.tell(session));
        self.tell(&mut session);
        let not_recorded = self.journal.dropped();
        if let Err(error) = self.journal.finish() {
            session.set_failure(error);
        }
        drop(self.views);
        Ok(Done {
            session,
            lateness: pacer.lateness().clone(),
            realtime,
            not_recorded,
            end,
        })
    }

    /// Before a turn: the display's heartbeat, signals, records.
    fn goes_on<S: Sensed, D: Watched>(
        &mut self,
        session: &mut Session<S, D>,
        now: Instant,
    ) -> bool {
        if !goes_on(session, &mut self.watch, now, || ()) {
            return false;
        }
        if let Some(signal) = self.signals.caught() {
            session.recorder().note(now, format!("stopped by {signal}"));
            return false;
        }
        assert!(
            !self.signals.wants_panic(),
            "a drill, by PALPATE_DRILL and SIGUSR1"
        );
        self.tell(session);
        !self.journal.has_failed()
    }

    /// Hands what is new to the records.
    fn tell<S: Sensed, D: Watched>(&mut self, session: &mut Session<S, D>) {
        let frames = session.skin().take_frames();
        let recorder = session.recorder();
        let taxels = recorder.taxels.as_mut().map(Readings::take_frames);
        self.journal
            .tell(&recorder.events, frames, taxels.unwrap_or_default());
    }

    /// Shows a turn; what those who look on want, noted.
    fn show<S: Sensed, D: Watched>(&mut self, session: &mut Session<S, D>) -> Option<Wish> {
        if !self.views.are_open() {
            return None;
        }
        let now = session.now();
        let tallies = session.seen().0.tallies();
        let buses = || lines(self.can, &tallies);
        let wish = session.show((now, 0), &buses, |seen| self.views.turn(seen))?;
        let text = format!("stopped by {}", wish.by());
        session.recorder().note(now, text);
        Some(wish)
    }
}
