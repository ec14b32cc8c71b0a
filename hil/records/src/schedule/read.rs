//! A schedule file (JSON Lines) read back into a trace.

use palpate_core::schedule::{Entry, Reason};
use palpate_core::units::{Board, Channel, Clock, Instant, Milliamps, Prescale, Ticks};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;

use super::{HeaderLine, VERSION, WITHOUT_PULSES};
use crate::damage::Damage;
use crate::digest::short_digest;
use crate::trace::{Driven, Event, Header, Ledger, Source, Trace, WireInfo, event};

impl HeaderLine<'_> {
    /// The clock on EXTCLK, if there was one and a chip can take it.
    fn external(&self) -> Option<Clock> {
        Clock::external(self.clock_hz?, self.clock_ppm.unwrap_or(0))
    }

    /// A PRE_SCALE with the clock that it divided.
    fn divided(&self, pre_scale: u8) -> Prescale {
        let clock = self.external().unwrap_or(Clock::INTERNAL);
        Prescale::new(pre_scale).with_clock(clock)
    }
}

/// Content of a record. Another key is refused: no comparison would see it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    t_us: u64,
    board: u8,
    channel: Option<u8>,
    pulses: Option<u64>,
    on: Option<u16>,
    off: Option<u16>,
    period: Option<u64>,
    until_us: Option<u64>,
    requested: Option<u16>,
    requested_until_us: Option<u64>,
    current_ma: Option<u32>,
    #[serde(default)]
    reason: Option<String>,
    pre_scale: Option<u8>,
    all_off: Option<String>,
}

/// Every cause that is written into a schedule.
const CAUSES: [&str; 8] = [
    "start",
    "stale-input",
    "actuator-error",
    "sensor-error",
    "late-tick",
    "rezero",
    "end",
    "overrun",
];

/// A line that is no JSON, or not what is wanted, with what the parser says of it.
fn unread(line: usize, expected: &str, text: &str, error: &serde_json::Error) -> Damage {
    let mut damage = Damage::of_line(line, expected, text);
    damage.found.push_str(&format!(": {error}"));
    damage
}

/// Reads a schedule; `wires` finds the wires of a bench by its name.
///
/// # Errors
/// The first line that no schedule has there.
pub fn read_schedule(
    text: &str,
    wires: impl FnOnce(&str) -> Vec<WireInfo>,
) -> Result<Trace, Damage> {
    let mut lines = text.lines().enumerate().map(|(n, l)| (n + 1, l));
    let (_, first) = lines.next().unwrap_or((1, ""));
    let header = header(first)?;
    let mut events = Vec::new();
    let mut driven = Driven::default();
    for (number, line) in lines {
        let event = event(number, line, header.period_ns)?;
        if let Event::Schedule(entry) = &event {
            driven.add(entry);
        }
        events.push(event);
    }
    if let Some((index, _)) = (1..events.len())
        .map(|i| (i, (&events[i - 1], &events[i])))
        .find(|(_, (a, b)): &(usize, (&Event, &Event))| a.t_ns() > b.t_ns())
    {
        // The header is line 1, so the event behind index is on line index + 2.
        return Err(Damage::of_line(
            index + 2,
            "records sorted by time",
            "an earlier one",
        ));
    }
    let length_us = events.last().map_or(0, |e: &Event| e.t_ns() / 1000);
    let wires = wires(&header.bench);
    let pre_scale = header.divided(header.pre_scale.unwrap_or_default());
    Ok(Trace {
        header: Header {
            source: Source::named(&header.source).unwrap_or(Source::Emulated),
            scene: header.scene.into_owned(),
            bench: header.bench.into_owned(),
            seed: header.seed,
            scene_digest: header.scene_digest.into_owned(),
            limits_digest: header.limits_digest.into_owned(),
            pre_scale,
            tau_d_us: header.tau_d_us,
            soa_us: header.soa_us,
            person: String::new(),
            preset: String::new(),
            illusion: String::new(),
            kc: 0,
            taxels: Vec::new(),
            wires,
            displays: Vec::new(),
            joints: Vec::new(),
            warmth: false,
            motors: false,
        },
        events,
        ledger: Ledger {
            driven,
            length_us,
            ..Ledger::default()
        },
    })
}

