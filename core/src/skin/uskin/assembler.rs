//! Assembly of scans from readings: it finds the frames off the bus that belong together.
//!
//! A reading carries no sequence number, so only the order on the bus tells: chip-major, `k*4 + s`, of uSkin boards,
//! and by index within triangles. A scan ends with the last taxel in order, when the order goes back, or after a
//! silence. Readings of two scans are never put together.

use alloc::vec::Vec;

use crate::skin::layout::{Layout, Module};
use crate::skin::source::ModuleScan;
use crate::units::{Duration, Instant};

/// One taxel's reading off the bus.
#[derive(Clone, Copy, Debug)]
pub(super) struct TaxelReading {
    /// Module, zero-based.
    pub(super) module: u16,
    /// Taxel within the module.
    pub(super) taxel: u16,
    /// Place in the module's order on the bus: a uSkin taxel's `k*4 + s`, or its index.
    pub(super) order: u16,
    /// Raw counts x, y, z; a one-axis skin uses z.
    pub(super) counts: [u16; 3],
    /// Time at which it was received.
    pub(super) at: Instant,
}

/// The state of one module's unfinished scan.
#[derive(Clone, Copy, Debug)]
struct Pending {
    /// Running index of the module's first taxel, and its number of taxels.
    from: u32,
    taxels: u32,
    /// Order of its newest reading, `None` when there is no unfinished scan.
    order: Option<u16>,
    at: Instant,
    /// Order of the module's last taxel: boards leave inactive ones out.
    last: u16,
    readings: u32,
    /// Readings of a complete scan.
    expected: u32,
    /// Readings missing from the module's scans so far.
    lost: u64,
}

impl Pending {
    fn new(module: &Module, from: u32) -> Self {
        let active = (0..module.points().len()).filter(|&i| module.active()[i]);
        let order = |i| module.sent_as(i);
        Self {
            from,
            taxels: module.points().len() as u32, // a skin has at most 2^22
            order: None,
            at: Instant::ZERO,
            last: active.clone().filter_map(order).max().unwrap_or(0) as u16, // a board has at most 192
            readings: 0,
            expected: active.count() as u32,
            lost: 0,
        }
    }
}

/// Makes scans of readings, module by module.
#[derive(Clone, Debug)]
pub(super) struct ScanAssembler {
    gap: Duration,
    pending: Vec<Pending>,
    /// Counts that the unfinished scans have so far, and their taxels.
    counts: Vec<[u16; 3]>,
    staged: Vec<bool>,
    lost: u64,
}

impl ScanAssembler {
    /// An assembler for all modules of a layout.
    pub(super) fn new(layout: &Layout, gap: Duration) -> Self {
        let modules = layout.modules().iter().zip(layout.starts());
        let n = layout.taxels();
        Self {
            gap,
            pending: modules.map(|(m, from)| Pending::new(m, *from)).collect(),
            counts: alloc::vec![[0; 3]; n],
            staged: alloc::vec![false; n],
            lost: 0,
        }
    }

    /// Sets another silence that ends a scan.
    pub(super) const fn set_gap(&mut self, gap: Duration) {
        self.gap = gap;
    }

    /// Takes a reading. `done` gets the scan that has just ended; at most two end at one reading (one by a gap, one
    /// by its last taxel). Returns `None` for a taxel that the layout lacks; nothing has changed then.
    #[inline]
    pub(super) fn push(
        &mut self,
        reading: &TaxelReading,
        mut done: impl FnMut(&ModuleScan<'_>),
    ) -> Option<()> {
        let module = usize::from(reading.module);
        let place = self.pending.get(module);
        let open = place.filter(|p| u32::from(reading.taxel) < p.taxels)?;
        let taxel = open.from as usize + usize::from(reading.taxel);
        if let Some(order) = open.order {
            let twice = order == reading.order && self.staged[taxel];
            if twice && self.counts[taxel] == reading.counts {
                return Some(()); // the same frame twice
            }
            if reading.order <= order || reading.at.since(open.at) > self.gap {
                self.end(module, &mut done);
            }
        }
        self.counts[taxel] = reading.counts;
        self.staged[taxel] = true;
        let p = &mut self.pending[module];
        p.order = Some(reading.order);
        p.at = reading.at;
        p.readings += 1;
        if reading.order >= p.last {
            self.end(module, &mut done);
        }
        Some(())
    }

    /// Ends the scans that have been silent for longer than the gap.
    pub(super) fn flush(&mut self, now: Instant, mut done: impl FnMut(&ModuleScan<'_>)) {
        for module in 0..self.pending.len() {
            let p = self.pending[module];
            if p.order.is_some() && now.since(p.at) > self.gap {
                self.end(module, &mut done);
            }
        }
    }

    /// Hands on the readings that a module has sent, and forgets them. It is apart from [`ScanAssembler::push`],
    /// because most calls of that do not come here.
    #[inline(never)]
    fn end(&mut self, module: usize, done: &mut impl FnMut(&ModuleScan<'_>)) {
        let p = &mut self.pending[module];
        let range = p.from as usize..(p.from + p.taxels) as usize;
        done(&ModuleScan {
            module: module as u16, // at most 4096
            at: p.at,
            counts: &self.counts[range.clone()],
            fresh: Some(&self.staged[range.clone()]),
        });
        self.staged[range].fill(false);
        p.order = None;
        let lost = u64::from(p.expected.saturating_sub(p.readings));
        self.lost += lost;
        p.lost += lost;
        p.readings = 0;
    }

    /// Readings missing from one module's scans; a scan of which nothing came stays unknown.
    pub(super) fn lost_of(&self, module: usize) -> u64 {
        self.pending.get(module).map_or(0, |p| p.lost)
    }

    /// Readings missing from all scans.
    pub(super) const fn lost(&self) -> u64 {
        self.lost
    }
}

#[cfg(test)]
#[path = "assembler_tests.rs"]
mod tests;
