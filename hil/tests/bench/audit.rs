//! A guard that watches instead of guarding: it books every burst that the chips' registers saw, by true time, whoever drove it
//! and whatever the program's own ledger knew. Its limits are those of one long run.

use std::panic::{AssertUnwindSafe, catch_unwind};

use palpate_core::codec::pca9685 as regs;
use palpate_core::guard::{Booked, Guard, Predicted};
use palpate_core::units::{Duration, Instant, Ticks};

use crate::ledger::guard;
use crate::rig::{Bench, now_ns, on_bench};

/// Channels of a chip.
const CHANNELS: usize = 16;
/// Tissue warms by no more than this in a millisecond in which a wire is on too long, degrees C: 9 K in a burst of 50 ms.
const PER_LATE_MS: f64 = 0.2;
/// The most by which booking in whole pulses and microseconds differs from the program's own, degrees C.
const ROUNDED_C: f64 = 0.3;

/// A channel that made pulses.
struct Burst {
    channel: u16,
    width: u16,
    on_ns: u64,
    off_ns: u64,
}

/// The account of every burst that a bench has driven since it was built.
pub struct Audit {
    cold: Guard,
    guard: Guard,
    begun_ns: u64,
    /// Changes of each adapter that are booked.
    booked: Vec<usize>,
    /// The beginning and the width of the pulses that each channel makes.
    on: Vec<[Option<(u64, u16)>; CHANNELS]>,
    /// Bursts so far.
    pub bursts: u64,
    /// The longest of them, milliseconds.
    pub longest_ms: f64,
    /// The highest prediction, also of heat that was forgotten since.
    pub most: Option<Predicted>,
}

impl Audit {
    /// Tissue that is cold.
    pub fn new(bench: &Bench, cold: Guard) -> Self {
        Self {
            guard: cold.clone(),
            cold,
            begun_ns: now_ns(),
            booked: vec![0; bench.adapters.len()],
            on: vec![[None; CHANNELS]; bench.adapters.len()],
            bursts: 0,
            longest_ms: 0.0,
            most: None,
        }
    }

    /// Another wearer, or the same one rested.
    pub fn forget(&mut self) {
        self.guard = self.cold.clone();
    }

    /// Books the bursts since the last call. The bench has to be off; the machine was late by so much meanwhile. Returns whether a
    /// limit was passed, and fails where lateness does not explain by how much.
    #[track_caller]
    pub fn take(&mut self, bench: &Bench, late_ms: f64) -> bool {
        let mut bursts = Vec::new();
        for (number, page) in bench.adapters.iter().enumerate() {
            let record = page.record().unwrap();
            for change in &record[self.booked[number]..] {
                for (channel, width) in change.widths[0].into_iter().enumerate() {
                    let on = &mut self.on[number][channel];
                    if on.map_or(0, |(_, width)| width) == width {
                        continue;
                    }
                    bursts.extend(on.take().map(|(on_ns, width)| Burst {
                        channel: channel as u16,
                        width,
                        on_ns,
                        off_ns: change.at_ns,
                    }));
                    *on = (width != 0).then_some((change.at_ns, width));
                }
            }
            self.booked[number] = record.len();
            let left = self.on[number].iter().flatten().count();
            assert_eq!(left, 0, "channels are still on");
        }
        self.bursts += bursts.len() as u64;
        let longest = bursts.iter().map(|burst| burst.off_ns - burst.on_ns).max();
        let longest_ms = longest.unwrap_or(0) as f64 * 1e-6;
        self.longest_ms = self.longest_ms.max(longest_ms);
        let bursts: Vec<_> = bursts.iter().map(|burst| self.booking(burst)).collect();
        self.guard.repeat(Instant::ZERO, &bursts);
        self.check(late_ms)
    }

    /// A burst as a guard books it. A pulse begins with each period, and one is on its way when a channel goes off.
    fn booking(&self, burst: &Burst) -> (u16, Booked) {
        let moment = |ns: u64| Instant::from_micros(ns.saturating_sub(self.begun_ns) / 1000);
        let guard = &self.guard;
        let pulses = (burst.off_ns - burst.on_ns) / guard.prescale().period_ns() + 1;
        let pulse_nj = guard.energy_nj(Ticks::new(burst.width), Duration::from_micros(1));
        let booked = Booked {
            on: moment(burst.on_ns),
            off: moment(burst.off_ns) + guard.surplus(),
            energy_nj: pulses * pulse_nj,
        };
        (burst.channel, booked)
    }

    /// Holds the prediction against the limits. Returns whether one was passed, and fails as [`Self::take`] does.
    #[track_caller]
    fn check(&mut self, late_ms: f64) -> bool {
        let (now, limits) = (*self.guard.predicted(), self.guard.limits());
        let rows = [
            (now.peak_c, limits.skin_peak_mc),
            (now.mean_c, limits.skin_mean_mc),
            (now.deep_c, limits.skin_deep_mc),
        ];
        let over = |(c, mc): &(f64, u64)| c - *mc as f64 * 1e-3 - ROUNDED_C;
        let over_c = rows.iter().map(over).fold(f64::MIN, f64::max);
        let omega = limits.dose_omega_ppm as f64 * 1e-6;
        let cem43_min = limits.dose_cem43_ms as f64 / 60_000.0;
        assert!(
            over_c <= PER_LATE_MS * late_ms && now.omega <= omega && now.cem43_min <= cem43_min,
            "limits are passed, machine late by {late_ms:.1} ms: {now:?}"
        );
        let most = self.most.get_or_insert(now);
        most.peak_c = most.peak_c.max(now.peak_c);
        most.mean_c = most.mean_c.max(now.mean_c);
        most.deep_c = most.deep_c.max(now.deep_c);
        most.omega = most.omega.max(now.omega);
        most.cem43_min = most.cem43_min.max(now.cem43_min);
        over_c > 0.0
    }
}

/// Writes bursts of 40 ms into the registers, 20 ms apart, by times that need not have come yet.
fn burst(bench: &Bench, from_ns: u64, count: u64) {
    let page = &bench.adapters[0];
    for number in 0..count {
        let at = from_ns + number * 60_000_000;
        for (at, off_ticks) in [(at, 50), (at + 40_000_000, 0)] {
            page.change(
                || at,
                |state| {
                    state.chips[0].write(&[regs::MODE1, regs::mode1::AI]);
                    state.chips[0].write(&[regs::led(0), 0, 0, off_ticks, 0]);
                },
            );
        }
    }
}

#[test]
fn what_no_guard_lets_through_is_noticed() {
    on_bench(1, |bench| {
        let scene = bench.scene(1.0);
        let mut audit = Audit::new(bench, guard(bench, &scene));
        let from = now_ns();
        burst(bench, from, 3);
        assert!(!audit.take(bench, 0.0));
        assert!(audit.bursts == 3 && (39.0..41.0).contains(&audit.longest_ms));
        assert!(audit.most.unwrap().peak_c > 34.0, "{:?}", audit.most);
        burst(bench, from + 1_000_000_000, 300);
        let noticed = catch_unwind(AssertUnwindSafe(|| audit.take(bench, 0.0)));
        assert!(noticed.is_err(), "{:?}", audit.most);
        // It is another wearer's, and there is nothing more to book.
        audit.forget();
        assert!(!audit.take(bench, 0.0));
    });
}
