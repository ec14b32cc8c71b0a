//! The margin ledger: every limit, the worst that the emulated hardware came to, and what was left.
//!
//! Measured behind the guard: from currents that flowed and temperatures that were reached, whatever was asked for.

use palpate_core::guard::{BURST_GAP, Limits};
use palpate_emulators::display::{DisplayTotals, Flow, ThermalSample};
use palpate_emulators::time::Nanos;
use palpate_records::report::{Margin, SkinLimits, Warmth};

/// What of a temperature limit is used up counts from here, degrees C.
const REST_C: f64 = 33.0;

/// What a run did to wires and skin.
pub struct Course<'a> {
    /// Every stretch of current.
    pub flows: &'a [Flow],
    /// Temperatures over time.
    pub samples: &'a [ThermalSample],
    /// Maxima and sums.
    pub totals: &'a DisplayTotals,
    /// How many wires there are.
    pub wires: usize,
}

/// A sample as the report takes it.
pub fn warmth(sample: &ThermalSample) -> Warmth {
    Warmth {
        t_s: sample.at.as_secs_f64(),
        wire_c: sample.wire_c,
        shallow_c: sample.shallow_c,
        deep_c: sample.deep_c,
        mean_c: sample.mean_c,
    }
}

/// The skin's limits of a table.
pub const fn skin_limits(file: &palpate_files::Limits) -> SkinLimits {
    SkinLimits {
        peak_c: file.skin.peak_c,
        mean_c: file.skin.mean_10s_c,
        deep_c: file.skin.deep_c,
    }
}

/// The ledger, most used up first.
pub fn margins(course: &Course<'_>, limits: &Limits, file: &palpate_files::Limits) -> Vec<Margin> {
    let rest = |name, worst, limit, unit| Margin::new(name, worst, limit, unit, 0.0);
    let warm = |name, worst, limit| Margin::new(name, worst, limit, "C", REST_C);
    let milli = |uw: u64| uw as f64 * 1e-3;
    let wires = (0..course.wires).map(|w| Energy::of(course.flows, |f| f.wire == w));
    let wires: Vec<Energy> = wires.collect();
    let finger = Energy::of(course.flows, |_| true);
    let worst = |seconds: f64| {
        let means = wires.iter().map(|e| e.worst_mean_mw(seconds));
        means.fold(0.0, f64::max)
    };
    let longest = course.flows.iter().map(|f| f.to.since(f.from).0).max();
    let bursts = bursts(course.flows, course.wires);
    let mean = course
        .samples
        .iter()
        .map(|s| s.mean_c)
        .fold(REST_C, f64::max);
    let totals = course.totals;
    let mut all = vec![
        rest(
            "pulse",
            longest.unwrap_or(0) as f64 * 1e-3,
            limits.pulse_width_ns as f64 * 1e-3,
            "us",
        ),
        rest(
            "burst",
            bursts.0,
            limits.burst.as_micros() as f64 * 1e-3,
            "ms",
        ),
        rest(
            "burst energy",
            bursts.1,
            limits.burst_energy_nj as f64 * 1e-6,
            "mJ",
        ),
        rest(
            "wire power, 1 s",
            worst(1.0),
            milli(limits.wire_1s_uw),
            "mW",
        ),
        rest(
            "wire power, 10 s",
            worst(10.0),
            milli(limits.wire_10s_uw),
            "mW",
        ),
        rest(
            "fingertip power, 1 s",
            finger.worst_mean_mw(1.0),
            milli(limits.fingertip_1s_uw),
            "mW",
        ),
        rest(
            "fingertip power, 60 s",
            finger.worst_mean_mw(60.0),
            milli(limits.fingertip_60s_uw),
            "mW",
        ),
        rest(
            "supply current",
            f64::from(totals.peak_supply.0) * 1e-3,
            f64::from(limits.supply.0) * 1e-3,
            "A",
        ),
        warm("skin at 0.1 mm, 10 s mean", mean, file.skin.mean_10s_c),
        warm("skin at 0.1 mm", totals.hottest_skin_c, file.skin.peak_c),
        warm("skin at 0.4 mm", totals.hottest_deep_c, file.skin.deep_c),
        rest(
            "Henriques dose",
            totals.dose.0,
            file.dose.henriques_omega,
            "",
        ),
        rest("dose, CEM43", totals.dose.1, file.dose.cem43_min, "min"),
    ];
    all.sort_by(|a, b| b.used.total_cmp(&a.used).then(a.name.cmp(b.name)));
    all
}