fn header(first: &str) -> Result<HeaderLine<'static>, Damage> {
    const FIRST: &str = "a schedule's header: {\"version\":2,\"seed\":..}";
    let header: HeaderLine<'static> =
        serde_json::from_str(first).map_err(|e| unread(1, FIRST, first, &e))?;
    if ![WITHOUT_PULSES, VERSION].contains(&header.version) {
        let expected = format!("version {VERSION} or {WITHOUT_PULSES}");
        let found = format!("version {}", header.version);
        return Err(Damage::of_line(1, &expected, &found));
    }
    check(&header)?;
    Ok(header)
}

/// The time of a line, counted from one, microseconds; 0 of the header.
///
/// # Errors
/// What was expected in its place, of a line that no schedule has there.
pub fn check_line(number: usize, text: &str) -> Result<u64, Damage> {
    match number {
        1 => header(text).map(|_| 0),
        _ => event(number, text, None).map(|event| event.t_ns() / 1000),
    }
}

/// Pieces of a header from what the first line of a schedule says beside a trace.
///
/// # Errors
/// A line that is no header.
pub(crate) fn header_pieces(text: &str) -> Result<Vec<String>, Damage> {
    let first = text.lines().next().unwrap_or_default();
    let header = header(first)?;
    let clock = match (header.clock_hz, header.clock_ppm) {
        (Some(hz), ppm) => format!("{hz} Hz within {} ppm", ppm.unwrap_or(0)),
        (None, _) => "of the chip".to_owned(),
    };
    let known = serde_json::to_value(&header).unwrap_or_default();
    let all: BTreeMap<String, Value> = serde_json::from_str(first).unwrap_or_default();
    let others = all
        .iter()
        .filter(|(key, _)| known.get(key.as_str()).is_none());
    let others: Vec<String> = others
        .map(|(key, value)| format!("{key} {}", short_digest(&value.to_string())))
        .collect();
    let others = match others.as_slice() {
        [] => "none".to_owned(),
        others => others.join(" "),
    };
    Ok(vec![
        format!("version {}", header.version),
        format!("clock {clock}"),
        format!("other keys {others}"),
    ])
}

/// Longest schedule: that of a recording of a day, and the times that it names.
const LONGEST_US: u64 = 2 * 86_400_000_000;

/// Refuses a header that no chip could have played.
fn check(header: &HeaderLine<'_>) -> Result<(), Damage> {
    let wrong = |expected: &str, found: String| Err(Damage::of_line(1, expected, &found));
    if !header.source.is_empty() && Source::named(&header.source).is_none() {
        let found = format!("source {}", header.source);
        return wrong("a source: emulated, real, observed", found);
    }
    let least = Prescale::MIN.get();
    if let Some(n) = header.pre_scale.filter(|n| *n < least) {
        let expected = format!("a pre_scale from {least} to 255");
        return wrong(&expected, format!("pre_scale {n}"));
    }
    if let Some(hz) = header.clock_hz.filter(|_| header.external().is_none()) {
        let (hz_most, ppm_most) = (Clock::MOST_HZ, Clock::MOST_PPM);
        let expected = format!("a clock_hz from 1 to {hz_most}, a clock_ppm up to {ppm_most}");
        let ppm = header.clock_ppm.unwrap_or(0);
        return wrong(&expected, format!("clock_hz {hz}, clock_ppm {ppm}"));
    }
    if let (Some(period_ns), Some(n)) = (header.period_ns, header.pre_scale) {
        let nominal = header.divided(n).period_ns();
        if period_ns != nominal {
            let expected = format!("period_ns {nominal}, as pre_scale {n} makes it");
            return wrong(&expected, format!("period_ns {period_ns}"));
        }
    }
    if header.period_ns == Some(0) {
        return wrong("a period_ns above 0", "period_ns 0".into());
    }
    for (name, us) in [("tau_d_us", header.tau_d_us), ("soa_us", header.soa_us)] {
        if us > LONGEST_US {
            return wrong(
                &format!("a {name} of at most two days"),
                format!("{name} {us}"),
            );
        }
    }
    Ok(())
}

