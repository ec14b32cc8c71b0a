//! A schedule file (JSON Lines) read back into a trace.

use palpate_core::schedule::{Entry, Reason};
use palpate_core::units::{Board, Channel, Instant, Prescale, Ticks};
use serde::Deserialize;

use super::story::Damage;
use crate::schedule::VERSION;
use crate::trace::{Event, Header, Ledger, Limits, Source, Trace, WireInfo};

#[derive(Deserialize)]
struct HeaderLine {
    version: u32,
    seed: u64,
    scene_digest: String,
    limits_digest: String,
    #[serde(default)]
    scene: String,
    #[serde(default)]
    bench: String,
    #[serde(default)]
    source: String,
    #[serde(default)]
    pre_scale: Option<u8>,
    #[serde(default)]
    tau_d_us: u64,
    #[serde(default)]
    soa_us: u64,
}

#[derive(Deserialize)]
struct Line {
    t_us: u64,
    board: u8,
    channel: Option<u8>,
    on: Option<u16>,
    off: Option<u16>,
    until_us: Option<u64>,
    requested: Option<u16>,
    #[serde(default)]
    reason: Option<String>,
    pre_scale: Option<u8>,
    all_off: Option<String>,
}

/// Every cause that is written into a schedule.
const CAUSES: [&str; 6] = [
    "start",
    "stale-input",
    "actuator-error",
    "sensor-error",
    "late-tick",
    "end",
];

fn damage(line: usize, expected: &str, found: impl Into<String>) -> Damage {
    Damage {
        line,
        expected: expected.to_owned(),
        found: found.into(),
    }
}

/// What a damaged line is shown as.
fn shown(text: &str) -> String {
    if text.is_empty() {
        return "an empty line".to_owned();
    }
    let cut: String = text.chars().take(60).collect();
    let dots = if cut.len() < text.len() { ".." } else { "" };
    format!("`{}{dots}`", cut.escape_default())
}

/// Reads a schedule; `wires` finds the wires of a bench by its name.
///
/// # Errors
/// The first line that no schedule has there.
pub fn read_schedule(
    text: &str,
    wires: impl FnOnce(&str) -> Vec<WireInfo>,
) -> Result<Trace, Damage> {
    const FIRST: &str = "a schedule's header: {\"version\":1,\"seed\":..}";
    let mut lines = text.lines().enumerate().map(|(n, l)| (n + 1, l));
    let (_, first) = lines.next().ok_or_else(|| damage(1, FIRST, "nothing"))?;
    let header: HeaderLine = serde_json::from_str(first)
        .map_err(|e| damage(1, FIRST, format!("{}: {e}", shown(first))))?;
    if header.version != VERSION {
        let expected = format!("version {VERSION}");
        return Err(damage(1, &expected, format!("version {}", header.version)));
    }
    let mut events = Vec::new();
    for (number, line) in lines {
        events.push(event(number, line)?);
    }
    if let Some((index, _)) = (1..events.len())
        .map(|i| (i, (&events[i - 1], &events[i])))
        .find(|(_, (a, b)): &(usize, (&Event, &Event))| a.t_ns() > b.t_ns())
    {
        // The header is line 1, so the event behind index is on line index + 2.
        return Err(damage(
            index + 2,
            "records sorted by time",
            "an earlier one",
        ));
    }
    let length_us = events.last().map_or(0, |e: &Event| e.t_ns() / 1000);
    let wires = wires(&header.bench);
    Ok(Trace {
        header: Header {
            source: match header.source.as_str() {
                "real" => Source::Real,
                _ => Source::Emulated,
            },
            scene: header.scene,
            bench: header.bench,
            seed: header.seed,
            scene_digest: header.scene_digest,
            limits_digest: header.limits_digest,
            limits: Limits::default(),
            pre_scale: Prescale::new(header.pre_scale.unwrap_or_default()),
            tau_d_us: header.tau_d_us,
            soa_us: header.soa_us,
            illusion: String::new(),
            kc: 0,
            taxels: Vec::new(),
            wires,
        },
        events,
        ledger: Ledger {
            length_us,
            ..Ledger::default()
        },
    })
}

fn event(number: usize, text: &str) -> Result<Event, Damage> {
    const RECORD: &str = "a record with t_us and board, and channel, pre_scale or all_off";
    let line: Line = serde_json::from_str(text)
        .map_err(|e| damage(number, RECORD, format!("{}: {e}", shown(text))))?;
    let Line { t_us, board, .. } = line;
    match line {
        Line {
            channel: Some(channel),
            on: Some(on),
            off: Some(off),
            until_us: Some(until_us),
            requested: Some(requested),
            reason,
            ..
        } => {
            if on > Ticks::PER_PERIOD || off > Ticks::PER_PERIOD || requested > Ticks::PER_PERIOD {
                return Err(damage(number, "at most 4096 ticks", shown(text)));
            }
            let known = |word: &String| Reason::ALL.into_iter().find(|r| r.word() == word);
            let reason = match &reason {
                None => None,
                Some(word) => Some(
                    known(word)
                        .ok_or_else(|| damage(number, "a reason of the guard's", shown(word)))?,
                ),
            };
            Ok(Event::Schedule(Entry {
                at: Instant::from_micros(t_us),
                board: Board(board),
                channel: Channel(channel),
                on,
                off,
                until: Instant::from_micros(until_us),
                requested: Ticks::new(requested),
                reason,
            }))
        }
        Line {
            pre_scale: Some(pre_scale),
            ..
        } => Ok(Event::PreScale {
            t_us,
            board,
            pre_scale,
        }),
        Line {
            all_off: Some(word),
            ..
        } => match CAUSES.into_iter().find(|c| *c == word) {
            Some(cause) => Ok(Event::AllOff { t_us, board, cause }),
            None => {
                let expected = format!("a cause: {}", CAUSES.join(", "));
                Err(damage(number, &expected, shown(&word)))
            }
        },
        _ => Err(damage(number, RECORD, shown(text))),
    }
}
