//! `palpate-link merge`: recordings of the two ends in one, on the robot's clock, with the offset and its bounds stated.

use std::collections::BTreeMap;
use std::path::Path;

use mcap::MessageStream;
use palpate_live::output::{print, print_json};
use palpate_records::mcap::proto::{Fields, Value};
use palpate_run::Failure;
use serde::Serialize;

use super::pairs;
use super::record::Recording;
use crate::cli::MergeArgs;
use crate::records::OFFSET_WORDS;

/// Counts and clock of a merge.
#[derive(Debug, Serialize)]
struct Merged {
    /// Messages of the robot's recording.
    robot: u64,
    /// Messages of the wearer's.
    wearer: u64,
    /// Offset that was taken off the wearer's times at the end, microseconds, and its largest error at any time.
    offset_us: i64,
    uncertainty_us: i64,
    /// Frames that both recordings have, of those that the robot sent.
    frames_felt: u64,
    frames_sent: u64,
    /// The wearer's frames with contacts that are the same as one of the robot's, where they were compared.
    frames_same: Option<u64>,
    /// Largest distance in time between the two recordings' readings of one frame, microseconds.
    reading_us: Option<i64>,
}

/// A message that is to be written.
struct Line {
    t_ns: u64,
    topic: String,
    schema: (String, Vec<u8>),
    data: Vec<u8>,
}

fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path).map_err(|e| Failure::Input(format!("{}: {e}", path.display())))
}

fn lines(path: &Path, bytes: &[u8], prefix: &str) -> Result<Vec<Line>, Failure> {
    let name = path.display();
    let damaged =
        |e: mcap::McapError| Failure::Input(format!("{name}: expected a recording (MCAP): {e}"));
    let mut all = Vec::new();
    for message in MessageStream::new(bytes).map_err(damaged)? {
        let message = message.map_err(damaged)?;
        let Some(schema) = &message.channel.schema else {
            continue;
        };
        all.push(Line {
            t_ns: message.log_time,
            topic: format!("{prefix}{}", message.channel.topic),
            schema: (schema.name.clone(), schema.data.to_vec()),
            data: message.data.to_vec(),
        });
    }
    Ok(all)
}

/// The text of a line of a log.
fn text(data: &[u8]) -> Option<String> {
    let mut fields = Fields::new(data).flatten();
    fields.find_map(|field| match field {
        (3, Value::Data(text)) => String::from_utf8(text.to_vec()).ok(),
        _ => None,
    })
}

/// Bounds of a wearer's clock, ours minus theirs, microseconds, with the time of the statement, nanoseconds of its own.
#[derive(Clone, Copy, Debug)]
struct Offset {
    t_ns: u64,
    low: i64,
    high: i64,
}

impl Offset {
    fn read(line: &Line) -> Option<Self> {
        let text = text(&line.data)?;
        let (low, high) = text.strip_prefix(OFFSET_WORDS)?.split_once(" to ")?;
        Some(Self {
            t_ns: line.t_ns,
            low: low.trim().parse().ok()?,
            high: high.trim_end_matches(" us").parse().ok()?,
        })
    }

    const fn middle(self) -> i64 {
        self.low.midpoint(self.high)
    }

    const fn half(self) -> i64 {
        (self.high - self.low).div_euclid(2)
    }
}

/// All statements of a wearer's recording about its clock. One that was set is stated anew.
fn offsets(lines: &[Line]) -> Vec<Offset> {
    let notes = lines.iter().filter(|l| l.topic.ends_with("/events"));
    notes.filter_map(Offset::read).collect()
}

/// A time of the wearer's on the robot's clock, nanoseconds, by the newest bounds stated until then; before any, by the
/// first.
fn on_robot(t_ns: u64, offsets: &[Offset]) -> i64 {
    let at = offsets.partition_point(|offset| offset.t_ns <= t_ns);
    let offset = offsets.get(at.saturating_sub(1));
    let middle_ns = offset.map_or(0, |offset| offset.middle().saturating_mul(1000));
    i64::try_from(t_ns)
        .unwrap_or(i64::MAX)
        .saturating_sub(middle_ns)
}

/// Contacts of a recording.
fn contacts(lines: &[Line]) -> Vec<pairs::Frame> {
    let contacts = lines.iter().filter(|l| l.topic.ends_with("/contacts"));
    pairs::frames(contacts.map(|l| (l.t_ns / 1000, &*l.data)))
}

