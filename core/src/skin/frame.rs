//! Raw frames: the newest complete scan of every module, and the assembler that makes scans of readings.
//!
//! A reading carries no sequence number, so the order on the wire is all there is: chip-major, `k*4 + s`.
//! A scan ends with the last taxel in order, when the order goes back, or after a silence. Readings of two scans
//! are never put together; a taxel whose reading was lost holds its last value, and its age says so.

use alloc::vec::Vec;
use core::fmt;

use super::layout::Layout;
use crate::units::{Duration, Instant};

/// One taxel's reading off the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Module, zero-based.
    pub module: u16,
    /// Taxel within the module.
    pub taxel: u32,
    /// Place in the module's order on the wire (`k*4 + s` for uSkin).
    pub order: u32,
    /// Raw counts x, y, z; a one-axis skin uses z.
    pub counts: [u16; 3],
    /// When it was received.
    pub at: Instant,
}

/// A module or taxel that the layout does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownTaxel {
    /// Module, zero-based.
    pub module: u16,
    /// Taxel within the module.
    pub taxel: u32,
}

impl fmt::Display for UnknownTaxel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { module, taxel } = self;
        write!(f, "the layout has no taxel {taxel} in module {module}")
    }
}

impl core::error::Error for UnknownTaxel {}

/// A row with another number of taxels than the layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WrongLength {
    /// Taxels in the row.
    pub got: usize,
    /// Taxels in the layout.
    pub expected: usize,
}

impl fmt::Display for WrongLength {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} taxels, the layout has {}", self.got, self.expected)
    }
}

impl core::error::Error for WrongLength {}

/// The newest complete scan of every module, taxels in the layout's running index.
#[derive(Clone, Debug)]
pub struct Scan {
    at: Instant,
    counts: Vec<[u16; 3]>,
    received: Vec<Instant>,
    seen: Vec<bool>,
    fresh: Vec<bool>,
}

impl Scan {
    /// An empty scan: no taxel seen yet.
    pub fn new(layout: &Layout) -> Self {
        let n = layout.taxels();
        Self {
            at: Instant::ZERO,
            counts: alloc::vec![[0; 3]; n],
            received: alloc::vec![Instant::ZERO; n],
            seen: alloc::vec![false; n],
            fresh: alloc::vec![false; n],
        }
    }

    /// Takes a whole frame at once (a row of a recording); every taxel is then fresh.
    pub fn load(&mut self, at: Instant, counts: &[[u16; 3]]) -> Result<(), WrongLength> {
        if counts.len() != self.counts.len() {
            return Err(WrongLength {
                got: counts.len(),
                expected: self.counts.len(),
            });
        }
        self.at = at;
        self.counts.copy_from_slice(counts);
        self.received.fill(at);
        self.seen.fill(true);
        self.fresh.fill(true);
        Ok(())
    }

    /// When the newest reading in it was received.
    pub fn at(&self) -> Instant {
        self.at
    }
    /// Raw counts x, y, z per taxel; zero where never seen.
    pub fn counts(&self) -> &[[u16; 3]] {
        &self.counts
    }
    /// Whether a taxel was ever received.
    pub fn seen(&self) -> &[bool] {
        &self.seen
    }
    /// Whether a taxel was received in its module's newest scan.
    pub fn fresh(&self) -> &[bool] {
        &self.fresh
    }
    /// Time since a taxel was received; `None` if never.
    pub fn age(&self, index: usize, now: Instant) -> Option<Duration> {
        let seen = self.seen.get(index).copied().unwrap_or(false);
        seen.then(|| now.since(self.received[index]))
    }
}

/// The state of one module's unfinished scan.
#[derive(Clone, Copy, Debug)]
struct Pending {
    /// Running index of its first taxel, and how many it has.
    from: u32,
    taxels: u32,
    /// Order of its newest reading, `None` when there is no unfinished scan.
    order: Option<u32>,
    at: Instant,
    /// Order of the module's last taxel.
    last: u32,
    readings: u32,
    /// Readings of a complete scan.
    expected: u32,
    /// Readings missing from its scans so far.
    lost: u64,
}

/// Makes scans of readings, module by module.
#[derive(Clone, Debug)]
pub struct ScanAssembler {
    gap: Duration,
    pending: Vec<Pending>,
    /// What the unfinished scans have so far: counts, times, and of which taxels.
    counts: Vec<[u16; 3]>,
    received: Vec<Instant>,
    staged: Vec<bool>,
    scan: Scan,
    scans: u64,
    lost: u64,
}

impl ScanAssembler {
    /// The silence that ends a scan unless told otherwise.
    pub const DEFAULT_GAP: Duration = Duration::from_millis(4);