/// Electrical energy over time: straight between these instants.
struct Energy(Vec<(Nanos, f64)>);

impl Energy {
    fn of(flows: &[Flow], wanted: impl Fn(&Flow) -> bool) -> Self {
        let mut changes: Vec<(Nanos, f64)> = flows
            .iter()
            .filter(|f| wanted(f))
            .flat_map(|f| [(f.from, f.watts), (f.to, -f.watts)])
            .collect();
        changes.sort_by_key(|c| c.0);
        let (mut joule, mut watts, mut now) = (0.0, 0.0, Nanos::ZERO);
        let mut course = vec![(Nanos::ZERO, 0.0)];
        for (at, change) in changes {
            joule += watts * at.since(now).as_secs_f64();
            watts += change;
            now = at;
            course.push((at, joule));
        }
        Self(course)
    }

    fn until(&self, at: Nanos) -> f64 {
        let next = self.0.partition_point(|p| p.0 <= at);
        match (self.0.get(next.wrapping_sub(1)), self.0.get(next)) {
            (Some(a), Some(b)) => {
                let part = at.since(a.0).as_secs_f64() / b.0.since(a.0).as_secs_f64();
                a.1 + (b.1 - a.1) * part
            }
            (Some(a), None) => a.1,
            (None, _) => 0.0,
        }
    }

    /// Largest mean power over any window of so many seconds, mW. It is reached where a window begins or ends with
    /// a change.
    fn worst_mean_mw(&self, seconds: f64) -> f64 {
        let window = Nanos((seconds * 1e9) as u64);
        let of = |end: Nanos| self.until(end) - self.until(end.since(window));
        let ends = self.0.iter().flat_map(|p| [p.0, p.0 + window]);
        ends.map(of).fold(0.0, f64::max) / seconds * 1e3
    }
}

/// Longest burst on a wire, ms, and most energy of one, mJ.
fn bursts(flows: &[Flow], wires: usize) -> (f64, f64) {
    let gap = Nanos::from(palpate_core::units::Instant::ZERO + BURST_GAP);
    let mut worst = (0.0_f64, 0.0_f64);
    for wire in 0..wires {
        let mut open: Option<(Nanos, Nanos, f64)> = None;
        for f in flows.iter().filter(|f| f.wire == wire) {
            let joule = f.watts * f.to.since(f.from).as_secs_f64();
            let same = open.filter(|b| f.from.since(b.1) < gap);
            let burst = same.map_or((f.from, f.to, joule), |b| (b.0, f.to, b.2 + joule));
            worst.0 = worst.0.max(burst.1.since(burst.0).as_secs_f64() * 1e3);
            worst.1 = worst.1.max(burst.2 * 1e3);
            open = Some(burst);
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flow(wire: usize, from_ms: u64, to_ms: u64, watts: f64) -> Flow {
        Flow {
            wire,
            from: Nanos::from_micros(from_ms * 1000),
            to: Nanos::from_micros(to_ms * 1000),
            watts,
        }
    }

    #[test]
    fn the_worst_window_is_found_wherever_it_lies() {
        // 100 ms at 1 W, twice, half a second apart: any second that holds both has 200 mW.
        let flows = [flow(0, 3000, 3100, 1.0), flow(0, 3600, 3700, 1.0)];
        let energy = Energy::of(&flows, |_| true);
        assert!((energy.worst_mean_mw(1.0) - 200.0).abs() < 1e-9);
        // A window of 0.65 s holds one of them and half the other.
        assert!((energy.worst_mean_mw(0.65) - 150.0 / 0.65).abs() < 1e-9);
        // A run shorter than the window: the rest was nothing.
        assert!((energy.worst_mean_mw(10.0) - 20.0).abs() < 1e-9);
        assert!(Energy::of(&[], |_| true).worst_mean_mw(1.0).abs() < 1e-12);
    }

    #[test]
    fn bursts_end_with_a_gap_and_belong_to_one_wire() {
        let flows = [
            flow(0, 0, 1, 2.0),
            flow(1, 2, 3, 2.0),
            flow(0, 5, 6, 2.0),
            flow(0, 30, 31, 2.0),
        ];
        let (ms, mj) = bursts(&flows, 2);
        assert!(
            (ms - 6.0).abs() < 1e-9 && (mj - 4.0).abs() < 1e-9,
            "{ms} {mj}"
        );
    }
}