/// Times of the frames of a recording, ns.
fn frames<'a>(lines: &'a [Line]) -> impl Iterator<Item = u64> + 'a {
    let frames = lines.iter().filter(|l| l.topic.ends_with("/frames"));
    frames.map(|l| l.t_ns)
}

/// Writes the contacts of both side by side, where that is wanted. Returns the number of the wearer's frames that are
/// one of the robot's.
fn compared(
    args: &MergeArgs,
    all: &[Line],
    worn: &[Line],
    within_us: u64,
) -> Result<Option<u64>, Failure> {
    let Some(folder) = &args.contacts else {
        return Ok(None);
    };
    let (robot, worn) = (contacts(all), contacts(worn));
    let (worn, same) = pairs::paired(&robot, &worn, within_us);
    pairs::write(folder, "robot.csv", &robot, args.force)?;
    pairs::write(folder, "wearer.csv", &worn, args.force)?;
    Ok(Some(same as u64))
}

/// Runs it.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &MergeArgs) -> Result<(), Failure> {
    let (robot, wearer) = (read(&args.robot)?, read(&args.wearer)?);
    let mut all = lines(&args.robot, &robot, "/robot")?;
    let mut worn = lines(&args.wearer, &wearer, "/wearer")?;
    let offsets = offsets(&worn);
    let newest = *offsets.last().ok_or_else(|| {
        Failure::Input(format!(
            "{}: expected a recording of `palpate-link display` that has felt something: its events state the clock's offset",
            args.wearer.display()
        ))
    })?;
    let middle = newest.middle();
    let half = offsets
        .iter()
        .map(|offset| offset.half())
        .max()
        .unwrap_or(0);
    let before = worn.len();
    worn.retain_mut(|line| {
        let t_ns = on_robot(line.t_ns, &offsets);
        line.t_ns = u64::try_from(t_ns).unwrap_or(0);
        t_ns >= 0
    });
    let left_out = before - worn.len();
    let (sent, felt): (Vec<u64>, Vec<u64>) = (frames(&all).collect(), frames(&worn).collect());
    let nearest = |t: u64| {
        let at = sent.partition_point(|s| *s < t);
        let near = sent.iter().skip(at.saturating_sub(1)).take(2);
        near.map(|s| (*s as i64 - t as i64) / 1000)
            .min_by_key(|d| d.abs())
    };
    let reading_us = felt.iter().filter_map(|t| nearest(*t)).map(i64::abs).max();
    worn.sort_by_key(|line| line.t_ns);
    let frames_same = compared(args, &all, &worn, half.unsigned_abs())?;
    let merged = Merged {
        frames_same,
        robot: all.len() as u64,
        wearer: worn.len() as u64,
        offset_us: middle,
        uncertainty_us: half,
        frames_felt: felt.len() as u64,
        frames_sent: sent.len() as u64,
        reading_us,
    };
    all.append(&mut worn);
    all.sort_by_key(|line| line.t_ns);
    let facts = BTreeMap::from([
        ("clock".to_owned(), "the robot's".to_owned()),
        ("robot".to_owned(), args.robot.display().to_string()),
        ("wearer".to_owned(), args.wearer.display().to_string()),
        ("wearer_offset_us".to_owned(), middle.to_string()),
        ("wearer_uncertainty_us".to_owned(), half.to_string()),
    ]);
    let mut recording = Recording::begin(&args.out, args.force, facts)?;
    for line in &all {
        let schema = (&*line.schema.0, &*line.schema.1);
        recording.message(&line.topic, schema, line.t_ns, &line.data)?;
    }
    recording.finish()?;
    tell(args, &merged, left_out)
}

/// Writes the report of the merge.
fn tell(args: &MergeArgs, merged: &Merged, left_out: usize) -> Result<(), Failure> {
    let (middle, half) = (merged.offset_us, merged.uncertainty_us);
    if args.json {
        return print_json(merged);
    }
    print(|out| {
        writeln!(
            out,
            "{}: {} messages of the robot, {} of the wearer, whose clock was {middle} us ahead, within {half} us",
            args.out.display(),
            merged.robot,
            merged.wearer
        )?;
        if left_out > 0 {
            writeln!(
                out,
                "  {left_out} messages of the wearer from before the robot's start are left out"
            )?;
        }
        writeln!(
            out,
            "  {} of {} frames reached the wearer",
            merged.frames_felt, merged.frames_sent
        )
    })
}
