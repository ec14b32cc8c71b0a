//! Records of the two ends, in the formats of `hil`, and the report of a run.

use std::collections::BTreeSet;
use std::path::PathBuf;

use palpate_core::projector::Projector;
use palpate_core::units::{Duration, Instant, Point};
use palpate_files::{Format, SensorLayout, Setup};
use palpate_live::output::Outputs;
use palpate_live::record::{About, Journal, Sink};
use palpate_records::digest::short_digest;
use palpate_records::trace::Event;
use palpate_run::unit::UnitReport;
use palpate_run::{Failure, attachments, header, plan};
use serde::Serialize;
use zenoh::Session;

use crate::budget::{Budget, MOST, Samples, Spread};
use crate::judge::{Gate, Head, Tally};
use crate::name::FingerName;

/// Beginning of the events by which a wearer's recording states the bounds of its clock against the robot's: `LOW to
/// HIGH us` follow.
pub const OFFSET_WORDS: &str = "clock minus the robot's: ";

/// A number that no other start of a program has.
#[must_use]
pub fn session_of(session: &Session) -> u64 {
    let id = session.zid().to_le_bytes();
    let digits = id.iter().take(8).enumerate();
    // Zero means none.
    digits
        .fold(0, |n, (i, byte)| n | u64::from(*byte) << (8 * i))
        .max(1)
}

/// Digest of the places of a layout's taxels: equal on two machines where a contact's place means the same.
#[must_use]
pub fn layout_digest(file: &SensorLayout) -> u64 {
    let um = |p: Point| ((p.x * 1e3).round() as i64, (p.y * 1e3).round() as i64);
    let mut text = format!("axes {}", file.axes);
    if let Ok(layout) = plan::layout(file) {
        for module in layout.modules() {
            let points: Vec<_> = module.points().iter().map(|p| um(*p)).collect();
            text += &format!(
                "\n{:?} {:?} {points:?}",
                um(module.origin()),
                module.active()
            );
        }
    }
    u64::from_str_radix(&short_digest(&text), 16).unwrap_or(0)
}

/// The records that a run leaves, begun.
///
/// # Errors
/// [`Failure`] for a file of no such format, or one that cannot be written.
pub fn journal(
    setup: &Setup,
    seed: u64,
    projector: &Projector,
    files: &[PathBuf],
    force: bool,
) -> Result<Journal, Failure> {
    let with_format = |path: &PathBuf| match Format::of_name(path).filter(|format| format.grows()) {
        Some(format) => Ok((format, path.clone())),
        None => Err(Failure::Input(format!(
            "--record {}: expected a name that ends in .mcap, .csv, .jsonl, .log or .vcd",
            path.display()
        ))),
    };
    let files: Vec<_> = files.iter().map(with_format).collect::<Result<_, _>>()?;
    let (header, attached) = (header(setup, seed, projector)?, attachments(setup));
    let about = About::Run(&header, &[], &attached);
    let sinks = Sink::create_all(&files, &about, Outputs::new(force))?;
    Journal::start(sinks, false)
}

/// Tells whether frames of buses belong in one of these files.
#[must_use]
pub fn keeps_frames(files: &[PathBuf]) -> bool {
    let mut formats = files.iter().filter_map(|path| Format::of_name(path));
    formats.any(|format| matches!(format, Format::Candump | Format::Mcap))
}

/// Report of a run of the wearer's end.
#[derive(Debug, Default, Serialize)]
pub struct Felt {
    finger: String,
    wearer: String,
    session: String,
    /// Frames that reached the loop.
    pub held: u64,
    /// Messages that cannot be read, or contacts of another skin.
    pub damaged: u64,
    /// Messages that found no room.
    overflowed: u64,
    frames: Tally,
    /// Ages of readings when they arrived: upper bounds.
    age_ms: Option<Spread>,
    /// Time on the network beyond the fastest frame's, a part of the age: a lower bound.
    flight_ms: Option<Spread>,
    /// Latency from the reading to the skin, part by part.
    latency: Budget,
    /// Durations of stimuli.
    stimulus_ms: Option<Spread>,
    /// Times from one reading that was felt to the next.
    gap_ms: Option<Spread>,
    /// Our clock minus the robot's, microseconds: least and most, at the end.
    offset_us: Option<(i64, i64)>,
    /// Stimuli that began.
    stimuli: u64,
    /// Report of the driver unit; `None` where the bench has none.
    pub unit: Option<UnitReport>,
    /// Times without a fresh reading.
    pauses: Vec<Pause>,
    length_us: u64,
    /// Start of the run's clock, CLOCK_MONOTONIC of this machine, nanoseconds.
    epoch_ns: i64,
    #[serde(skip)]
    ages: Samples,
    #[serde(skip)]
    flights: Samples,
    #[serde(skip)]
    lasts: Samples,
    #[serde(skip)]
    gaps: Samples,
    #[serde(skip)]
    before: Option<Instant>,
    /// Time at which an output went low last, microseconds.
    #[serde(skip)]
    fell_us: Option<u64>,
    #[serde(skip)]
    told: BTreeSet<&'static str>,
}

