//! Contacts of rows, and nothing else: (4.1) to (4.10), row by row, without a display.

use palpate_core::contact::{Compressor, Contact, Settings};
use palpate_core::skin::{
    BaselineSettings, Condition, FrameError, HealthSettings, Layout, Module, Scan, Sense,
};
use palpate_core::units::Instant;
use palpate_files::Columns;

use crate::failure::Failure;

/// Taxels named one by one.
const NAMED: usize = 4;

/// Settings of the search for contacts.
#[derive(Clone, Debug)]
pub struct Search {
    /// Baseline that is subtracted from rows.
    pub baseline: BaselineSettings,
    /// Thresholds and compression that make contacts of a row.
    pub compression: Settings,
    /// `true` to leave out rows that repeat the one before.
    pub skips_repeats: bool,
}

/// Remarks on a skin that was not at rest while its reference was taken: rows without a reference, and references that
/// readings fell below.
pub(crate) fn not_at_rest(rows: u32, touched: u32) -> Vec<String> {
    let moved = (rows > 0).then(|| format!(
        "reference not at rest: the skin was moved in {rows} more rows, and nothing is known of touches in them"
    ));
    let touched = (touched > 0).then(|| format!(
        "reference not at rest: {touched} times readings fell below it, so that it was touched when it was taken; contacts before may be missing or misplaced"
    ));
    moved.into_iter().chain(touched).collect()
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
    sense: Sense,
    /// Taxels that were left out, and the first row of each.
    ill: Vec<(usize, Condition, usize)>,
    compressor: Compressor,
    counts: Vec<[u16; 3]>,
    scan: Scan,
    is_ready: bool,
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
            sense: Sense::new(layout, search.baseline, HealthSettings::default())
                .map_err(|e| option("reference-frames", &e))?,
            ill: Vec::new(),
            compressor: Compressor::new(layout, search.compression)
                .map_err(|e| option("kc, --weight-exponent", &e))?,
            counts: vec![[0; 3]; layout.taxels()],
            scan: Scan::new(layout),
            is_ready: false,
            before: Vec::new(),
            rows: 0,
            layout: layout.clone(),
        })
    }

    /// Rows so far.
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// Remarks on the skin so far: rows without a reference, a reference that was taken touched, taxels left out.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let baseline = self.sense.baseline();
        let mut notes = not_at_rest(baseline.unrest(), baseline.taken_touched());
        let word = |condition: Condition| match condition {
            Condition::Dead => "was not received",
            Condition::Frozen => "stood still",
            Condition::Saturated => "was at the end of its range",
            _ => "jumped",
        };
        let ill = self.ill.iter().take(NAMED);
        notes.extend(ill.map(|(taxel, condition, row)| {
            format!(
                "taxel {taxel} {} in row {row}: left out as long as that lasts",
                word(*condition)
            )
        }));
        if let Some(more) = self.ill.len().checked_sub(NAMED).filter(|n| *n > 0) {
            notes.push(format!("{more} more taxels left out at times"));
        }
        notes
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
        if repeats && self.skips_repeats && self.is_ready {
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
        let (layout, ill) = (&self.layout, &mut self.ill);
        for module in 0..layout.modules().len() {
            let sick = &mut |taxel, condition| {
                let known = ill.iter().any(|(t, c, _)| (*t, *c) == (taxel, condition));
                if !known && !matches!(condition, Condition::Good | Condition::Inactive) {
                    ill.push((taxel, condition, frame));
                }
            };
            self.sense.watch(&self.scan, module, layout, sick);
        }
        let news = self.sense.frame(&self.scan);
        let news = news.map_err(|e: FrameError| wrong(&e))?;
        self.is_ready = news.is_some();
        let Some(news) = news.filter(|_| frame >= self.reference_frames) else {
            return Ok(&[]);
        };
        let compressor = &mut self.compressor;
        if news || !compressor.repeat() {
            let compressed = compressor.compress(self.sense.relative());
            compressed.map_err(|e| wrong(&e))?;
        }
        Ok(compressor.contacts())
    }
}
