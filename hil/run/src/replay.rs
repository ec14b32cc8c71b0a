//! Recordings as the sensor end of a run: rows of counts, which enter as readings, or frames of CAN buses.
//!
//! A pass over a recording pulls what comes next. Where it comes from, memory or a file that is read once more, is the
//! caller's: a [`RowSource`] or a [`FrameSource`].

use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

use embedded_can::ErrorKind;
use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::skin::{Layout, Module, ModuleScan, TakeScan};
use palpate_core::units::Instant;
use palpate_files::{FileError, SensorLayout};

use crate::failure::Failure;
use crate::skin_end::{CanEnd, SkinEnd};

/// Recorded rows of one module, as often as they are wanted.
pub trait RowSource: fmt::Debug + Send + Sync {
    /// Counts per row.
    fn columns(&self) -> usize;

    /// Number of rows.
    fn frames(&self) -> usize;

    /// Time from the first row to the last, microseconds.
    fn span_us(&self) -> u64;

    /// Checks every row; sources that cannot hold bad rows need no check.
    ///
    /// # Errors
    /// The expected row, and the one found.
    fn check(&self) -> Result<(), (String, String)> {
        Ok(())
    }

    /// The rows from the first on.
    ///
    /// # Errors
    /// [`Failure::Input`] for a source that cannot be read again.
    fn rows(&self) -> Result<Box<dyn NextRow + '_>, Failure>;

    /// The fault of a row that was pulled; sources that were read before have no such row.
    fn wrong(&self) -> Option<FileError> {
        None
    }
}

/// Rows that are pulled.
pub trait NextRow: Send {
    /// The next row: its counts in place of those in `counts`, and its time in microseconds; none at the end.
    ///
    /// # Errors
    /// [`Failure::Input`] for a source that has changed since it was first read.
    fn next_row(&mut self, counts: &mut Vec<u16>) -> Result<Option<u64>, Failure>;
}

/// Recorded rows of one module, held in memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TaxelTable {
    /// Each row's time in microseconds, not falling.
    pub time_us: Vec<u64>,
    /// Raw counts, row after row, `columns` each: active taxels by index, their axes side by side.
    pub counts: Vec<u16>,
    /// Counts per row.
    pub columns: usize,
}

impl TaxelTable {
    /// Number of rows.
    #[must_use]
    pub fn frames(&self) -> usize {
        self.time_us.len()
    }

    /// The counts of one row.
    #[must_use]
    pub fn frame(&self, index: usize) -> Option<&[u16]> {
        let start = index.checked_mul(self.columns)?;
        self.counts.get(start..start.checked_add(self.columns)?)
    }
}

impl RowSource for TaxelTable {
    fn columns(&self) -> usize {
        self.columns
    }

    fn frames(&self) -> usize {
        Self::frames(self)
    }

    fn span_us(&self) -> u64 {
        let span = self.time_us.last().zip(self.time_us.first());
        span.map_or(0, |(last, first)| last.saturating_sub(*first))
    }

    /// Counts for every row, and times that do not fall.
    fn check(&self) -> Result<(), (String, String)> {
        if self.counts.len() != self.frames().saturating_mul(self.columns) {
            let expected = format!("{} rows of {} counts", self.frames(), self.columns);
            return Err((expected, format!("{} counts", self.counts.len())));
        }
        if let Some(row) = self.time_us.windows(2).position(|t| t[1] < t[0]) {
            let [before, after] = [self.time_us[row], self.time_us[row + 1]];
            let expected = format!("a time from {before} us on in row {}", row + 1);
            return Err((expected, after.to_string()));
        }
        Ok(())
    }

    fn rows(&self) -> Result<Box<dyn NextRow + '_>, Failure> {
        Ok(Box::new(Held {
            table: self,
            next: 0,
        }))
    }
}

/// The rows of a table one after another.
struct Held<'a> {
    table: &'a TaxelTable,
    next: usize,
}

impl NextRow for Held<'_> {
    fn next_row(&mut self, counts: &mut Vec<u16>) -> Result<Option<u64>, Failure> {
        let time = self.table.time_us.get(self.next).copied();
        counts.clear();
        counts.extend_from_slice(self.table.frame(self.next).unwrap_or_default());
        self.next += 1;
        Ok(time)
    }
}

/// A module's share of a row.
struct Share {
    module: u16,
    /// Taxels that the row has readings of.
    read: Box<[usize]>,
    /// Marks the taxels of `read`, by taxel.
    fresh: Box<[bool]>,
    /// The newest readings, by taxel.
    counts: Box<[[u16; 3]]>,
}

