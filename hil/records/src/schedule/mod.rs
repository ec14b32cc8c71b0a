//! The schedule as JSON Lines: a header, then one record per line, integers and words only.

mod read;

pub use read::{check_line, read_schedule};

use crate::trace::{DisplayInfo, Event, Header, Source, Trace, event};
use palpate_core::schedule::Entry;
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Version of the file's meaning; grows when a field changes what it says.
pub const VERSION: u32 = 2;
/// The first one, which is still read: without `pulses` and `period`.
const WITHOUT_PULSES: u32 = 1;

#[derive(Serialize)]
struct HeaderLine<'a> {
    version: u32,
    seed: u64,
    scene_digest: &'a str,
    limits_digest: &'a str,
    scene: &'a str,
    bench: &'a str,
    source: Source,
    #[serde(skip_serializing_if = "Option::is_none")]
    banner: Option<&'static str>,
    pre_scale: u8,
    period_ns: u64,
    /// The clock on EXTCLK; left out for chips on their own oscillators.
    #[serde(skip_serializing_if = "Option::is_none")]
    clock_hz: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    clock_ppm: Option<u32>,
    tau_d_us: u64,
    soa_us: u64,
    /// Left out where there is one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
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
            scene_digest: &header.scene_digest,
            limits_digest: &header.limits_digest,
            scene: &header.scene,
            bench: &header.bench,
            source: header.source,
            banner: header.source.banner(),
            pre_scale: header.pre_scale.get(),
            period_ns: header.pre_scale.period_ns(),
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
        /// Left out where it is `until_us`.
        #[serde(skip_serializing_if = "Option::is_none")]
        requested_until_us: Option<u64>,
        /// Left out where the amplifier has a current of its own.
        #[serde(skip_serializing_if = "Option::is_none")]
        current_ma: Option<u32>,
        reason: Option<&'static str>,
    },
    PreScale {
        t_us: u64,
        board: u8,
        pre_scale: u8,
    },
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
/// Whatever the writer says.
pub fn write_schedule(trace: &Trace, mut out: impl Write) -> io::Result<()> {
    write_header(&trace.header, &mut out)?;
    write_records(&trace.events, trace.header.pre_scale.period_ns(), out)
}

/// Writes the first line.
///
/// # Errors
/// Whatever the writer says.
pub fn write_header(header: &Header, mut out: impl Write) -> io::Result<()> {
    serde_json::to_writer(&mut out, &HeaderLine::new(header))?;
    out.write_all(b"\n")
}

/// Writes the records of events, sorted: of a whole run, or of a piece that holds all events of its instants. All boards of
/// a run have one period.
///
/// # Errors
/// Whatever the writer says.
pub fn write_records(events: &[Event], period_ns: u64, mut out: impl Write) -> io::Result<()> {
    for (_, record) in sorted(events, period_ns) {
        serde_json::to_writer(&mut out, &record)?;
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// Time, board, how many whole-board records came before at that instant, channel.
type Key = (u64, u8, u32, u16);

fn sorted(events: &[Event], period_ns: u64) -> Vec<(Key, Record)> {
    let mut passed: BTreeMap<(u64, u8), u32> = BTreeMap::new();
    let mut whole_board = |t_us: u64, board: u8| {
        let count = passed.entry((t_us, board)).or_default();
        *count += 1;
        (t_us, board, *count, 0)
    };
    let mut barriers: Vec<(usize, Key, Record)> = Vec::new();
    let mut entries: Vec<(usize, &Entry)> = Vec::new();
    for (index, event) in events.iter().enumerate() {
        let (t_us, board, record) = match event {
            Event::Schedule(entry) => {
                entries.push((index, entry));
                continue;
            }
            &Event::PreScale(event::PreScale {
                t_us,
                board,
                pre_scale,
            }) => {
                let record = Record::PreScale {
                    t_us,
                    board,
                    pre_scale,
                };
                (t_us, board, record)
            }
            &Event::AllOff(event::AllOff { t_us, board, cause }) => {
                let record = Record::AllOff {
                    t_us,
                    board,
                    all_off: cause,
                };
                (t_us, board, record)
            }
            _ => continue,
        };
        barriers.push((index, whole_board(t_us, board), record));
    }
    let mut at: BTreeMap<(u64, u8), Vec<usize>> = BTreeMap::new();
    for (index, key, _) in &barriers {
        at.entry((key.0, key.1)).or_default().push(*index);
    }
    let mut records: Vec<(Key, Record)> = Vec::with_capacity(barriers.len() + entries.len());
    for (index, entry) in entries {
        let (t_us, board) = (entry.at.as_micros(), entry.board.0);
        let before = at
            .get(&(t_us, board))
            .map_or(0, |indices| indices.iter().filter(|i| **i < index).count());
        let segment = u32::try_from(before).unwrap_or(u32::MAX);
        // Channel + 1: a whole-board record opens its segment.
        let key = (t_us, board, segment, u16::from(entry.channel.0) + 1);
        records.push((key, Record::entry(entry, period_ns)));
    }
    records.extend(barriers.into_iter().map(|(_, key, record)| (key, record)));
    records.sort_by_key(|(key, _)| *key);
    records
}

#[cfg(test)]
mod tests;