/// A record of a file whose header states this period, nanoseconds, or none.
fn event(number: usize, text: &str, period_ns: Option<u64>) -> Result<Event, Damage> {
    const RECORD: &str = "a record with t_us and board, and channel, pre_scale or all_off";
    let line: Line = serde_json::from_str(text).map_err(|e| unread(number, RECORD, text, &e))?;
    let times = [Some(line.t_us), line.until_us, line.requested_until_us];
    if times.into_iter().flatten().any(|us| us > LONGEST_US) {
        return Err(Damage::of_line(number, "times of at most two days", text));
    }
    if line.until_us.is_some_and(|us| us < line.t_us) {
        return Err(Damage::of_line(number, "an until_us from t_us on", text));
    }
    if (line.requested_until_us).is_some_and(|us| line.until_us.is_some_and(|cut| us < cut)) {
        let expected = "a requested_until_us from until_us on";
        return Err(Damage::of_line(number, expected, text));
    }
    if line.channel.is_some_and(|channel| channel > 15) {
        return Err(Damage::of_line(number, "a channel from 0 to 15", text));
    }
    if line.pre_scale.is_some_and(|n| n < Prescale::MIN.get()) {
        return Err(Damage::of_line(number, "a pre_scale from 3 to 255", text));
    }
    let Line { t_us, board, .. } = line;
    match line {
        Line {
            pre_scale: Some(pre_scale),
            channel: None,
            ..
        } => Ok(Event::PreScale(event::PreScale {
            t_us,
            board,
            pre_scale,
        })),
        Line {
            all_off: Some(word),
            channel: None,
            ..
        } => match CAUSES.into_iter().find(|c| *c == word) {
            Some(cause) => Ok(Event::AllOff(event::AllOff { t_us, board, cause })),
            None => {
                let expected = format!("a cause: {}", CAUSES.join(", "));
                Err(Damage::of_line(number, &expected, &word))
            }
        },
        line => entry(&line, period_ns, number, text)?
            .map(Event::Schedule)
            .ok_or_else(|| Damage::of_line(number, RECORD, text)),
    }
}

/// Entry of a channel; `None` for a line that is no such record.
fn entry(
    line: &Line,
    period_ns: Option<u64>,
    number: usize,
    text: &str,
) -> Result<Option<Entry>, Damage> {
    let (Some(channel), Some(on), Some(off), Some(until_us), Some(requested)) = (
        line.channel,
        line.on,
        line.off,
        line.until_us,
        line.requested,
    ) else {
        return Ok(None);
    };
    if [on, off, requested].iter().any(|t| *t > Ticks::PER_PERIOD) {
        return Err(Damage::of_line(number, "at most 4096 ticks", text));
    }
    let known = |word: &String| {
        let reason = Reason::ALL.into_iter().find(|r| r.word() == word);
        reason.ok_or_else(|| Damage::of_line(number, "a reason of the guard's", word))
    };
    let entry = Entry {
        at: Instant::from_micros(line.t_us),
        board: Board(line.board),
        channel: Channel(channel),
        on,
        off,
        until: Instant::from_micros(until_us),
        requested: Ticks::new(requested),
        requested_until: Instant::from_micros(line.requested_until_us.unwrap_or(until_us)),
        current: line.current_ma.map(Milliamps),
        reason: line.reason.as_ref().map(known).transpose()?,
    };
    // Pulses and spacing follow from the rest: a line that says otherwise was changed by hand.
    match (line.pulses, line.period) {
        (None, None) => {}
        (Some(_), Some(0)) => {
            return Err(Damage::of_line(number, "a period above 0, ns", text));
        }
        (Some(pulses), Some(period)) => {
            let counted = entry.pulses(period);
            if counted != pulses {
                let expected = format!("pulses {counted}, as t_us, period and until_us make it");
                let found = format!("pulses {pulses}");
                return Err(Damage::of_line(number, &expected, &found));
            }
        }
        _ => {
            let expected = "both pulses and period, or neither";
            return Err(Damage::of_line(number, expected, text));
        }
    }
    let periods = period_ns.zip(line.period);
    if let Some((of_file, own)) = periods.filter(|(of_file, own)| of_file != own) {
        let expected = format!("period {of_file}, as the header says");
        let found = format!("period {own}");
        return Err(Damage::of_line(number, &expected, &found));
    }
    Ok(Some(entry))
}

#[cfg(test)]
#[path = "read_tests.rs"]
mod tests;
