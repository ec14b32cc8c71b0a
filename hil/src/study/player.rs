//! Plays what a trial plays, and remembers what the wearer had.

use palpate_core::contact::Levels;
use palpate_core::guard::{Booked, Memory};
use palpate_core::units::{Duration, Instant};
use palpate_files::Setup;
use palpate_records::measure::length_us;
use palpate_records::schedule::write_records;
use palpate_records::trace::Trace;
use palpate_run::{Failure, Input, Keep, build, pass, picture};
use palpate_study::{Interval, Sensed, Stimulus};

use super::rehearsal::{Rehearsals, bursts, path, sensed};
use super::stimuli::Stimuli;
use palpate_live::serve::Desk;
use palpate_live::views::Wanted;
use palpate_live::{clock, host};

/// A bench that plays stimuli one after the other.
#[derive(Debug)]
pub struct Player {
    stimuli: Stimuli,
    rehearsals: Rehearsals,
    seed: u64,
    /// Heat and dose as of [`Self::until`].
    memory: Memory,
    /// End of the last stimulus that was played, in the time of the session.
    until: Instant,
    /// Pages that look on; without pages virtual time is not held to the wall clock.
    desk: Option<Desk>,
    /// The wires were passed, or need no pass.
    is_ready: bool,
    /// Onsets of the last stimulus as the bench's person feels them.
    sensed: Vec<Sensed>,
}

/// Time at which everything was off.
pub type Off = std::time::Instant;

/// Outcome of a stimulus.
#[derive(Debug)]
pub enum Went {
    /// The stimulus was played to its end.
    Whole,
    /// STOP cut it short; everything was off at this time.
    Stopped(Off),
    /// STOP cut it short at this time, and the bench keeps the stop latched, for this reason.
    Latched(Off, String),
    /// The bench failed, or passed a limit.
    Failed(Failure),
}

impl Player {
    /// A bench on which nothing was played yet. Stimuli that were rehearsed on it need no further rehearsal.
    #[must_use]
    pub fn new(stimuli: Stimuli, rehearsals: Rehearsals, seed: u64, desk: Option<Desk>) -> Self {
        Self {
            stimuli,
            rehearsals,
            seed,
            memory: Memory::default(),
            until: Instant::ZERO,
            desk,
            is_ready: false,
            sensed: Vec::new(),
        }
    }

    /// Stimuli of the bench.
    #[must_use]
    pub const fn stimuli(&self) -> &Stimuli {
        &self.stimuli
    }

    /// The hot pass that comes before the next trial at a time of the session, ms, with the bursts that it has at most.
    ///
    /// # Errors
    /// [`Failure`] of a bench that cannot play it.
    pub fn due_pass(&self, now_ms: u64) -> Result<Option<Interval>, Failure> {
        let due = self.stimuli.unpassed()?.filter(|_| !self.is_ready);
        let interval = |setup| {
            Ok(Interval {
                began_ms: self.begins(now_ms).as_micros() / 1000,
                bursts: pass::bookings(&setup)?.iter().map(of_record).collect(),
                ..Interval::default()
            })
        };
        due.map(interval).transpose()
    }

    /// Passes cold wires at a time of the session, ms, once. Returns a note on it; `None` where the wires need no pass.
    ///
    /// # Errors
    /// [`Failure`] of a bench that cannot play it, and [`Failure::Stopped`] for STOP on a page.
    pub fn pass(&mut self, now_ms: u64) -> Result<Option<String>, Failure> {
        let due = self.stimuli.unpassed()?.filter(|_| !self.is_ready);
        let Some(mut setup) = due else {
            return Ok(None);
        };
        let began = self.begin(&mut setup, now_ms);
        let (after, report) = host::passed(&setup, self.seed, self.wanted())?;
        self.is_ready = true;
        if pass::is_due(&after) {
            self.stimuli.leave_cold();
        }
        if let Some(report) = &report {
            self.until = began + Duration::from_micros((report.length_s * 1e6).round() as u64);
            self.memory = after.memory.unwrap_or_default();
        }
        Ok(after.told)
    }

