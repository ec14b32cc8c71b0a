//! The guardian's decisions, without a clock, a device, a file or memory: events go in with their time, acts go out
//! through a [`Post`].
//!
//! Two rules hold for every order of events. Outputs come first: an order to switch off waits for no latch, no word and
//! no other bus. And a bus counts as off only once it has answered so to an order that was given after the last moment
//! at which the run could still have driven it.

use arrayvec::{ArrayString, ArrayVec};
use palpate_core::units::{Duration, Instant};

use crate::pacer::{ASLEEP, UNSEEN};

/// Most adapters of a bench.
pub(super) const BUSES: usize = 16;
/// Time between two looks of an awake guardian for a silent run.
const SLICE: Duration = Duration::from_millis(5);
/// Time between two looks of an idle guardian for a wish to end.
const IDLE: Duration = Duration::from_millis(20);
/// Time between two tries of a bus that did not answer.
const RETRY: Duration = Duration::from_millis(10);
/// Time between two orders to a bus that a run which should drive nothing may still reach.
const AGAIN: Duration = Duration::from_millis(30);
/// Time for a run to end after its end of the pair closed or it was told to; time for one that was killed to be gone.
const GRACE: Duration = Duration::from_millis(500);

/// A cause in words, at most as long as a latch keeps.
pub(super) type Text = ArrayString<640>;

/// Causes for which a guardian acts.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[expect(clippy::large_enum_variant, reason = "a box would need memory")]
pub(super) enum Cause {
    /// The run's end closed without a good-bye.
    #[error("the run died without a word")]
    Died,
    /// No heartbeat came for this long.
    #[error("the run hung: no heartbeat for {} ms", .0.as_micros() / 1000)]
    Hung(Duration),
    /// The run asked for it, for this reason.
    #[error("{0}")]
    Asked(Text),
    /// A signal or another program ended the guardian.
    #[error("switched off by `hil off` or a SIGTERM to the guardian")]
    Ended,
    /// Neither this process nor, likely, the run got to act for this long.
    #[error("unseen time: this computer let the guardian stand still for {} ms (a debugger, a frozen container, too much load), and outputs may have been on meanwhile", .0.as_micros() / 1000)]
    Stood(Duration),
    /// The machine slept for this long.
    #[error("unseen time: this computer was suspended for {} ms, and outputs may have been on meanwhile", .0.as_micros() / 1000)]
    Slept(Duration),
    /// The line that cuts all outputs cannot be set.
    #[error("the OE line cannot be set")]
    Line,
}

impl Cause {
    /// A cause in the run's words, cut where they are too many.
    pub(super) fn asked(words: &str) -> Self {
        let mut text = Text::new();
        let _fits = words.chars().all(|letter| text.try_push(letter).is_ok());
        Self::Asked(text)
    }

    /// Tells whether the run has promised to drive nothing any more.
    const fn is_promised(&self) -> bool {
        matches!(self, Self::Asked(_))
    }

    /// Tells whether the run must hear of the cause, since it lives and may not know.
    const fn is_news(&self) -> bool {
        matches!(self, Self::Stood(_) | Self::Slept(_) | Self::Line)
    }
}

/// Events that a guardian decides on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Event<'a> {
    /// Time has passed, and nothing else.
    Time,
    /// The run is alive.
    Beat,
    /// The run's boards are set up: the OE line may be released.
    Release,
    /// The OE line is to cut the outputs.
    Cut,
    /// Everything is to go off and stay off; the run lives on.
    Stop(&'a str),
    /// A part of the outputs is off and stays off; the others go on.
    Latch(&'a str),
    /// Everything is off, the run ends.
    Bye,
    /// The run cannot switch off any more, and ends.
    Trip(&'a str),
    /// A packet that is no word.
    Noise,
    /// The run's end of the pair has closed.
    Closed,
    /// The run's process is gone.
    Gone,
    /// A bus has carried out an order: everything on it is off and reads back so, or that is not known.
    Swept {
        /// Index of the bus.
        bus: usize,
        /// `true` where everything on the bus is known to be off.
        off: bool,
    },
    /// Another program or a signal wants everything off.
    Ended,
}

/// A guardian's answer to its run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Answer {
    Beat,
    /// Everything is known to be off.
    Off,
    NotOff,
    /// The guardian has switched everything off by itself: the run is to end.
    Halt,
}

/// News for people.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum News {
    /// Everything is off, this long after the cause was known.
    Off(Duration),
    /// Some outputs may be on; the guardian tries on.
    Trying,
    /// The run was killed and is still there.
    Stays,
}

