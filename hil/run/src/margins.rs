//! The margins of a run: every limit and the worst that the emulated hardware came to.
//!
//! Measured behind the guard: from currents that flowed and temperatures that were reached, whatever was asked for.

use palpate_core::guard::{BURST_GAP, Guard, Limits};
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::{DisplayTotals, Flow, ThermalSample};
use palpate_records::margin::{Limited, Margin, sort};
use palpate_records::report::Warmth;

/// What a run did to wires and skin.
pub struct Course<'a> {
    /// Every stretch of current.
    pub currents: &'a Currents,
    /// Temperatures over time.
    pub samples: &'a [ThermalSample],
    /// Maxima and sums.
    pub totals: &'a DisplayTotals,
}

/// So much current is held before the worst of it is taken.
const STRETCH: Nanos = Nanos(600_000_000_000);
/// What stays then: the longest window of a limit, and a burst.
const OVERLAP: Nanos = Nanos(70_000_000_000);

/// The worst of what flowed, in the units of the limits.
#[derive(Clone, Copy, Debug, Default)]
struct Worst {
    pulse_us: f64,
    burst_ms: f64,
    burst_mj: f64,
    wire_1s_mw: f64,
    wire_10s_mw: f64,
    finger_1s_mw: f64,
    finger_60s_mw: f64,
}

impl Worst {
    fn of(flows: &[Flow], wires: usize) -> Self {
        let each: Vec<Energy> = (0..wires)
            .map(|w| Energy::of(flows, |f| f.wire == w))
            .collect();
        let finger = Energy::of(flows, |_| true);
        let worst = |seconds: f64| {
            let means = each.iter().map(|e| e.worst_mean_mw(seconds));
            means.fold(0.0, f64::max)
        };
        let longest = flows.iter().map(|f| f.to.since(f.from).0).max();
        let (burst_ms, burst_mj) = bursts(flows, wires);
        Self {
            pulse_us: longest.unwrap_or(0) as f64 * 1e-3,
            burst_ms,
            burst_mj,
            wire_1s_mw: worst(1.0),
            wire_10s_mw: worst(10.0),
            finger_1s_mw: finger.worst_mean_mw(1.0),
            finger_60s_mw: finger.worst_mean_mw(60.0),
        }
    }

    fn or(self, other: &Self) -> Self {
        Self {
            pulse_us: self.pulse_us.max(other.pulse_us),
            burst_ms: self.burst_ms.max(other.burst_ms),
            burst_mj: self.burst_mj.max(other.burst_mj),
            wire_1s_mw: self.wire_1s_mw.max(other.wire_1s_mw),
            wire_10s_mw: self.wire_10s_mw.max(other.wire_10s_mw),
            finger_1s_mw: self.finger_1s_mw.max(other.finger_1s_mw),
            finger_60s_mw: self.finger_60s_mw.max(other.finger_60s_mw),
        }
    }
}

/// What flowed in a run of any length: the worst of it, and the last stretch.
#[derive(Clone, Debug, Default)]
pub struct Currents {
    wires: usize,
    worst: Worst,
    /// In the order of their ends.
    flows: Vec<Flow>,
}

impl Currents {
    /// Nothing, in so many wires.
    pub const fn new(wires: usize) -> Self {
        Self {
            wires,
            worst: Worst {
                pulse_us: 0.0,
                burst_ms: 0.0,
                burst_mj: 0.0,
                wire_1s_mw: 0.0,
                wire_10s_mw: 0.0,
                finger_1s_mw: 0.0,
                finger_60s_mw: 0.0,
            },
            flows: Vec::new(),
        }
    }

    /// Adds what flowed since.
    pub fn add(&mut self, flows: Vec<Flow>) {
        self.flows.extend(flows);
        let ends = self.flows.first().zip(self.flows.last());
        if ends.is_some_and(|(first, last)| last.to.since(first.from) > STRETCH) {
            self.worst = self.worst();
            let end = self.flows.last().map_or(Nanos::ZERO, |f| f.to);
            self.flows.retain(|f| end.since(f.to) < OVERLAP);
        }
    }