/// A time without a fresh reading, microseconds of the run.
#[derive(Clone, Copy, Debug, Serialize)]
struct Pause {
    /// Time of the newest reading before the pause, as old as it may have been.
    newest_us: u64,
    /// Time at which the last output went off; null where none was on since the reading, or nothing tells of outputs.
    off_us: Option<u64>,
    /// Time of the first stimulus after the pause.
    back_us: Option<u64>,
}

/// Time for which a reading is fresh.
const FRESH: Duration = Duration::from_millis(100);

impl Felt {
    /// A report before the first frame.
    #[must_use]
    pub fn new(finger: &FingerName, wearer: &str, session: u64, epoch_ns: i64) -> Self {
        Self {
            epoch_ns,
            finger: finger.to_string(),
            wearer: wearer.into(),
            session: format!("{session:016x}"),
            ..Self::default()
        }
    }

    /// Takes a frame that came through the gate.
    pub fn arrived(&mut self, head: &Head, at: Instant, now: Instant, offset: Option<(i64, i64)>) {
        self.offset_us = offset;
        self.ages.keep(now.since(at).as_micros());
        if let Some((_, high)) = offset {
            let sent = i64::try_from(head.sent_us).unwrap_or(i64::MAX);
            let here = i64::try_from(now.as_micros()).unwrap_or(i64::MAX);
            let least = here.saturating_sub(sent.saturating_add(high));
            self.flights.keep(u64::try_from(least).unwrap_or(0));
        }
        if let Some(before) = self.before {
            self.gaps.keep(at.since(before).as_micros());
        }
        self.before = Some(at);
    }

    /// Looks at the newest felt reading, every turn: at its age, and whether outputs are on.
    pub fn look(&mut self, newest: Option<Instant>, now: Instant) {
        let Some(newest) = newest else { return };
        let open = self.pauses.last().is_some_and(|p| p.back_us.is_none());
        if now.since(newest) >= FRESH && !open && self.pauses.len() < MOST {
            self.pauses.push(Pause {
                newest_us: newest.as_micros(),
                off_us: self.fell_us.filter(|at| *at > newest.as_micros()),
                back_us: None,
            });
        }
    }

    /// Tells whether a word was not said yet, and remembers it.
    pub fn is_news(&mut self, word: &'static str) -> bool {
        self.told.insert(word)
    }

    /// Counts an event.
    pub fn see(&mut self, event: &Event) {
        match event {
            Event::Edge(edge) if !edge.high => {
                self.fell_us = Some(edge.t_ns / 1000);
                let last = self.pauses.last_mut();
                if let Some(pause) = last.filter(|p| p.back_us.is_none()) {
                    pause.off_us = self.fell_us;
                }
            }
            Event::Schedule(entry) => {
                self.stimuli += 1;
                self.lasts.keep(entry.until.since(entry.at).as_micros());
                let last = self.pauses.last_mut();
                if let Some(pause) = last.filter(|p| p.back_us.is_none()) {
                    pause.back_us = Some(entry.at.as_micros());
                }
            }
            _ => {}
        }
    }

    /// Finishes the report at the run's end.
    pub fn finish(&mut self, gate: &Gate, end: Instant, overflowed: u64, latency: Budget) {
        self.frames = *gate.tally();
        self.offset_us = gate.offset(end).or(self.offset_us);
        self.overflowed = overflowed;
        self.length_us = end.as_micros();
        self.age_ms = self.ages.spread();
        self.gap_ms = self.gaps.spread();
        self.flight_ms = self.flights.spread();
        self.latency = latency;
        self.stimulus_ms = self.lasts.spread();
    }

    /// The latency budget.
    #[must_use]
    pub const fn latency(&self) -> &Budget {
        &self.latency
    }

    /// Words of the report, in a line.
    #[must_use]
    pub fn line(&self) -> String {
        let age = self.age_ms.unwrap_or_default();
        format!(
            "{} felt by {}: {} frames, {} not felt in time, {} lost; age at most {:.1} ms (median), {:.1} ms (99 %); {} times without a fresh reading",
            self.finger,
            self.wearer,
            self.held,
            self.frames.late,
            self.frames.lost,
            age.median,
            age.p99,
            self.pauses.len(),
        )
    }
}
