//! The newest readings of the whole skin, merged from scans of its modules.

use alloc::vec::Vec;

use super::layout::Layout;
use super::source::{ModuleScan, ScanError};
use crate::units::Instant;

/// A row with another number of taxels than the layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{got} taxels, the layout has {expected}")]
pub struct WrongLength {
    /// Taxels in the row.
    pub got: usize,
    /// Taxels in the layout.
    pub expected: usize,
}

/// The newest scan of every module, taxels in the layout's running index.
#[derive(Clone, Debug)]
pub struct Scan {
    at: Instant,
    counts: Vec<[u16; 3]>,
    seen: Vec<bool>,
    fresh: Vec<bool>,
    /// The modules whose newest scan had every taxel.
    whole: Vec<bool>,
}

impl Scan {
    /// An empty scan: no taxel seen yet.
    pub fn new(layout: &Layout) -> Self {
        let n = layout.taxels();
        Self {
            at: Instant::ZERO,
            counts: alloc::vec![[0; 3]; n],
            seen: alloc::vec![false; n],
            fresh: alloc::vec![false; n],
            whole: alloc::vec![false; layout.modules().len()],
        }
    }

    /// Takes a whole frame at once (a row of a recording); every taxel is then fresh.
    ///
    /// # Errors
    /// [`WrongLength`] for another number of taxels; nothing has changed then.
    pub fn load(&mut self, at: Instant, counts: &[[u16; 3]]) -> Result<(), WrongLength> {
        if counts.len() != self.counts.len() {
            return Err(WrongLength {
                got: counts.len(),
                expected: self.counts.len(),
            });
        }
        self.at = at;
        self.counts.copy_from_slice(counts);
        self.seen.fill(true);
        self.fresh.fill(true);
        self.whole.fill(true);
        Ok(())
    }

    /// Takes one module's scan. The skin is as old as its newest reading.
    ///
    /// # Errors
    /// [`ScanError`] for a scan that is not of this layout; nothing has changed then.
    pub fn merge(&mut self, layout: &Layout, scan: &ModuleScan<'_>) -> Result<(), ScanError> {
        let (module, modules) = (scan.module, layout.modules().len());
        if usize::from(module) >= modules {
            return Err(ScanError::NoSuchModule { module, modules });
        }
        let range = layout.range(usize::from(module));
        let expected = range.len();
        let flags = scan.fresh.map_or(expected, <[bool]>::len);
        if let Some(got) = [scan.counts.len(), flags]
            .into_iter()
            .find(|n| *n != expected)
        {
            return Err(ScanError::Taxels {
                module,
                got,
                expected,
            });
        }
        let counts = &mut self.counts[range.clone()];
        let (seen, fresh) = (&mut self.seen[range.clone()], &mut self.fresh[range]);
        // Most scans are whole: one copy then, without a branch per taxel.
        let partial = scan
            .fresh
            .filter(|f| !f.iter().fold(true, |all, fresh| all & fresh));
        let was_whole = &mut self.whole[usize::from(module)];
        let before = core::mem::replace(was_whole, partial.is_none());
        match partial {
            None => {
                counts.copy_from_slice(scan.counts);
                if !before {
                    seen.fill(true);
                    fresh.fill(true);
                }
            }
            Some(flags) => {
                fresh.copy_from_slice(flags);
                for (i, _) in flags.iter().enumerate().filter(|(_, fresh)| **fresh) {
                    counts[i] = scan.counts[i];
                    seen[i] = true;
                }
            }
        }
        self.at = self.at.max(scan.at);
        Ok(())
    }

    /// Returns true if every taxel of a module was in its newest scan.
    pub(super) fn is_whole(&self, module: usize) -> bool {
        self.whole.get(module).is_some_and(|whole| *whole)
    }

    /// Time at which the newest reading in it was received.
    pub fn at(&self) -> Instant {
        self.at
    }
    /// Raw counts x, y, z per taxel; zero where never seen.
    pub fn counts(&self) -> &[[u16; 3]] {
        &self.counts
    }
    /// Flags of the taxels that were ever received.
    pub fn seen(&self) -> &[bool] {
        &self.seen
    }
    /// Flags of the taxels that were received in their module's newest scan.
    pub fn fresh(&self) -> &[bool] {
        &self.fresh
    }
}

#[cfg(test)]
#[path = "scan_tests.rs"]
mod tests;