/// The hands of a guardian. None of them waits.
pub(super) trait Post {
    /// Cuts the OE line, or releases it. Returns whether that could be done. Without a line there is nothing to do.
    fn cut(&mut self, cut: bool) -> bool;
    /// Orders everything on a bus off and read back; its answer comes as [`Event::Swept`].
    fn off(&mut self, bus: usize);
    /// Ends the run by force.
    fn kill(&mut self);
    /// Latches a stop.
    fn latch(&mut self, cause: &Cause, verified: bool);
    /// Tells people the news.
    fn tell(&mut self, cause: &Cause, news: News);
    /// Answers the run.
    fn answer(&mut self, answer: Answer, cause: Option<&Cause>);
}

/// The time of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Now {
    /// Time on the guardian's clock, which stands still while the machine sleeps.
    pub(super) at: Instant,
    /// Time that the machine has slept since that clock began.
    pub(super) asleep: Duration,
}

/// A bus as the guardian knows it.
#[derive(Clone, Copy, Debug, Default)]
struct Bus {
    ordered: bool,
    /// `true` where the order came too early to prove that the bus is off: another one follows.
    again: bool,
    /// `true` where everything on the bus is off, by an order that was not too early.
    off: bool,
    /// Time of the next order.
    next: Option<Instant>,
}

/// State of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Run {
    Alive,
    Leaving,
    /// The run has said that it cannot switch off, and waits for nothing but the answer.
    Tripped,
    Closed,
    Gone,
}

/// A guardian between two events.
#[derive(Debug)]
pub(super) struct Decider {
    heartbeat: Duration,
    buses: ArrayVec<Bus, BUSES>,
    run: Run,
    /// Silence since the last heartbeat, as far as the guardian got to look; `None` before the first.
    silence: Option<Duration>,
    looked: Option<Now>,
    cause: Option<Cause>,
    /// Time at which the cause became known.
    since: Instant,
    /// Time at which the run is ended by force, and `true` once that has been tried.
    kill: Option<Instant>,
    killed: bool,
    stays: bool,
    cut: bool,
    /// News that people were told last, and whether the latch has the stop as verified.
    told: Option<News>,
    verified: bool,
    end: Option<u8>,
}

impl Decider {
    /// A guardian over so many buses, all off, that waits `heartbeat` for a heartbeat.
    pub(super) fn new(buses: usize, heartbeat: Duration) -> Self {
        Self {
            heartbeat,
            buses: (0..buses.min(BUSES)).map(|_| Bus::default()).collect(),
            run: Run::Alive,
            silence: None,
            looked: None,
            cause: None,
            since: Instant::ZERO,
            kill: None,
            killed: false,
            stays: false,
            cut: true,
            told: None,
            verified: false,
            end: None,
        }
    }

    /// The exit status, once nothing is left to do: 0 after a good-bye, 4 after acting.
    pub(super) const fn end(&self) -> Option<u8> {
        self.end
    }

    /// Time at which [`Self::step`] has to be called at the latest, whatever comes.
    pub(super) fn next(&self) -> Instant {
        let now = self.looked.map_or(Instant::ZERO, |looked| looked.at);
        let silent = self.silence.map(|silence| {
            let left = self
                .heartbeat
                .as_micros()
                .saturating_sub(silence.as_micros());
            now + Duration::from_micros(left + 1).min(SLICE)
        });
        let ordered = self.buses.iter().any(|bus| bus.ordered);
        let idle = now + if ordered { SLICE } else { IDLE };
        let retries = self.buses.iter().filter_map(|bus| bus.next);
        let all = retries.chain(silent).chain(self.kill);
        all.fold(idle, Instant::min)
    }

