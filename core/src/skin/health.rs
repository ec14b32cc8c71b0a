//! Which taxels can be trusted: refresh rate, frozen, never seen, saturated. Frame rates say nothing:
//! boards repeat stale rows, so changes of value are what is counted.

use alloc::boxed::Box;
use alloc::vec;
use alloc::vec::Vec;

use crate::units::{Duration, Instant};

/// A taxel whose value has not changed for this long while readings came in is frozen: noise alone
/// changes a healthy one within a few scans.
const FROZEN: Duration = Duration::from_millis(1000);

/// What is remembered of one taxel.
#[derive(Clone, Copy, Debug, Default)]
struct Taxel {
    last: [u16; 3],
    received: u32,
    changed: u32,
    saturated: u32,
    first_at: Instant,
    changed_at: Instant,
    seen_at: Instant,
}

/// The health of one module's taxels.
#[derive(Clone, Debug)]
pub struct Health {
    taxels: Box<[Taxel]>,
}

/// What a run says of a skin.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HealthSummary {
    /// Median over the taxels seen of the rate at which values change, Hz.
    pub refresh_median_hz: f64,
    /// The same for the slowest of them.
    pub refresh_min_hz: f64,
    /// Taxels that did not change for the last second although readings came in.
    pub frozen: Vec<usize>,
    /// Taxels never seen, or seen as all zeros only.
    pub dead: Vec<usize>,
    /// Taxels with an axis at 0 or 65535 in at least half of their readings.
    pub saturated: Vec<usize>,
    /// Readings that repeat the one before, over all readings but the first.
    pub repeated: f64,
}

impl Health {
    /// For a module of so many taxels.
    pub fn new(taxels: usize) -> Self {
        Self {
            taxels: vec![Taxel::default(); taxels].into(),
        }
    }

    /// Takes a reading. Taxels out of range are ignored.
    pub fn record(&mut self, taxel: usize, counts: [u16; 3], at: Instant) {
        let Some(t) = self.taxels.get_mut(taxel) else {
            return;
        };
        if t.received == 0 {
            (t.first_at, t.changed_at) = (at, at);
        } else if counts != t.last {
            t.changed = t.changed.saturating_add(1);
            t.changed_at = at;
        }
        if counts.iter().any(|&c| c == 0 || c == u16::MAX) {
            t.saturated = t.saturated.saturating_add(1);
        }
        t.last = counts;
        t.seen_at = at;
        t.received = t.received.saturating_add(1);
    }

    /// The summary over the taxels that `active` names. Allocates: for the end of a run or a report, not
    /// for the loop.
    pub fn summary(&self, active: &[bool]) -> HealthSummary {
        let mut rates = Vec::new();
        let mut summary = HealthSummary::default();
        let (mut received, mut changed) = (0u64, 0u64);
        for (i, t) in self.taxels.iter().enumerate() {
            if !active.get(i).copied().unwrap_or(false) {
                continue;
            }
            if t.received == 0 || (t.changed == 0 && t.last == [0; 3]) {
                summary.dead.push(i);
                continue;
            }
            let span = t.seen_at.since(t.first_at).as_secs_f64();
            if span > 0.0 {
                rates.push(f64::from(t.changed) / span);
            }
            if t.received > 1 && t.seen_at.since(t.changed_at) >= FROZEN {
                summary.frozen.push(i);
            }
            if t.saturated.saturating_mul(2) >= t.received {
                summary.saturated.push(i);
            }
            received += u64::from(t.received - 1);
            changed += u64::from(t.changed);
        }
        rates.sort_by(f64::total_cmp);
        summary.refresh_median_hz = rates.get(rates.len() / 2).copied().unwrap_or(0.0);
        summary.refresh_min_hz = rates.first().copied().unwrap_or(0.0);
        if received > 0 {
            summary.repeated = (received - changed) as f64 / received as f64;
        }
        summary
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_count_changes_and_frozen_taxels_are_named() {
        let mut health = Health::new(5);
        for frame in 0..400u16 {
            let at = Instant::from_micros(u64::from(frame) * 10_000);
            health.record(0, [frame, 5, 5], at); // every frame
            health.record(1, [frame / 4, 5, 5], at); // every fourth
            health.record(2, [frame.min(200), 5, 5], at); // stops after 2 s
            health.record(3, [0, 0, 0], at); // a dead line
            health.record(9, [1, 1, 1], at);
        }
        let summary = health.summary(&[true, true, true, true, true, true]);
        assert!(
            (summary.refresh_median_hz - 50.0).abs() < 1.0,
            "{summary:?}"
        );
        assert!((summary.refresh_min_hz - 25.0).abs() < 0.5);
        assert_eq!(summary.frozen, [2]);
        assert_eq!(summary.dead, [3, 4]);
        assert!(summary.saturated.is_empty());
    }

    #[test]
    fn saturation_and_silence() {
        let mut health = Health::new(1);
        health.record(0, [u16::MAX, 1, 1], Instant::ZERO);
        let summary = health.summary(&[true]);
        assert_eq!(summary.saturated, [0]);
        assert_eq!(summary.refresh_median_hz, 0.0);
        assert_eq!(Health::new(0).summary(&[]), HealthSummary::default());
    }
}