impl Share {
    fn new((number, module): (u16, &Module)) -> Self {
        let taxels = 0..module.active().len();
        Self {
            module: number,
            counts: vec![[0; 3]; taxels.len()].into(),
            read: taxels.filter(|&t| module.active()[t]).collect(),
            fresh: module.active().into(),
        }
    }
}

/// Rows of one module, or of several side by side.
struct Source<'a> {
    /// The rows that are left; none after the last one.
    rows: Option<Box<dyn NextRow + 'a>>,
    /// The time from which rows are counted: that of the first row where it is not given.
    first: Option<u64>,
    /// The time at which the next row is due, counted from the first; none while it is not pulled.
    due: Option<u64>,
    row: Vec<u16>,
    modules: Vec<Share>,
}

impl<'a> Source<'a> {
    fn new(
        source: &'a dyn RowSource,
        first: Option<u64>,
        modules: Vec<Share>,
    ) -> Result<Self, Failure> {
        Ok(Self {
            rows: Some(source.rows()?),
            first,
            due: None,
            row: Vec::new(),
            modules,
        })
    }

    /// Time of the next row, which is pulled if it was not; none after the last one.
    fn due(&mut self) -> Result<Option<u64>, Failure> {
        if let (None, Some(rows)) = (self.due, &mut self.rows) {
            match rows.next_row(&mut self.row)? {
                Some(time) => {
                    let first = *self.first.get_or_insert(time);
                    self.due = Some(time.saturating_sub(first));
                }
                None => self.rows = None,
            }
        }
        Ok(self.due)
    }
}

/// A taxel's counts as they stand in a row: three, or the normal one alone.
fn reading(counts: &[u16]) -> [u16; 3] {
    match *counts {
        [x, y, z] => [x, y, z],
        _ => [0, 0, counts.first().copied().unwrap_or(0)],
    }
}

/// Rows as a skin: any layout, with boards or without. A row is pulled when the one before it has been taken.
pub struct Rows<'a> {
    sources: Vec<Source<'a>>,
    /// Axes per taxel, 1 or 3.
    axes: usize,
}

impl fmt::Debug for Rows<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let due = self.sources.iter().map(|source| source.due);
        f.debug_list().entries(due).finish()
    }
}

impl<'a> Rows<'a> {
    /// One recording per module, each from its own first row on.
    ///
    /// # Errors
    /// [`Failure::Input`] for sources that are not of this layout.
    pub fn new(
        sources: &'a [Arc<dyn RowSource>],
        file: &SensorLayout,
        layout: &Layout,
    ) -> Result<Self, Failure> {
        let expected = layout.modules().len();
        if sources.len() != expected {
            return Err(Failure::Input(format!(
                "the recording: expected {expected} tables, one per module of layout `{}`, found {}",
                file.name,
                sources.len()
            )));
        }
        let axes = usize::from(file.axes);
        let recording = |(source, module): (&'a Arc<dyn RowSource>, (u16, &Module))| {
            let share = Share::new(module);
            let columns = share.read.len() * axes;
            let right = match source.columns() {
                found if found == columns => source.check(),
                found => Err((format!("{columns} columns"), found.to_string())),
            };
            right.map_err(|(expected, found)| {
                let what = format!("the recording of module `{}`", module.1.name());
                Failure::Input(format!("{what}: expected {expected}, found {found}"))
            })?;
            let mut own = Source::new(source.as_ref(), None, vec![share])?;
            own.due()?;
            Ok::<_, Failure>(own)
        };
        let modules = (0..).zip(layout.modules());
        let sources = sources.iter().zip(modules).map(recording);
        Ok(Self {
            sources: sources.collect::<Result<_, _>>()?,
            axes,
        })
    }

    /// The readings of all of a layout's modules as they come, one module after another in every row. The run's time waits
    /// for each row.
    ///
    /// # Errors
    /// [`Failure::Input`] for rows of another length.
    pub fn streamed(
        source: &'a dyn RowSource,
        file: &SensorLayout,
        layout: &Layout,
    ) -> Result<Self, Failure> {
        let axes = usize::from(file.axes);
        let modules: Vec<Share> = (0..).zip(layout.modules()).map(Share::new).collect();
        let columns = axes * modules.iter().map(|m| m.read.len()).sum::<usize>();
        if source.columns() != columns {
            return Err(Failure::Input(format!(
                "the stream: expected rows of {columns} counts, found {}",
                source.columns()
            )));
        }
        Ok(Self {
            sources: vec![Source::new(source, Some(0), modules)?],
            axes,
        })
    }
}