    /// Takes one event and does the acts that it makes due.
    pub(super) fn step(&mut self, now: Now, event: Event<'_>, post: &mut impl Post) {
        self.look(now, event == Event::Beat, post);
        match event {
            Event::Time => {}
            Event::Beat => {
                self.silence = Some(Duration::ZERO);
                post.answer(Answer::Beat, None);
            }
            Event::Release if self.cause.is_none() => self.set_line(now, false, post),
            Event::Release => {}
            Event::Cut => self.set_line(now, true, post),
            Event::Stop(cause) => self.act(now, Cause::asked(cause), post),
            Event::Latch(cause) => post.latch(&Cause::asked(cause), false),
            Event::Bye => {
                self.part(Run::Leaving);
                self.set_line(now, true, post);
                self.order_all(post);
            }
            Event::Trip(cause) => {
                self.part(Run::Tripped);
                self.act(now, Cause::asked(cause), post);
            }
            Event::Noise => {
                self.part(Run::Tripped);
                self.act(now, Cause::asked("the run sent what is no word"), post);
            }
            Event::Closed => self.close(now, post),
            Event::Gone if matches!(self.run, Run::Alive | Run::Closed) => {
                self.run = Run::Gone;
                (self.silence, self.kill) = (None, None);
                self.act(now, Cause::Died, post);
            }
            // Such a run has said before that it drives nothing any more.
            Event::Gone => {}
            Event::Swept { bus, off } => self.swept(now, bus, off, post),
            Event::Ended => {
                self.act(now, Cause::Ended, post);
                self.kill.get_or_insert(now.at);
            }
        }
        self.go_on(now, post);
        self.conclude(now, post);
    }

    /// Judges the time since the last look: a run that is silent, and time that nobody saw.
    fn look(&mut self, now: Now, is_beat: bool, post: &mut impl Post) {
        let Some(before) = self.looked.replace(now) else {
            return;
        };
        let passed = now.at.since(before.at);
        let slept = Duration::from_micros(
            now.asleep
                .as_micros()
                .saturating_sub(before.asleep.as_micros()),
        );
        let Some(silence) = self.silence else {
            return;
        };
        if slept > ASLEEP {
            self.act(now, Cause::Slept(slept), post);
        } else if passed > UNSEEN {
            self.act(now, Cause::Stood(passed), post);
        }
        // While the guardian did not run, the run did not either, and gets its turn before it is judged.
        let silence = silence + passed.min(SLICE + SLICE);
        self.silence = Some(silence);
        // A run that was told of unseen time has its outputs off by then, and ends by itself.
        let is_told = self.cause.as_ref().is_some_and(Cause::is_news);
        let limit = if is_told { GRACE } else { self.heartbeat };
        if silence > limit && !is_beat {
            self.silence = None;
            self.act(now, Cause::Hung(silence), post);
            self.kill.get_or_insert(now.at);
        }
    }

    /// The run waits for an answer from now on, however long its buses take, and has no heartbeat.
    const fn part(&mut self, how: Run) {
        (self.run, self.silence) = (how, None);
    }

    fn set_line(&mut self, now: Now, cut: bool, post: &mut impl Post) {
        self.cut = cut;
        if !post.cut(cut) && cut {
            self.act(now, Cause::Line, post);
        }
    }

    /// Switches everything off from now on, for this cause unless there is one already.
    fn act(&mut self, now: Now, cause: Cause, post: &mut impl Post) {
        if !self.cut {
            self.cut = true;
            let _ = post.cut(true);
        }
        // Before anything else, and all at once: a bus that is stuck keeps no other one on.
        self.order_all(post);
        if self.cause.is_none() {
            self.since = now.at;
            post.latch(&cause, false);
            if cause.is_news() {
                post.answer(Answer::Halt, Some(&cause));
            }
            self.cause = Some(cause);
        }
    }

