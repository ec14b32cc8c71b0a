//! Readings that another machine sends, as the sensor end of a run: a row of the whole skin at a time, none known
//! before it comes.

use std::fmt;

use palpate_core::skin::{Layout, ModuleScan, SkinSource};
use palpate_core::units::Instant;
use palpate_files::SensorLayout;

use crate::failure::Failure;
use crate::replay::{NextRow, RowSource, axes};
use crate::skin_end::SkinEnd;

/// A module's share of a row.
struct Share {
    /// Taxels that the row has readings of.
    read: Box<[usize]>,
    fresh: Box<[bool]>,
    counts: Box<[[u16; 3]]>,
}

/// Rows as they come. The run's time waits for each of them.
pub struct Streamed<'a> {
    rows: Box<dyn NextRow + 'a>,
    axes: usize,
    modules: Vec<Share>,
    row: Vec<u16>,
    /// When the row that has come is due.
    due: Option<Instant>,
    ended: bool,
}

impl fmt::Debug for Streamed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Streamed")
            .field("due", &self.due)
            .finish_non_exhaustive()
    }
}

impl<'a> Streamed<'a> {
    /// The readings of all of a layout's modules, one module after another in every row.
    ///
    /// # Errors
    /// [`Failure::Input`] for rows of another length.
    pub fn new(
        source: &'a dyn RowSource,
        file: &SensorLayout,
        layout: &Layout,
    ) -> Result<Self, Failure> {
        let axes = usize::from(file.axes);
        let share = |module: &palpate_core::skin::Module| {
            let taxels = 0..module.active().len();
            Share {
                counts: vec![[0; 3]; taxels.len()].into(),
                read: taxels.filter(|&t| module.active()[t]).collect(),
                fresh: module.active().into(),
            }
        };
        let modules: Vec<Share> = layout.modules().iter().map(share).collect();
        let columns = axes * modules.iter().map(|m| m.read.len()).sum::<usize>();
        if source.columns() != columns {
            return Err(Failure::Input(format!(
                "the stream: expected rows of {columns} counts, found {}",
                source.columns()
            )));
        }
        Ok(Self {
            rows: source.rows()?,
            axes,
            modules,
            row: Vec::new(),
            due: None,
            ended: false,
        })
    }
}

impl SkinSource for Streamed<'_> {
    type Error = Failure;

    fn scans(
        &mut self,
        now: Instant,
        take: &mut impl FnMut(&ModuleScan<'_>),
    ) -> Result<(), Failure> {
        loop {
            if self.due.is_none() && !self.ended {
                let came = self.rows.next_row(&mut self.row)?;
                self.due = came.map(Instant::from_micros);
                self.ended = came.is_none();
            }
            let Some(at) = self.due.take_if(|at| *at <= now) else {
                return Ok(());
            };
            let mut readings = self.row.chunks_exact(self.axes);
            for (number, module) in (0..).zip(&mut self.modules) {
                for (taxel, reading) in module.read.iter().zip(&mut readings) {
                    module.counts[*taxel] = axes(reading);
                }
                take(&ModuleScan {
                    module: number,
                    at,
                    counts: &module.counts,
                    fresh: Some(&module.fresh),
                });
            }
        }
    }
}

impl SkinEnd for Streamed<'_> {
    fn advance_to(&mut self, _now: Instant) {}
}
