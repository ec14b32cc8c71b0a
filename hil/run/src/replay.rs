//! Recordings as the sensor end of a run: rows of counts, which enter as readings, or frames of CAN buses.

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::fmt;
use std::sync::Arc;

use embedded_can::ErrorKind;
use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::skin::{Layout, ModuleScan, SkinSource};
use palpate_core::units::Instant;
use palpate_files::SensorLayout;

use crate::failure::Failure;
use crate::skin_end::{CanEnd, SkinEnd};

/// Recorded rows of one module.
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

    /// Refuses a table that does not hold `columns` counts per row, or whose time goes back.
    fn check(&self, module: &str, columns: usize) -> Result<(), Failure> {
        let refuse = |expected: String, found: String| {
            let what = format!("the recording of module `{module}`");
            Err(Failure::Input(format!(
                "{what}: expected {expected}, found {found}"
            )))
        };
        if self.columns != columns {
            return refuse(format!("{columns} columns"), self.columns.to_string());
        }
        if self.counts.len() != self.frames().saturating_mul(columns) {
            let expected = format!("{} rows of {columns} counts", self.frames());
            return refuse(expected, format!("{} counts", self.counts.len()));
        }
        if let Some(row) = self.time_us.windows(2).position(|t| t[1] < t[0]) {
            let [before, after] = [self.time_us[row], self.time_us[row + 1]];
            return refuse(
                format!("a time from {before} us on in row {}", row + 1),
                after.to_string(),
            );
        }
        Ok(())
    }

    /// The counts of one row.
    #[must_use]
    pub fn frame(&self, index: usize) -> Option<&[u16]> {
        let start = index.checked_mul(self.columns)?;
        self.counts.get(start..start.checked_add(self.columns)?)
    }
}

/// A module of a recording.
#[derive(Clone, Debug)]
struct Module<'a> {
    table: &'a TaxelTable,
    /// Axes per taxel, 1 or 3.
    axes: usize,
    /// Taxels that the columns are of.
    active: Box<[usize]>,
    /// Which taxels those are.
    fresh: Box<[bool]>,
    /// The newest row, by taxel.
    counts: Box<[[u16; 3]]>,
    next: usize,
}

impl Module<'_> {
    /// When the next row comes, counted from the first.
    fn due(&self) -> Option<u64> {
        let first = self.table.time_us.first()?;
        let time = self.table.time_us.get(self.next)?;
        Some(time.saturating_sub(*first))
    }

    /// Takes the next row.
    fn load(&mut self) {
        let Some(row) = self.table.frame(self.next) else {
            return;
        };
        for (taxel, counts) in self.active.iter().zip(row.chunks_exact(self.axes)) {
            self.counts[*taxel] = match *counts {
                [x, y, z] => [x, y, z],
                _ => [0, 0, counts[0]],
            };
        }
        self.next += 1;
    }
}

/// Recorded rows as a skin: any layout, with boards or without.
#[derive(Clone, Debug)]
pub struct Rows<'a> {
    modules: Vec<Module<'a>>,
}

impl<'a> Rows<'a> {
    /// One table per module, each from its own first row on.
    ///
    /// # Errors
    /// [`Failure::Input`] for tables that are not of this layout.
    pub fn new(
        tables: &'a [TaxelTable],
        file: &SensorLayout,
        layout: &Layout,
    ) -> Result<Self, Failure> {
        let expected = layout.modules().len();
        if tables.len() != expected {
            return Err(Failure::Input(format!(
                "the recording: expected {expected} tables, one per module of layout `{}`, found {}",
                file.name,
                tables.len()
            )));
        }
        let axes = usize::from(file.axes);
        let module = |(table, module): (&'a TaxelTable, &palpate_core::skin::Module)| {
            let taxels = module.active().len();
            let active: Box<[usize]> = (0..taxels).filter(|&i| module.active()[i]).collect();
            table.check(module.name(), active.len() * axes)?;
            Ok::<_, Failure>(Module {
                table,
                axes,
                fresh: module.active().into(),
                counts: vec![[0; 3]; taxels].into(),
                active,
                next: 0,
            })
        };
        let modules = tables.iter().zip(layout.modules()).map(module);
        Ok(Self {
            modules: modules.collect::<Result<_, _>>()?,
        })
    }

    /// When the last row comes.
    pub fn end(&self) -> Instant {
        // Checked: times do not fall.
        let last = |m: &Module<'_>| Some(m.table.time_us.last()? - m.table.time_us.first()?);
        let last = self.modules.iter().filter_map(last).max();
        Instant::from_micros(last.unwrap_or(0))
    }
}

impl SkinSource for Rows<'_> {
    type Error = Infallible;

    fn scans(
        &mut self,
        now: Instant,
        take: &mut impl FnMut(&ModuleScan<'_>),
    ) -> Result<(), Infallible> {
        loop {
            let due = self.modules.iter().enumerate();
            let due = due.filter_map(|(index, m)| Some((m.due()?, index)));
            let Some((time, index)) = due.min().filter(|(t, _)| *t <= now.as_micros()) else {
                return Ok(());
            };
            let module = &mut self.modules[index];
            module.load();
            take(&ModuleScan {
                module: index as u16, // a layout has at most 4096
                at: Instant::from_micros(time),
                counts: &module.counts,
                fresh: Some(&module.fresh),
            });
        }
    }
}

impl SkinEnd for Rows<'_> {
    fn advance_to(&mut self, _now: Instant) {}
}

/// Recorded frames of all sensor buses, the oldest first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CanFrames(Arc<[Received]>);

impl CanFrames {
    /// Frames in any order; those of one time keep theirs.
    pub fn new(mut frames: Vec<Received>) -> Self {
        frames.sort_by_key(|r| r.at);
        Self(frames.into())
    }

    /// Frames of the identifier that came most often.
    pub fn rows(&self) -> usize {
        let mut rows = BTreeMap::new();
        for received in &*self.0 {
            *rows.entry((received.bus, received.frame.id())).or_insert(0) += 1;
        }
        rows.into_values().max().unwrap_or(0)
    }

    /// When the last one comes.
    pub fn end(&self) -> Instant {
        self.0.last().map_or(Instant::ZERO, |r| r.at)
    }

    /// A bus that plays them.
    pub fn player(&self) -> CanPlayer {
        CanPlayer {
            frames: self.clone(),
            next: 0,
            now: Instant::ZERO,
        }
    }
}

/// A bus that plays recorded frames, and takes no commands.
#[derive(Clone, Debug)]
pub struct CanPlayer {
    frames: CanFrames,
    next: usize,
    now: Instant,
}

/// A recording has no bus that could fail.
#[derive(Debug)]
pub struct NoError(Infallible);

impl fmt::Display for NoError {
    fn fmt(&self, _: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {}
    }
}

impl embedded_can::Error for NoError {
    fn kind(&self) -> ErrorKind {
        match self.0 {}
    }
}

impl CanBus for CanPlayer {
    type Error = NoError;

    fn receive(&mut self) -> Result<Option<Received>, NoError> {
        let due = self.frames.0.get(self.next).filter(|r| r.at <= self.now);
        self.next += usize::from(due.is_some());
        Ok(due.copied())
    }

    fn transmit(&mut self, _bus: u8, _frame: &CanFrame) -> Result<(), NoError> {
        Ok(())
    }
}

impl CanEnd for CanPlayer {
    fn advance_to(&mut self, now: Instant) {
        self.now = self.now.max(now);
    }
}
