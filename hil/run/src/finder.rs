//! Contacts of rows, and nothing else: (4.1) to (4.10), row by row, without a display.

use palpate_core::contact::{Compressor, Contact, Settings};
use palpate_core::skin::{
    Baseline, BaselinePhase, BaselineSettings, FrameError, Layout, Module, RelativeFrame, Scan,
};
use palpate_core::units::Instant;
use palpate_files::Columns;

use crate::failure::Failure;

/// Settings of a search for contacts.
#[derive(Clone, Debug)]
pub struct Search {
    /// Baseline that is subtracted from rows.
    pub baseline: BaselineSettings,
    /// Thresholds and compression that make contacts of a row.
    pub compression: Settings,
    /// `true` to leave out rows that repeat the one before.
    pub skips_repeats: bool,
}

/// Finds the contacts of one row after another.
#[derive(Debug)]
pub struct Finder {
    layout: Layout,
    /// Active taxels of all modules, module after module: those that the columns name.
    active: Vec<usize>,
    columns: Columns,
    reference_frames: usize,
    skips_repeats: bool,
    baseline: Baseline,
    compressor: Compressor,
    counts: Vec<[u16; 3]>,
    scan: Scan,
    relative: Option<RelativeFrame>,
    before: Vec<u16>,
    rows: usize,
}

impl Finder {
    /// A search for contacts in rows of these columns of a skin.
    ///
    /// # Errors
    /// [`Failure::Input`] for settings that cannot be, by the options of `hil contacts`.
    pub fn new(layout: &Layout, columns: &Columns, search: Search) -> Result<Self, Failure> {
        let option =
            |name: &str, e: &dyn std::fmt::Display| Failure::Input(format!("--{name}: {e}"));
        let modules = layout.modules().iter().enumerate();
        let of_module = |(m, module): (usize, &Module)| {
            let start = layout.range(m).start;
            let active = (0..module.points().len()).filter(|&i| module.active()[i]);
            active.map(|i| start + i).collect::<Vec<_>>()
        };
        Ok(Self {
            active: modules.flat_map(of_module).collect(),
            columns: columns.clone(),
            reference_frames: search.baseline.reference_frames as usize,
            skips_repeats: search.skips_repeats,
            baseline: Baseline::new(layout, search.baseline)
                .map_err(|e| option("reference-frames", &e))?,
            compressor: Compressor::new(layout, search.compression)
                .map_err(|e| option("kc, --weight-exponent", &e))?,
            counts: vec![[0; 3]; layout.taxels()],
            scan: Scan::new(layout),
            relative: None,
            before: Vec::new(),
            rows: 0,
            layout: layout.clone(),
        })
    }

    /// Rows so far.
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// The contacts of the next row of raw counts. The reference rows emit nothing; the row that sets the threshold is
    /// a frame.
    ///
    /// # Errors
    /// [`Failure::Input`] for a row of another length, and for a frame that is none, with the row.
    pub fn row(&mut self, time_us: u64, row: &[u16]) -> Result<&[Contact], Failure> {
        let frame = self.rows;
        let wrong = |e: &dyn std::fmt::Display| Failure::Input(format!("row {frame}: {e}"));
        if row.len() != self.columns.count() {
            let (expected, found) = (self.columns.count(), row.len());
            return Err(wrong(&format!("expected {expected} counts, found {found}")));
        }
        self.rows += 1;
        let repeats = frame > 0 && row == self.before;
        self.before.clear();
        self.before.extend_from_slice(row);
        if repeats && self.skips_repeats && self.relative.is_some() {
            return Ok(&[]);
        }
        let axes = usize::from(self.columns.axes).max(1);
        for (reading, &taxel) in row.chunks_exact(axes).zip(&self.active) {
            self.counts[taxel] = match *reading {
                [x, y, z] => [x, y, z],
                [z, ..] => [0, 0, z],
                [] => [0; 3],
            };
        }
        let loaded = self.scan.load(Instant::from_micros(time_us), &self.counts);
        loaded.map_err(|e| wrong(&e))?;
        if self.baseline.phase() != BaselinePhase::Ready {
            self.baseline.feed(&self.scan);
        }
        let is_reference = frame < self.reference_frames;
        if is_reference || self.baseline.phase() != BaselinePhase::Ready {
            return Ok(&[]);
        }
        let (baseline, compressor) = (&mut self.baseline, &mut self.compressor);
        let layout = &self.layout;
        let relative = self.relative.get_or_insert_with(|| baseline.frame(layout));
        let mut compress = || {
            if baseline.advance(&self.scan, relative)? || !compressor.repeat() {
                compressor.compress(relative)?;
            }
            Ok(())
        };
        compress().map_err(|e: FrameError| wrong(&e))?;
        Ok(compressor.contacts())
    }
}
