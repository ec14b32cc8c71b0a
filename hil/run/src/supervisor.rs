//! Answers of a run to hardware that stops answering: outputs off at once, a bounded wait, a way back.

use palpate_core::driver::Driver;
use palpate_core::projector::{Projector, Update};
use palpate_core::units::{Duration, Instant};
use palpate_records::trace::Event;

use crate::display_end::OutputEnable;
use crate::failure::Failure;
use crate::recorder::Recorder;
use crate::skin_end::SkinEnd;

/// Silence after which a board is told to start again.
const SILENT: Duration = Duration::from_millis(200);
/// Time between two looks for silent boards.
const ROUND: Duration = Duration::from_millis(100);

/// Watches both buses of a run.
#[derive(Debug)]
pub struct Supervisor {
    /// Time for which an actuator bus may be dead before the run ends.
    give_up: Duration,
    /// Time at which the actuator bus was lost, and its last error.
    lost: Option<(Instant, String)>,
    retries: u64,
    /// Time at which the guard's latch closed.
    stopped: Option<Instant>,
    next_round: Instant,
    /// Boards that are silent, by module.
    silent: Vec<bool>,
}

impl Supervisor {
    /// A supervisor that waits `give_up` for a dead actuator bus.
    pub const fn new(give_up: Duration) -> Self {
        Self {
            give_up,
            lost: None,
            stopped: None,
            retries: 0,
            next_round: Instant::ZERO,
            silent: Vec::new(),
        }
    }

    /// Takes the actuator bus as lost, and notes it. Outputs were cut through the chips' OE line, which needs no bus,
    /// where there is one: the words `cut` tell it.
    pub fn lose(&mut self, now: Instant, error: &str, cut: &str, events: &mut Vec<Event>) {
        self.lost = Some((now, error.to_string()));
        note(events, now, format!("actuators: {error}; {cut}"));
    }

    /// Tells whether the actuator bus is lost.
    pub const fn is_lost(&self) -> bool {
        self.lost.is_some()
    }

    /// Tries to start the boards anew; returns when they are ready, if they are.
    ///
    /// # Errors
    /// [`Failure::Device`] once the bus has been dead for too long.
    pub fn recover<U>(
        &mut self,
        now: Instant,
        bank: &mut dyn Driver<U>,
        oe: &dyn OutputEnable,
        events: &mut Vec<Event>,
    ) -> Result<Option<Instant>, Failure> {
        let Some((since, error)) = &self.lost else {
            return Ok(Some(now));
        };
        let since = *since;
        let ms = now.since(since).as_micros() as f64 * 1e-3;
        if let Ok(ready) = bank.start(now) {
            self.lost = None;
            oe.set_enabled(ready, true);
            self.retries = bank.retries();
            note(
                events,
                now,
                format!("actuators: started anew after {ms} ms"),
            );
            return Ok(Some(ready));
        }
        if now.since(since) < self.give_up {
            return Ok(None);
        }
        note(
            events,
            now,
            format!("actuators: dead for {ms} ms, giving up"),
        );
        Err(Failure::Device(format!(
            "{error}; dead for {ms} ms, {}",
            oe.words()
        )))
    }

    /// Tells of transfers that were made again.
    pub fn retried(&mut self, now: Instant, retries: u64, events: &mut Vec<Event>) {
        if retries > self.retries {
            let times = retries - self.retries;
            note(
                events,
                now,
                format!("actuators: transfer tried again, {times} times"),
            );
            self.retries = retries;
        }
    }

    /// Tells of a stop of the guard, and ends it once its cause is gone: frames come again, turns are on time,
    /// boards answer and are off. On a real bench only a failed transfer that left no wire on for too long may end so: the
    /// rest is a person's.
    pub fn resume<U: Update>(
        &mut self,
        now: Instant,
        projector: &mut Projector,
        bank: &mut dyn Driver<U>,
        recorder: &mut Recorder,
    ) {
        let Some(cause) = projector.guard().latched() else {
            return;
        };
        if self.stopped.is_none() {
            self.stopped = Some(now);
            recorder.note(now, format!("stopped: {}", cause.word()));
        }
        if projector.reset(now, bank, recorder).is_ok() {
            let since = self.stopped.take().unwrap_or(now);
            let ms = now.since(since).as_micros() as f64 * 1e-3;
            recorder.note(now, format!("stop ended after {ms} ms, cause gone"));
        }
    }

    /// Tells boards that have gone silent to start: one that rebooted waits for that.
    pub fn restart_boards(
        &mut self,
        now: Instant,
        skin: &mut dyn SkinEnd,
        projector: &Projector,
        events: &mut Vec<Event>,
    ) {
        if now < self.next_round || !skin.has_boards() {
            return;
        }
        self.next_round = now + ROUND;
        let layout = projector.layout();
        self.silent.resize(layout.modules().len(), false);
        for (index, module) in layout.modules().iter().enumerate() {
            if module.address().is_none() {
                continue;
            }
            let times = layout
                .range(index)
                .filter_map(|i| projector.monitor().received(i));
            let last = times.map(|r| r.1).max().unwrap_or(Instant::ZERO);
            let silent = now.since(last) > SILENT;
            if silent != self.silent[index] {
                let what = if silent {
                    "is silent, told to start"
                } else {
                    "sends again"
                };
                note(events, now, format!("board of {}: {what}", module.name()));
                self.silent[index] = silent;
            }
            if silent {
                skin.start(index);
            }
        }
    }
}

/// A line worth keeping.
fn note(events: &mut Vec<Event>, now: Instant, text: String) {
    events.push(Event::note(now, text));
}
