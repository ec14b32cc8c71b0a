//! One module's readings of a recording that holds those of all modules side by side.

use std::ops::Range;
use std::sync::Arc;

use palpate_run::{Failure, NextRow, RowSource};

/// Some columns of a recording.
#[derive(Debug)]
pub(super) struct Part {
    whole: Arc<dyn RowSource>,
    columns: Range<usize>,
}

impl Part {
    /// A recording taken apart, module after module, into so many columns each.
    pub(super) fn all_of(whole: &Arc<dyn RowSource>, widths: &[usize]) -> Vec<Arc<dyn RowSource>> {
        let mut start = 0;
        let part = |width: &usize| -> Arc<dyn RowSource> {
            let columns = start..start + width;
            start += width;
            Arc::new(Self {
                whole: Arc::clone(whole),
                columns,
            })
        };
        widths.iter().map(part).collect()
    }
}

impl RowSource for Part {
    fn columns(&self) -> usize {
        self.columns.len()
    }

    fn frames(&self) -> usize {
        self.whole.frames()
    }

    fn span_us(&self) -> u64 {
        self.whole.span_us()
    }

    fn rows(&self) -> Result<Box<dyn NextRow + '_>, Failure> {
        Ok(Box::new(PartRows {
            whole: self.whole.rows()?,
            columns: self.columns.clone(),
            row: Vec::new(),
        }))
    }
}

/// Rows of the whole, and their part.
struct PartRows<'a> {
    whole: Box<dyn NextRow + 'a>,
    columns: Range<usize>,
    row: Vec<u16>,
}

impl NextRow for PartRows<'_> {
    fn next_row(&mut self, counts: &mut Vec<u16>) -> Result<Option<u64>, Failure> {
        let time = self.whole.next_row(&mut self.row)?;
        counts.clear();
        if time.is_some() {
            counts.extend(self.row.get(self.columns.clone()).unwrap_or_default());
        }
        Ok(time)
    }
}

#[cfg(test)]
#[path = "part_tests.rs"]
mod tests;