    /// Takes over what was played in the session before the program was begun again.
    ///
    /// # Errors
    /// [`Failure`] of a bench that has no guard.
    pub fn remember<'a>(
        &mut self,
        intervals: impl Iterator<Item = &'a Interval>,
    ) -> Result<(), Failure> {
        let mut guard = self.stimuli.guard()?;
        for interval in intervals {
            let bursts = interval.bursts.iter();
            let bursts = bursts.map(|[wire, on_us, off_us, energy_nj]| {
                let booked = Booked {
                    on: Instant::from_micros(*on_us),
                    off: Instant::from_micros(*off_us),
                    energy_nj: *energy_nj,
                };
                (u16::try_from(*wire).unwrap_or(u16::MAX), booked)
            });
            let began = Instant::from_micros(interval.began_ms.saturating_mul(1000));
            let over = guard.repeat(began, &bursts.collect::<Vec<_>>());
            self.until = self.until.max(over);
        }
        self.memory = guard.memory(self.until);
        Ok(())
    }

    /// Heat and dose as of a time of the session.
    fn memory(&self, at: Instant) -> Memory {
        self.memory.after(Some(at.since(self.until)))
    }

    /// Start of a stimulus that is asked for at a time of the session, ms: no earlier than the end of the last one.
    fn begins(&self, now_ms: u64) -> Instant {
        Instant::from_micros(now_ms.saturating_mul(1000)).max(self.until)
    }

    /// Lets a setup go on from the heat and dose of the session at a time, ms. Returns the start of what it plays.
    fn begin(&mut self, setup: &mut Setup, now_ms: u64) -> Instant {
        let began = self.begins(now_ms);
        (self.memory, self.until) = (self.memory(began), began);
        setup.memory = Some(self.memory.clone());
        began
    }

    /// Views of whatever the session plays.
    fn wanted(&self) -> Wanted<'_> {
        Wanted {
            desk: self.desk.as_ref(),
            quiet: true,
            ..Wanted::default()
        }
    }

    /// Bookings that a guard makes at most for a stimulus at a time of
    /// the session, ms: those from rest. `None` where there are none.
    ///
    /// # Errors
    /// [`Failure`] of a bench that cannot play it.
    pub fn booking(
        &mut self,
        stimulus: &Stimulus,
        now_ms: u64,
    ) -> Result<Option<Interval>, Failure> {
        let began = self.begins(now_ms);
        let rehearsed = self.rehearsals.rehearsal(&self.stimuli, stimulus)?;
        let interval = || Interval {
            stimulus: Some(stimulus.clone()),
            began_ms: began.as_micros() / 1000,
            bursts: rehearsed.bursts.iter().map(of_record).collect(),
            ..Interval::default()
        };
        Ok((!rehearsed.bursts.is_empty()).then(interval))
    }

    /// Plays a stimulus at a time of the session, ms. Returns what was played of it, and how it went.
    ///
    /// # Errors
    /// [`Failure`] of a bench that cannot play it.
    pub fn play(&mut self, stimulus: &Stimulus, now_ms: u64) -> Result<(Interval, Went), Failure> {
        let mut setup = self.stimuli.setup(stimulus)?;
        let began = self.begin(&mut setup, now_ms);
        let outcome = host::run(
            &setup,
            &Input::Scene,
            self.seed,
            Keep::default(),
            self.wanted(),
        )?;
        let off = clock::now();
        let trace = &outcome.trace;
        let mut guard = build(&setup, 1, Levels::Off)?.guard().clone();
        let bursts = bursts(&guard, trace);
        self.sensed = sensed(&trace.events);
        let interval = Interval {
            stimulus: Some(stimulus.clone()),
            began_ms: began.as_micros() / 1000,
            schedule: schedule(trace)?,
            path: path(&setup, &trace.events),
            bursts: bursts.iter().map(of_record).collect(),
        };
        let over = guard.repeat(Instant::ZERO, &bursts) + Duration::from_micros(length_us(trace));
        self.memory = guard.memory(over);
        self.until = began + over.since(Instant::ZERO);
        let conclusion = &outcome.summary.conclusion;
        let went = match outcome.failure {
            // Whatever else it came to: no trial follows one that passed a limit.
            _ if conclusion.verdict.is_harmful() => Went::Failed(Failure::Check(conclusion.line())),
            Some(Failure::Guard(text)) if self.is_stopped() => Went::Latched(off, text),
            Some(failure) => Went::Failed(failure),
            None if self.is_stopped() => Went::Stopped(off),
            None => Went::Whole,
        };
        Ok((interval, went))
    }

    /// Onsets of the last stimulus as the bench's person feels them; none on a bench that no emulated person wears.
    #[must_use]
    pub fn sensed(&self) -> &[Sensed] {
        &self.sensed
    }

    fn is_stopped(&self) -> bool {
        self.desk.as_ref().is_some_and(Desk::is_stopped)
    }

    /// The session's time, ms, at which what was played is over.
    #[must_use]
    pub const fn until_ms(&self) -> u64 {
        self.until.as_micros() / 1000
    }

    /// The share of each limit that is used at a time of the session, ms.
    ///
    /// # Errors
    /// [`Failure`] of a bench that has no guard.
    pub fn used(&self, now_ms: u64) -> Result<Vec<(&'static str, f64)>, Failure> {
        let mut setup = self.stimuli.emulated(&Stimulus::Silence)?;
        setup.memory = Some(self.memory(Instant::from_micros(now_ms.saturating_mul(1000))));
        let projector = build(&setup, 1, Levels::Off)?;
        Ok(picture::used(projector.guard(), Instant::ZERO))
    }
}

fn of_record((wire, burst): &(u16, Booked)) -> [u64; 4] {
    let (on, off) = (burst.on.as_micros(), burst.off.as_micros());
    [u64::from(*wire), on, off, burst.energy_nj]
}

/// The records of a schedule, without its head.
fn schedule(trace: &Trace) -> Result<Vec<serde_json::Value>, Failure> {
    let mut text = Vec::new();
    let period_ns = trace.header.pre_scale.period_ns();
    // Writing to memory does not fail, and what is written there are lines of JSON.
    let failed = |e: String| Failure::Device(format!("the schedule of a trial: {e}"));
    write_records(&trace.events, period_ns, &mut text).map_err(|e| failed(e.to_string()))?;
    let lines = String::from_utf8_lossy(&text).into_owned();
    let values = lines.lines().map(serde_json::from_str);
    values
        .collect::<Result<_, _>>()
        .map_err(|e| failed(e.to_string()))
}