impl SkinEnd for Rows<'_> {
    fn scans(&mut self, now: Instant, take: &mut TakeScan<'_>) -> Result<(), Failure> {
        loop {
            let mut next: Option<(u64, usize)> = None;
            for (index, source) in self.sources.iter_mut().enumerate() {
                let due = source.due()?.map(|time| (time, index));
                next = next.into_iter().chain(due).min();
            }
            let Some((time, index)) = next.filter(|(time, _)| *time <= now.as_micros()) else {
                return Ok(());
            };
            let source = &mut self.sources[index];
            source.due = None;
            let mut readings = source.row.chunks_exact(self.axes);
            for share in &mut source.modules {
                for (taxel, counts) in share.read.iter().zip(&mut readings) {
                    share.counts[*taxel] = reading(counts);
                }
                take(&ModuleScan {
                    module: share.module,
                    at: Instant::from_micros(time),
                    counts: &share.counts,
                    fresh: Some(&share.fresh),
                });
            }
        }
    }

    fn advance_to(&mut self, _now: Instant) {}
}

/// Recorded frames of all sensor buses, as often as they are wanted.
pub trait FrameSource: fmt::Debug + Send + Sync {
    /// Frames of the identifier that came most often.
    fn rows(&self) -> usize;

    /// Time of the last frame.
    fn end(&self) -> Instant;

    /// The frames from the first on, the oldest first.
    ///
    /// # Errors
    /// [`Failure::Input`] for a source that cannot be read again.
    fn frames(&self) -> Result<Frames<'_>, Failure>;
}

/// Frames that are pulled; an error where their source has changed since it was first read.
pub type Frames<'a> = Box<dyn Iterator<Item = Result<Received, Failure>> + Send + 'a>;

/// Count of each identifier on each bus.
#[derive(Clone, Debug, Default)]
pub struct Identifiers(BTreeMap<(u8, u16), usize>);

impl Identifiers {
    /// Counts a frame.
    pub fn add(&mut self, received: &Received) {
        let key = (received.bus, received.frame.id());
        *self.0.entry(key).or_insert(0) += 1;
    }

    /// Frames of the identifier that came most often.
    #[must_use]
    pub fn most(&self) -> usize {
        self.0.values().copied().max().unwrap_or(0)
    }
}

/// Recorded frames, held in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CanFrames(Arc<[Received]>);

impl CanFrames {
    /// Frames in any order; those of one time keep theirs.
    pub fn new(mut frames: Vec<Received>) -> Self {
        frames.sort_by_key(|r| r.at);
        Self(frames.into())
    }
}

impl FrameSource for CanFrames {
    fn rows(&self) -> usize {
        let mut identifiers = Identifiers::default();
        self.0.iter().for_each(|received| identifiers.add(received));
        identifiers.most()
    }

    fn end(&self) -> Instant {
        self.0.last().map_or(Instant::ZERO, |r| r.at)
    }

    fn frames(&self) -> Result<Frames<'_>, Failure> {
        Ok(Box::new(self.0.iter().copied().map(Ok)))
    }
}

/// A bus that plays recorded frames, and takes no commands.
pub struct CanPlayer<'a> {
    frames: Frames<'a>,
    next: Option<Result<Received, Failure>>,
    now: Instant,
}

impl<'a> CanPlayer<'a> {
    /// A bus that plays frames, the oldest first.
    #[must_use]
    pub fn new(mut frames: Frames<'a>) -> Self {
        Self {
            next: frames.next(),
            frames,
            now: Instant::ZERO,
        }
    }
}

impl fmt::Debug for CanPlayer<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CanPlayer")
            .field("now", &self.now)
            .finish_non_exhaustive()
    }
}

/// A recording that could not be read again.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct Unplayed(Failure);

impl embedded_can::Error for Unplayed {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl CanBus for CanPlayer<'_> {
    type Error = Unplayed;

    fn receive(&mut self) -> Result<Option<Received>, Unplayed> {
        let due = |next: &mut Result<Received, Failure>| match next {
            Ok(received) => received.at <= self.now,
            Err(_) => true,
        };
        let Some(received) = self.next.take_if(due) else {
            return Ok(None);
        };
        self.next = self.frames.next();
        received.map(Some).map_err(Unplayed)
    }

    fn transmit(&mut self, _bus: u8, _frame: &CanFrame) -> Result<(), Unplayed> {
        Ok(())
    }
}

impl CanEnd for CanPlayer<'_> {
    fn advance_to(&mut self, now: Instant) {
        self.now = self.now.max(now);
    }
}