    fn worst(&self) -> Worst {
        self.worst.or(&Worst::of(&self.flows, self.wires))
    }
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

/// The margins, most used up first.
pub fn margins(course: &Course<'_>, limits: &Limits) -> Vec<Margin> {
    let worst = course.currents.worst();
    let means = course.samples.iter().map(|s| s.mean_c);
    let totals = course.totals;
    let kilo = |milli: u64| milli as f64 * 1e-3;
    use Limited as L;
    let mut all: Vec<Margin> = [
        (L::Pulse, worst.pulse_us, kilo(limits.pulse_width_ns)),
        (L::Burst, worst.burst_ms, kilo(limits.burst.as_micros())),
        (
            L::BurstEnergy,
            worst.burst_mj,
            limits.burst_energy_nj as f64 * 1e-6,
        ),
        (L::WirePower1s, worst.wire_1s_mw, kilo(limits.wire_1s_uw)),
        (L::WirePower10s, worst.wire_10s_mw, kilo(limits.wire_10s_uw)),
        (
            L::FingertipPower1s,
            worst.finger_1s_mw,
            kilo(limits.fingertip_1s_uw),
        ),
        (
            L::FingertipPower60s,
            worst.finger_60s_mw,
            kilo(limits.fingertip_60s_uw),
        ),
        (
            L::SupplyCurrent,
            f64::from(totals.peak_supply.0) * 1e-3,
            f64::from(limits.supply.0) * 1e-3,
        ),
        (
            L::SkinMean,
            means.fold(f64::NEG_INFINITY, f64::max),
            limits.skin_mean_mc as f64 / 1e3,
        ),
        (
            L::SkinPeak,
            totals.hottest_tissue_c,
            limits.skin_peak_mc as f64 / 1e3,
        ),
        (
            L::SkinDeep,
            totals.hottest_deep_c,
            limits.skin_deep_mc as f64 / 1e3,
        ),
        (
            L::Henriques,
            totals.dose.0,
            limits.dose_omega_ppm as f64 / 1e6,
        ),
        (L::Cem43, totals.dose.1, limits.dose_cem43_ms as f64 / 60e3),
    ]
    .map(|(of, worst, limit)| Margin::new(of, worst, limit))
    .into();
    sort(&mut all);
    all
}

/// The rows that a guard knows were passed, most first, where no instrument says what flowed: none unless a wire was on
/// for too long.
pub fn exceeded(guard: &Guard) -> Vec<Margin> {
    let Some(found) = guard.overrun() else {
        return Vec::new();
    };
    let (limits, skin) = (guard.limits(), guard.predicted());
    let milli = |value: u64| value as f64 * 1e-3;
    use Limited as L;
    let mut all: Vec<Margin> = [
        (
            L::Burst,
            milli(found.on.as_micros()),
            milli(limits.burst.as_micros()),
        ),
        (
            L::BurstEnergy,
            found.energy_nj as f64 * 1e-6,
            limits.burst_energy_nj as f64 * 1e-6,
        ),
        (L::SkinMean, skin.mean_c, milli(limits.skin_mean_mc)),
        (L::SkinPeak, skin.peak_c, milli(limits.skin_peak_mc)),
        (L::SkinDeep, skin.deep_c, milli(limits.skin_deep_mc)),
        (
            L::Henriques,
            skin.omega,
            limits.dose_omega_ppm as f64 * 1e-6,
        ),
        (L::Cem43, skin.cem43_min, limits.dose_cem43_ms as f64 / 60e3),
    ]
    .map(|(of, worst, limit)| Margin::new(of, worst, limit))
    .into();
    all.retain(Margin::over);
    sort(&mut all);
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
#[path = "margins_tests.rs"]
mod tests;
