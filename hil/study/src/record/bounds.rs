//! Bounds of the numbers of a record. No session writes one beyond these; a guard that takes over such bursts would be
//! busy with them for ever.

use super::{About, Interval, Line, Played, Uptime};
use crate::session::Stimulus;

/// Longest session, and longest uptime, ms: ten years.
const MOST_MS: u64 = 3660 * 86_400_000;
/// Longest interval, microseconds: a day, for a wire that nothing switched off.
const LONGEST_US: u64 = 86_400_000_000;
/// Most energy of a burst, nJ: ten watts for all of that.
const MOST_NJ: u64 = 1_000_000_000_000_000;
/// Most trials, attempts at one, participants.
const MOST: u64 = 1_000_000;
/// Most wires of a display.
const MOST_WIRES: usize = 4096;
/// Most intervals of a trial.
const MOST_INTERVALS: usize = 2;
/// Farthest level from full drive, dB.
const MOST_DB: f64 = 200.0;
/// Farthest place from the display's middle, mm.
const FARTHEST_MM: f64 = 10_000.0;

fn at_most(what: &str, value: u64, most: u64) -> Result<(), String> {
    match value <= most {
        true => Ok(()),
        false => Err(format!("{what} is {value}, more than {most}")),
    }
}

fn within(what: &str, value: f64, most: f64) -> Result<(), String> {
    match value.abs() <= most {
        true => Ok(()),
        false => Err(format!("{what} is {value}, not within {most}")),
    }
}

/// Checks that the numbers of a session's first line are within bounds. The error is a sentence.
pub(super) fn of_session(about: &About) -> Result<(), String> {
    at_most("participant", about.participant.into(), MOST)?;
    at_most("began_unix_ms", about.began_unix_ms, 100 * MOST_MS)?;
    within("dose_planned", about.dose_planned, 1.0)?;
    of_uptime(&about.uptime)?;
    at_most("wires", about.wires_mm.len() as u64, MOST_WIRES as u64)?;
    let mut places = about.wires_mm.iter().flatten();
    places.try_for_each(|mm| within("wires_mm", *mm, FARTHEST_MM))
}

/// Checks that a later line comes after one at `before_ms`, and that its numbers are within bounds on a display of so
/// many wires. The error is a sentence.
pub(super) fn of_line(line: &Line, before_ms: u64, wires: usize) -> Result<(), String> {
    let at_ms = line.at_ms();
    if at_ms <= before_ms {
        return Err(format!(
            "at_ms is {at_ms}, not after the line before, {before_ms}"
        ));
    }
    at_most("at_ms", at_ms, MOST_MS)?;
    match line {
        Line::Playing(playing) => {
            at_most("number", playing.number.into(), MOST)?;
            at_most("attempt", playing.attempt.into(), MOST)?;
            of_interval(&playing.interval, wires)
        }
        Line::Passing(passing) => of_interval(&passing.interval, wires),
        Line::Reply(said) => said.trial.iter().try_for_each(|of| of_trial(of, wires)),
        Line::Resumed(resumed) => of_uptime(&resumed.uptime),
        Line::Session(_) | Line::Note(_) | Line::Stopped(_) => Ok(()),
    }
}

fn of_uptime(uptime: &Uptime) -> Result<(), String> {
    at_most("uptime.ms", uptime.ms, MOST_MS)
}

fn of_trial(played: &Played, wires: usize) -> Result<(), String> {
    at_most("number", played.number.into(), MOST)?;
    at_most("attempt", played.attempt.into(), MOST)?;
    at_most("right", played.right.unwrap_or(0).into(), 2)?;
    at_most("asked_ms", played.asked_ms, MOST_MS)?;
    within("level_db", played.level_db.unwrap_or(0.0), MOST_DB)?;
    let intervals = &played.intervals;
    at_most("intervals", intervals.len() as u64, MOST_INTERVALS as u64)?;
    intervals.iter().try_for_each(|i| of_interval(i, wires))
}

fn of_interval(interval: &Interval, wires: usize) -> Result<(), String> {
    let is_one = |wire: u64| match wire < wires as u64 {
        true => Ok(()),
        false => Err(format!("wire is {wire}, of {wires} from 0 on")),
    };
    if let Some(Stimulus::Wire { wire, level_db }) = interval.stimulus {
        is_one(wire.into())?;
        within("level_db", level_db, MOST_DB)?;
    }
    at_most("began_ms", interval.began_ms, MOST_MS)?;
    for [wire, on_us, off_us, energy_nj] in &interval.bursts {
        is_one(*wire)?;
        at_most("when a burst goes off, us,", *off_us, LONGEST_US)?;
        at_most("when it went on, us,", *on_us, *off_us)?;
        at_most("energy of a burst, nJ,", *energy_nj, MOST_NJ)?;
    }
    let mut path = interval.path.iter().flatten();
    path.try_for_each(|value| within("path", *value, FARTHEST_MM))
}
