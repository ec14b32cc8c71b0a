//! The loop of a run in real time, turn by turn.

use palpate_buses::pacer::{Lateness, Pacer, RunClock, Watch};
use palpate_buses::signals::Signals;
use palpate_core::projector::Projector;
use palpate_core::units::Instant;
use palpate_records::readings::Readings;
use palpate_run::{Failure, Policy, Recorder, Session, Truth, Turn, TurnView};

use super::ends::{Sensed, Watched, begin, leave};
use super::priority;
use crate::clock;
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
        let mut recorder = Recorder::new(truth, projector.layout());
        recorder.counts = self.views.are_open().then(Vec::new);
        recorder.readings = Some(Readings::sampled(projector.layout(), self.drives));
        recorder.taxels = self.taxels.take();
        let realtime = priority(self.realtime).inspect_err(|_| {
            // Nothing is on yet: the good-bye cannot fail in a way that matters more than this.
            let _ = display.part(Ok(()), true);
        })?;
        let run_clock = self.clock;
        let ends = (skin, display);
        let mut session = Session::new(
            projector,
            ends,
            Policy::REAL,
            recorder,
            Some(clock::elapsed),
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
        if let Some(unseen) = self.watch.look(now) {
            session.unseen(now, unseen.uncounted(), &unseen.to_string());
            return false;
        }
        if let Err(failure) = session.display().beat(now) {
            session.set_failure(failure);
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
        while let Some(note) = session.skin().note() {
            session.recorder().note(note.at, note.text);
        }
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
        let (skin, recorder, look) = session.look();
        let tallies = skin.tallies();
        let wish = self.views.turn(&TurnView {
            now,
            display: 0,
            events: &recorder.events,
            counts: recorder.counts.as_deref().unwrap_or_default(),
            buses: &|| lines(self.can, &tallies),
            state: &|wants| look.state(wants),
        })?;
        let text = format!("stopped by {}", wish.by());
        session.recorder().note(now, text);
        Some(wish)
    }
}
