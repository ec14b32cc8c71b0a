//! The schedule as JSON Lines: a header, then one record per line, integers and words only.

mod read;

pub(crate) use read::header_pieces;
pub use read::{check_line, read_schedule};

use crate::trace::{DisplayInfo, Event, Header, Trace, event};
use palpate_core::schedule::Entry;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Version of the file's meaning; grows when a field changes what it says.
pub const VERSION: u32 = 2;
/// The first one, which is still read: without `pulses` and `period`.
const WITHOUT_PULSES: u32 = 1;

/// The first line. A reader takes what every version has, and what a later one added where it is there.
#[derive(Serialize, Deserialize)]
struct HeaderLine<'a> {
    version: u32,
    seed: u64,
    scene_digest: Cow<'a, str>,
    limits_digest: Cow<'a, str>,
    #[serde(default)]
    scene: Cow<'a, str>,
    #[serde(default)]
    bench: Cow<'a, str>,
    #[serde(default)]
    source: Cow<'a, str>,
    #[serde(skip_deserializing, skip_serializing_if = "Option::is_none")]
    banner: Option<&'static str>,
    pre_scale: Option<u8>,
    period_ns: Option<u64>,
    /// The clock on EXTCLK; left out for chips on their own oscillators.
    #[serde(skip_serializing_if = "Option::is_none")]
    clock_hz: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    clock_ppm: Option<u32>,
    #[serde(default)]
    tau_d_us: u64,
    #[serde(default)]
    soa_us: u64,
    /// Displays of the run; left out where there is one.
    #[serde(skip_deserializing, skip_serializing_if = "Vec::is_empty")]
    displays: Vec<DisplayLine<'a>>,
}

/// One of several displays: which board and channel drives each of its wires.
#[derive(Serialize)]
struct DisplayLine<'a> {
    #[serde(flatten)]
    display: &'a DisplayInfo,
    outputs: Vec<(u8, u8)>,
}

impl<'a> DisplayLine<'a> {
    fn all(header: &'a Header) -> Vec<Self> {
        let mut wires = header.wires.iter().map(|w| (w.board, w.channel));
        let line = |display: &'a DisplayInfo| Self {
            display,
            outputs: wires.by_ref().take(display.wires).collect(),
        };
        header.displays.iter().map(line).collect()
    }
}

impl<'a> HeaderLine<'a> {
    fn new(header: &'a Header) -> Self {
        let clock = header.pre_scale.clock();
        Self {
            version: VERSION,
            seed: header.seed,
            scene_digest: (&header.scene_digest).into(),
            limits_digest: (&header.limits_digest).into(),
            scene: (&header.scene).into(),
            bench: (&header.bench).into(),
            source: header.source.word().into(),
            banner: header.source.banner(),
            pre_scale: Some(header.pre_scale.get()),
            period_ns: Some(header.pre_scale.period_ns()),
            clock_hz: clock.tolerance_ppm().map(|_| clock.hz()),
            clock_ppm: clock.tolerance_ppm(),
            tau_d_us: header.tau_d_us,
            soa_us: header.soa_us,
            displays: DisplayLine::all(header),
        }
    }
}

#[derive(Serialize)]
#[serde(untagged)]
enum Record {
    Entry {
        t_us: u64,
        board: u8,
        channel: u8,
        pulses: u64,
        on: u16,
        off: u16,
        period: u64,
        until_us: u64,
        requested: u16,
        /// Requested end, microseconds; left out where it is `until_us`.
        #[serde(skip_serializing_if = "Option::is_none")]
        requested_until_us: Option<u64>,
        /// Current, mA; left out where the amplifier has a current of its own.
        #[serde(skip_serializing_if = "Option::is_none")]
        current_ma: Option<u32>,
        reason: Option<&'static str>,
    },
    PreScale(event::PreScale),
    AllOff {
        t_us: u64,
        board: u8,
        all_off: &'static str,
    },
}

impl Record {
    fn entry(entry: &Entry, period_ns: u64) -> Self {
        Self::Entry {
            t_us: entry.at.as_micros(),
            board: entry.board.0,
            channel: entry.channel.0,
            pulses: entry.pulses(period_ns),
            on: entry.on,
            off: entry.off,
            period: period_ns,
            until_us: entry.until.as_micros(),
            requested: entry.requested.get(),
            requested_until_us: (entry.requested_until != entry.until)
                .then_some(entry.requested_until.as_micros()),
            current_ma: entry.current.map(|current| current.0),
            reason: entry.reason.map(|r| r.word()),
        }
    }
}

/// Writes the schedule: header, then records sorted by time, board and channel.
///
/// A record that concerns a whole board keeps its place among the entries of the same board and
/// instant (off-then-on and on-then-off end differently); only entries between two such are sorted.
///
/// # Errors
/// The writer's error.
pub fn write_schedule(trace: &Trace, out: &mut dyn Write) -> io::Result<()> {
    write_header(&trace.header, out)?;
    write_records(&trace.events, trace.header.pre_scale.period_ns(), out)
}

/// Writes the first line.
///
/// # Errors
/// The writer's error.
pub fn write_header(header: &Header, out: &mut dyn Write) -> io::Result<()> {
    serde_json::to_writer(&mut *out, &HeaderLine::new(header))?;
    out.write_all(b"\n")
}

/// Writes the records of events, sorted: of a whole run, or of a piece that holds all events of its instants. All boards of
/// a run have one period.
///
/// # Errors
/// The writer's error.
pub fn write_records(events: &[Event], period_ns: u64, out: &mut dyn Write) -> io::Result<()> {
    for (_, record) in sorted(events, period_ns) {
        serde_json::to_writer(&mut *out, &record)?;
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// Time, board, how many whole-board records have come at that instant, one more than the channel or 0 for a whole board.
type Key = (u64, u8, u32, u16);

fn sorted(events: &[Event], period_ns: u64) -> Vec<(Key, Record)> {
    let mut segments: BTreeMap<(u64, u8), u32> = BTreeMap::new();
    let mut records: Vec<(Key, Record)> = Vec::new();
    for event in events {
        // A whole-board record opens its segment.
        let (t_us, board, place, record) = match event {
            Event::Schedule(entry) => {
                let place = u16::from(entry.channel.0) + 1;
                let record = Record::entry(entry, period_ns);
                (entry.at.as_micros(), entry.board.0, place, record)
            }
            &Event::PreScale(set) => (set.t_us, set.board, 0, Record::PreScale(set)),
            &Event::AllOff(event::AllOff { t_us, board, cause }) => {
                let all_off = cause;
                let record = Record::AllOff {
                    t_us,
                    board,
                    all_off,
                };
                (t_us, board, 0, record)
            }
            _ => continue,
        };
        let segment = segments.entry((t_us, board)).or_default();
        *segment += u32::from(place == 0);
        records.push(((t_us, board, *segment, place), record));
    }
    records.sort_by_key(|(key, _)| *key);
    records
}

#[cfg(test)]
mod tests;
