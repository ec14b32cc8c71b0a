//! The margins of a run: every limit, and the worst value of the emulated hardware.
//!
//! Measured behind the guard: from currents that flowed and temperatures that were reached, whatever was requested.

use palpate_core::guard::{BURST_GAP, Guard, Limits};
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::{DisplayTotals, Flow, ThermalSample};
use palpate_records::margin::{Limited, Margin, sort};
use palpate_records::report::Warmth;

/// Currents and temperatures of a run, for its margins.
pub struct Course<'a> {
    /// Every stretch of current.
    pub currents: &'a Currents,
    /// Temperatures over time.
    pub samples: &'a [ThermalSample],
    /// Maxima and sums.
    pub totals: &'a DisplayTotals,
}

/// Time of currents that are held before the worst of them is taken.
const STRETCH: Nanos = Nanos(600_000_000_000);
/// Time of currents that stay then: the longest window of a limit, and a burst.
const OVERLAP: Nanos = Nanos(70_000_000_000);

/// The limits of currents that flow.
const OF_CURRENTS: [Limited; 7] = [
    Limited::Pulse,
    Limited::Burst,
    Limited::BurstEnergy,
    Limited::WirePower1s,
    Limited::WirePower10s,
    Limited::FingertipPower1s,
    Limited::FingertipPower60s,
];

/// Worst value of each of [`OF_CURRENTS`], in its unit.
type Worst = [f64; 7];

fn worst_of(flows: &[Flow], wires: usize) -> Worst {
    let each: Vec<Energy> = (0..wires)
        .map(|w| Energy::new(flows, |f| f.wire == w))
        .collect();
    let finger = Energy::new(flows, |_| true);
    let worst = |seconds: f64| {
        let means = each.iter().map(|e| e.worst_mean_mw(seconds));
        means.fold(0.0, f64::max)
    };
    let longest = flows.iter().map(|f| f.to.since(f.from).0).max();
    let (burst_ms, burst_mj) = bursts(flows, wires);
    [
        longest.unwrap_or(0) as f64 * 1e-3,
        burst_ms,
        burst_mj,
        worst(1.0),
        worst(10.0),
        finger.worst_mean_mw(1.0),
        finger.worst_mean_mw(60.0),
    ]
}

/// Currents of a run of any length: the worst of them, and the last stretch.
#[derive(Clone, Debug, Default)]
pub struct Currents {
    wires: usize,
    worst: Worst,
    /// Newest currents, in the order of their ends.
    flows: Vec<Flow>,
}

impl Currents {
    /// No currents yet, in so many wires.
    pub fn new(wires: usize) -> Self {
        Self {
            wires,
            ..Self::default()
        }
    }

    /// Adds the currents since the last call.
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
        let newest = worst_of(&self.flows, self.wires);
        std::array::from_fn(|row| self.worst[row].max(newest[row]))
    }
}

/// A sample in the form that the report takes.
pub fn warmth(sample: &ThermalSample) -> Warmth {
    Warmth {
        t_s: sample.at.as_secs_f64(),
        wire_c: sample.wire_c,
        shallow_c: sample.shallow_c,
        deep_c: sample.deep_c,
        mean_c: sample.mean_c,
    }
}

/// A limit in its unit; `None` for one of another table.
fn limit(of: Limited, limits: &Limits) -> Option<f64> {
    let (value, unit) = match of {
        Limited::Pulse => (limits.pulse_width_ns, 1e-3),
        Limited::Burst => (limits.burst.as_micros(), 1e-3),
        Limited::BurstEnergy => (limits.burst_energy_nj, 1e-6),
        Limited::WirePower1s => (limits.wire_1s_uw, 1e-3),
        Limited::WirePower10s => (limits.wire_10s_uw, 1e-3),
        Limited::FingertipPower1s => (limits.fingertip_1s_uw, 1e-3),
        Limited::FingertipPower60s => (limits.fingertip_60s_uw, 1e-3),
        Limited::HandPower60s => (limits.hand_60s_uw, 1e-3),
        Limited::SupplyCurrent => (limits.supply.0.into(), 1e-3),
        Limited::SkinMean => (limits.skin_mean_mc, 1e-3),
        Limited::SkinPeak => (limits.skin_peak_mc, 1e-3),
        Limited::SkinDeep => (limits.skin_deep_mc, 1e-3),
        Limited::Henriques => (limits.dose_omega_ppm, 1e-6),
        Limited::Cem43 => (limits.dose_cem43_ms, 1.0 / 60e3),
        Limited::FaceWarm
        | Limited::FaceCold
        | Limited::FaceRamp
        | Limited::Sink
        | Limited::PeltierCurrent
        | Limited::MotorVoltage
        | Limited::MotorTravel
        | Limited::CoilRise => return None,
    };
    Some(value as f64 * unit)
}

/// Margins of the worst values, the most used one first.
pub fn against(limits: &Limits, worst: impl IntoIterator<Item = (Limited, f64)>) -> Vec<Margin> {
    let margin = |(of, worst)| Some(Margin::new(of, worst, limit(of, limits)?));
    let mut all: Vec<Margin> = worst.into_iter().filter_map(margin).collect();
    sort(&mut all);
    all
}

/// The margins, most used up first.
pub fn margins(course: &Course<'_>, limits: &Limits) -> Vec<Margin> {
    let totals = course.totals;
    let means = course.samples.iter().map(|s| s.mean_c);
    let mean_c = means.fold(f64::NEG_INFINITY, f64::max);
    let supply_a = f64::from(totals.peak_supply.0) * 1e-3;
    let currents = OF_CURRENTS.into_iter().zip(course.currents.worst());
    let others = [
        (Limited::SupplyCurrent, supply_a),
        (Limited::SkinMean, mean_c),
        (Limited::SkinPeak, totals.hottest_tissue_c),
        (Limited::SkinDeep, totals.hottest_deep_c),
        (Limited::Henriques, totals.dose.0),
        (Limited::Cem43, totals.dose.1),
    ];
    against(limits, currents.chain(others))
}

/// Margins of limits that a guard knows were passed, most first, where no instrument measures currents: none unless a
/// wire was on for too long.
pub fn exceeded(guard: &Guard) -> Vec<Margin> {
    let Some(found) = guard.overrun() else {
        return Vec::new();
    };
    let skin = guard.predicted();
    let worst = [
        (Limited::Burst, found.on.as_micros() as f64 * 1e-3),
        (Limited::BurstEnergy, found.energy_nj as f64 * 1e-6),
        (Limited::SkinMean, skin.mean_c),
        (Limited::SkinPeak, skin.peak_c),
        (Limited::SkinDeep, skin.deep_c),
        (Limited::Henriques, skin.omega),
        (Limited::Cem43, skin.cem43_min),
    ];
    let mut all = against(guard.limits(), worst);
    all.retain(Margin::over);
    all
}

/// Electrical energy over time: straight between these instants.
struct Energy(Vec<(Nanos, f64)>);

impl Energy {
    fn new(flows: &[Flow], wanted: impl Fn(&Flow) -> bool) -> Self {
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