    /// Takes the closed end of the run's pair.
    fn close(&mut self, now: Now, post: &mut impl Post) {
        self.silence = None;
        match self.run {
            Run::Alive => {
                self.run = Run::Closed;
                self.act(now, Cause::Died, post);
                self.kill.get_or_insert(now.at + GRACE);
            }
            // The run waited for an answer that is not there yet.
            Run::Leaving | Run::Tripped | Run::Closed | Run::Gone => {}
        }
    }

    fn order_all(&mut self, post: &mut impl Post) {
        for number in 0..self.buses.len() {
            self.order(number, post);
        }
    }

    fn order(&mut self, number: usize, post: &mut impl Post) {
        if let Some(bus) = self.buses.get_mut(number) {
            (bus.off, bus.next) = (false, None);
            if std::mem::replace(&mut bus.ordered, true) {
                bus.again = true;
            } else {
                post.off(number);
            }
        }
    }

    fn swept(&mut self, now: Now, number: usize, off: bool, post: &mut impl Post) {
        // The run may have a transfer on its way that drives this bus again, whatever the other buses do.
        let again = self.may_drive().then_some(now.at + AGAIN);
        let Some(bus) = self.buses.get_mut(number) else {
            return;
        };
        bus.ordered = false;
        if std::mem::take(&mut bus.again) {
            self.order(number, post);
        } else if off {
            (bus.off, bus.next) = (true, again);
        } else {
            bus.next = Some(now.at + RETRY);
            self.not_off(now, post);
        }
    }

    /// Takes the answer of a bus that is not known to be off.
    fn not_off(&mut self, now: Now, post: &mut impl Post) {
        if self.run == Run::Leaving {
            post.answer(Answer::NotOff, None);
            self.run = Run::Tripped;
            let cause = "at the end of the run not everything was known to be off";
            self.act(now, Cause::asked(cause), post);
        }
        if let Some(cause) = &self.cause
            && self.told.is_none()
        {
            self.told = Some(News::Trying);
            post.tell(cause, News::Trying);
        }
    }

    /// Does what has become due: ends the run by force, or tries buses again.
    fn go_on(&mut self, now: Now, post: &mut impl Post) {
        if self.kill.is_some_and(|at| at <= now.at) {
            if self.killed && !std::mem::replace(&mut self.stays, true) {
                post.tell(&Cause::Died, News::Stays);
            }
            self.killed = true;
            self.kill = Some(now.at + GRACE);
            post.kill();
        }
        for number in 0..self.buses.len() {
            let next = self.buses.get(number).and_then(|bus| bus.next);
            if next.is_some_and(|at| at <= now.at) {
                self.order(number, post);
            }
        }
    }

    /// Tells whether the run may still reach a bus although everything is to be off.
    fn may_drive(&self) -> bool {
        match self.run {
            Run::Alive => !self.cause.as_ref().is_some_and(Cause::is_promised),
            Run::Closed => true,
            Run::Leaving | Run::Tripped | Run::Gone => false,
        }
    }

    /// Reports the state by now, and ends where nothing is left to do.
    fn conclude(&mut self, now: Now, post: &mut impl Post) {
        if self.run == Run::Alive && self.cause.is_none() || !self.buses.iter().all(|bus| bus.off) {
            return;
        }
        if let Some(cause) = &self.cause {
            // A run that lives tells its cause by itself.
            let speaks = !cause.is_promised() || self.run == Run::Tripped;
            if speaks && !matches!(self.told, Some(News::Off(_))) {
                let news = News::Off(now.at.since(self.since));
                self.told = Some(news);
                post.tell(cause, news);
            }
            if self.may_drive() {
                return;
            }
            if !std::mem::replace(&mut self.verified, true) {
                post.latch(cause, true);
            }
        }
        self.end = match self.run {
            Run::Alive => return,
            Run::Leaving => Some(0),
            Run::Tripped | Run::Gone | Run::Closed => Some(4),
        };
        post.answer(Answer::Off, None);
    }
}

#[cfg(test)]
#[path = "decide_tests.rs"]
mod tests;
#[cfg(test)]
#[path = "decide_world_tests.rs"]
mod world_tests;