    /// An assembler for all modules of a layout. A module's order is taken to run over its active taxels.
    pub fn new(layout: &Layout, gap: Duration) -> Self {
        let modules = layout.modules().iter().zip(layout.starts());
        let pending = modules.map(|(m, from)| {
            let expected = m.active().iter().filter(|a| **a).count() as u32;
            Pending {
                from: *from,
                taxels: m.active().len() as u32, // a skin has at most 2^22
                order: None,
                at: Instant::ZERO,
                last: expected.saturating_sub(1),
                readings: 0,
                expected,
                lost: 0,
            }
        });
        let n = layout.taxels();
        Self {
            gap,
            pending: pending.collect(),
            counts: alloc::vec![[0; 3]; n],
            received: alloc::vec![Instant::ZERO; n],
            staged: alloc::vec![false; n],
            scan: Scan::new(layout),
            scans: 0,
            lost: 0,
        }
    }

    /// Tells that `module`'s scans end with `order`, for boards that leave numbers out.
    pub fn set_last_order(&mut self, module: usize, order: u32) {
        if let Some(p) = self.pending.get_mut(module) {
            p.last = order;
        }
    }

    /// Takes a reading. `done` gets the skin and the module whose scan has just ended; at most two end at one
    /// reading (one by a gap, one by its last taxel).
    ///
    /// # Errors
    /// A taxel that the layout does not have; nothing has changed then.
    #[inline]
    pub fn push(
        &mut self,
        reading: &Reading,
        mut done: impl FnMut(&Scan, u16),
    ) -> Result<(), UnknownTaxel> {
        let module = usize::from(reading.module);
        let place = self.pending.get(module);
        let Some(open) = place.filter(|p| reading.taxel < p.taxels) else {
            return Err(UnknownTaxel {
                module: reading.module,
                taxel: reading.taxel,
            });
        };
        let taxel = (open.from + reading.taxel) as usize;
        if let Some(order) = open.order {
            let twice = order == reading.order && self.staged[taxel];
            if twice && self.counts[taxel] == reading.counts {
                return Ok(()); // the same frame twice
            }
            if reading.order <= order || reading.at.since(open.at) > self.gap {
                self.end(module, &mut done);
            }
        }
        self.counts[taxel] = reading.counts;
        self.received[taxel] = reading.at;
        self.staged[taxel] = true;
        let p = &mut self.pending[module];
        p.order = Some(reading.order);
        p.at = reading.at;
        p.readings += 1;
        if reading.order >= p.last {
            self.end(module, &mut done);
        }
        Ok(())
    }

    /// Ends the scans that have been silent for longer than the gap.
    pub fn flush(&mut self, now: Instant, mut done: impl FnMut(&Scan, u16)) {
        for module in 0..self.pending.len() {
            let p = self.pending[module];
            if p.order.is_some() && now.since(p.at) > self.gap {
                self.end(module, &mut done);
            }
        }
    }

    /// Ends all unfinished scans (the end of a recording).
    pub fn finish(&mut self, mut done: impl FnMut(&Scan, u16)) {
        for module in 0..self.pending.len() {
            if self.pending[module].order.is_some() {
                self.end(module, &mut done);
            }
        }
    }

    /// Apart from [`ScanAssembler::push`], most calls of which do not come here.
    #[inline(never)]
    fn end(&mut self, module: usize, done: &mut impl FnMut(&Scan, u16)) {
        self.close(module);
        done(&self.scan, module as u16);
    }

    /// Takes what a module has sent into the scan.
    fn close(&mut self, module: usize) {
        let p = &mut self.pending[module];
        let range = p.from as usize..(p.from + p.taxels) as usize;
        let staged = &mut self.staged[range.clone()];
        let (counts, received) = (&self.counts[range.clone()], &self.received[range.clone()]);
        let scan = &mut self.scan;
        scan.fresh[range.clone()].copy_from_slice(staged);
        if staged.iter().fold(true, |all, staged| all & staged) {
            scan.counts[range.clone()].copy_from_slice(counts);
            scan.received[range.clone()].copy_from_slice(received);
            scan.seen[range].fill(true);
        } else {
            for (i, taxel) in range.enumerate().filter(|(i, _)| staged[*i]) {
                scan.counts[taxel] = counts[i];
                scan.received[taxel] = received[i];
                scan.seen[taxel] = true;
            }
        }
        staged.fill(false);
        p.order = None;
        scan.at = scan.at.max(p.at);
        self.scans += 1;
        let lost = u64::from(p.expected.saturating_sub(p.readings));
        self.lost += lost;
        p.lost += lost;
        p.readings = 0;
    }

    /// The skin as of the newest complete scans.
    pub fn scan(&self) -> &Scan {
        &self.scan
    }
    /// Module scans ended so far.
    pub fn scans(&self) -> u64 {
        self.scans
    }
    /// Readings missing from one module's scans; scans of which nothing came are not known of.
    pub fn lost_of(&self, module: usize) -> u64 {
        self.pending.get(module).map_or(0, |p| p.lost)
    }
    /// Readings missing from those scans.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}

#[cfg(test)]
#[path = "frame_tests.rs"]
mod tests;
