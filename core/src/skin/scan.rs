//! From single readings to scans: a board sends one frame a taxel, without number or time, and a lost
//! frame must not merge two scans.

use alloc::boxed::Box;
use alloc::vec;

use crate::units::{Duration, Instant};

/// A pause this long between two readings of a module ends its scan: at 100 Hz the readings of a scan
/// lie together within 2 ms, on a full bus they come without a pause.
const GAP: Duration = Duration::from_millis(4);

/// The readings of one module, as they come in.
///
/// A taxel whose frame was lost keeps its last value. The scan ends with the last taxel in the order on
/// the wire, when the order goes back, or after a pause.
#[derive(Clone, Debug)]
pub struct Scan {
    counts: Box<[[u16; 3]]>,
    fresh: Box<[bool]>,
    /// Position on the wire and time of the last reading of the open scan.
    last: Option<(usize, Instant)>,
    /// Position of the last taxel of a scan.
    end: usize,
}

impl Scan {
    /// For a module of so many taxels whose last one stands at position `end` on the wire.
    pub fn new(taxels: usize, end: usize) -> Self {
        Self {
            counts: vec![[0; 3]; taxels].into(),
            fresh: vec![false; taxels].into(),
            last: None,
            end,
        }
    }

    /// Whether a reading at this position and time belongs to the next scan, so that the open one has
    /// to be taken first.
    pub fn ends_before(&self, position: usize, at: Instant) -> bool {
        self.last
            .is_some_and(|(last, time)| position <= last || at.since(time) > GAP)
    }

    /// When the open scan ends by itself.
    pub fn deadline(&self) -> Option<Instant> {
        self.last.map(|(_, time)| time + GAP)
    }

    /// Takes a reading. Taxels out of range are ignored.
    pub fn put(&mut self, taxel: usize, position: usize, counts: [u16; 3], at: Instant) {
        if let (Some(slot), Some(fresh)) = (self.counts.get_mut(taxel), self.fresh.get_mut(taxel)) {
            *slot = counts;
            *fresh = true;
            self.last = Some((position, at));
        }
    }

    /// Whether the last taxel of the scan has come.
    pub fn is_complete(&self) -> bool {
        self.last.is_some_and(|(last, _)| last >= self.end)
    }

    /// Time of the newest reading of the open scan.
    pub fn time(&self) -> Option<Instant> {
        self.last.map(|(_, time)| time)
    }

    /// Raw counts by taxel; a taxel that did not come in this scan holds its last value.
    pub const fn counts(&self) -> &[[u16; 3]] {
        &self.counts
    }

    /// Which taxels came in this scan.
    pub const fn fresh(&self) -> &[bool] {
        &self.fresh
    }

    /// Closes the scan and opens the next.
    pub fn close(&mut self) {
        self.fresh.fill(false);
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    /// Feeds (position, microseconds) and returns how many readings each scan had.
    fn scans(readings: &[(usize, u64)]) -> Vec<usize> {
        let mut scan = Scan::new(16, 15);
        let mut sizes = Vec::new();
        let mut close = |scan: &mut Scan| {
            sizes.push(scan.fresh().iter().filter(|&&f| f).count());
            scan.close();
        };
        for &(position, us) in readings {
            let at = Instant::from_micros(us);
            if scan.ends_before(position, at) {
                close(&mut scan);
            }
            scan.put(position, position, [1; 3], at);
            if scan.is_complete() {
                close(&mut scan);
            }
        }
        if scan.deadline().is_some() {
            close(&mut scan);
        }
        sizes
    }

    #[test]
    fn whole_scans_end_with_their_last_taxel() {
        let two: Vec<_> = (0..32)
            .map(|i| (i % 16, (i as u64 / 16) * 10_000 + 116 * (i as u64 % 16)))
            .collect();
        assert_eq!(scans(&two), [16, 16]);
    }

    #[test]
    fn lost_frames_never_merge_two_scans() {
        // The last taxel lost, then the first ones of the next scan lost: the order goes back.
        assert_eq!(
            scans(&[(0, 0), (1, 100), (14, 1500), (2, 10_200), (15, 11_500)]),
            [3, 2]
        );
        // The order goes on, but 8 ms have passed.
        assert_eq!(
            scans(&[(0, 0), (1, 100), (2, 10_200), (15, 11_500)]),
            [2, 2]
        );
        // On a full bus a scan takes 30 ms without a pause over 4 ms.
        let slow: Vec<_> = (0..16).map(|i| (i, i as u64 * 1_900)).collect();
        assert_eq!(scans(&slow), [16]);
    }

    #[test]
    fn a_lost_taxel_keeps_its_value_and_is_not_fresh() {
        let mut scan = Scan::new(2, 1);
        scan.put(0, 0, [5; 3], Instant::ZERO);
        scan.close();
        scan.put(1, 1, [7; 3], Instant::from_micros(10_000));
        scan.put(9, 9, [7; 3], Instant::from_micros(10_001));
        assert_eq!(scan.counts(), [[5; 3], [7; 3]]);
        assert_eq!(scan.fresh(), [false, true]);
    }
}
