//! What is quick in the guard, bit by bit against its plainest form.

use alloc::vec::Vec;

use proptest::prelude::*;

use super::decays::{Decays, RATES, Stretch, dot};
use super::dose::{Dose, Doses};
use super::kernel::REST_C;
use super::kernel::tests::budget;
use super::kernel::tests::{DEEP, SHALLOW};
use super::limits::{HARD, Limits};
use super::table::LATENT_K;
use super::thermal::{Booking, Predicted, Tissue};
use super::{Guard, Plant, Running, Setting, WornWire};
use crate::illusion::DisplayWire;
use crate::schedule::{Reason, stagger};
use crate::units::{Board, Channel, Instant, Milliamps, Point, Prescale, Ticks};

const BIN_US: u64 = 250_000;
const WINDOW_US: u64 = 10_000_000;
const AHEAD: [u64; 8] = [1, 2, 4, 8, 14, 20, 30, 40];

/// Skin under one wire: bins by absolute time in a ring, every stretch computed anew, one sum after the other,
/// and the dose's ceiling every time.
pub(super) struct Plain {
    limits: Limits,
    pub(super) at: u64,
    energy: Decays,
    bins: [f64; 41],
    dose: Dose,
}

impl Plain {
    pub(super) fn new(limits: &Limits) -> Self {
        Self {
            limits: *limits,
            at: 0,
            energy: [0.0; 14],
            bins: [0.0; 41],
            dose: Dose::new(REST_C + LATENT_K[0]),
        }
    }

    pub(super) fn room(&mut self, booking: Booking) -> (f64, Reason) {
        self.relax(booking.from.as_micros());
        let stretch = Stretch::new(booking.until.since(booking.from));
        let old = stretch.end(&self.energy, 0.0);
        let kelvin = |mc: u64, latent: f64| mc as f64 * 1e-3 - REST_C - latent;
        let dose = Doses {
            omega: self.limits.dose_omega_ppm as f64 * 1e-6,
            cem43_min: self.limits.dose_cem43_ms as f64 / 60_000.0,
        };
        let ceiling_k = self.dose.ceiling_c(&dose) - REST_C - LATENT_K[0];
        let mut rows = Vec::new();
        for (limit_k, reason, row) in [
            (
                kelvin(self.limits.skin_peak_mc, LATENT_K[0]),
                Reason::SkinPeak,
                &SHALLOW,
            ),
            (ceiling_k, Reason::Dose, &SHALLOW),
            (
                kelvin(self.limits.skin_deep_mc, LATENT_K[2]),
                Reason::SkinDeep,
                &DEEP,
            ),
        ] {
            let room = (limit_k - dot(row, &old)) / dot(row, &stretch.kept);
            rows.push((room, reason));
        }
        let mean_k = kelvin(self.limits.skin_mean_mc, LATENT_K[1]);
        let so_far = stretch.integral(&SHALLOW, &self.energy, 0.0);
        let burst = stretch.integral(&SHALLOW, &[0.0; 14], 1.0);
        for (n, past) in self.pasts(booking.until.as_micros()).iter().enumerate() {
            let spent = past + so_far + dot(&ahead(n), &old);
            let more = burst + dot(&ahead(n), &stretch.kept);
            rows.push(((mean_k * 10.0 - spent) / more, Reason::SkinMean));
        }
        let least = |a: (f64, Reason), b: (f64, Reason)| if b.0 < a.0 { b } else { a };
        rows.into_iter().reduce(least).unwrap()
    }

    pub(super) fn heat(&mut self, booking: Booking, joules: f64) -> Predicted {
        self.relax(booking.from.as_micros());
        let until = booking.until.as_micros();
        let all = booking.until.since(booking.from).as_secs_f64();
        while self.at < until {
            let end = until.min((self.at / BIN_US + 1) * BIN_US);
            let span = Instant::from_micros(end).since(Instant::from_micros(self.at));
            self.step(end, joules * (span.as_secs_f64() / all));
        }
        let pasts = self.pasts(until);
        let means = (0..8).map(|n| pasts[n] + dot(&ahead(n), &self.energy));
        Predicted {
            peak_c: REST_C + LATENT_K[0] + dot(&SHALLOW, &self.energy),
            mean_c: REST_C + LATENT_K[1] + means.fold(0.0, f64::max) / 10.0,
            deep_c: REST_C + LATENT_K[2] + dot(&DEEP, &self.energy),
            omega: self.dose.omega,
            cem43_min: self.dose.cem43_min,
        }
    }

    fn relax(&mut self, to: u64) {
        let recent = to.saturating_sub(WINDOW_US + BIN_US);
        let mut stride = BIN_US;
        if self.at < recent {
            self.bins = [0.0; 41];
        }
        while self.at < recent {
            self.pass(recent.min(self.at + stride), 0.0);
            stride *= 2;
        }
        while self.at < to {
            self.step(to.min((self.at / BIN_US + 1) * BIN_US), 0.0);
        }
    }

    fn step(&mut self, until: u64, joules: f64) {
        let bin = (self.at / BIN_US) as usize % 41;
        if self.at.is_multiple_of(BIN_US) {
            self.bins[bin] = 0.0;
        }
        let span = Instant::from_micros(until).since(Instant::from_micros(self.at));
        self.bins[bin] += Stretch::new(span).integral(&SHALLOW, &self.energy, joules);
        self.pass(until, joules);
    }

    fn pass(&mut self, until: u64, joules: f64) {
        let stretch =
            Stretch::new(Instant::from_micros(until).since(Instant::from_micros(self.at)));
        self.energy = stretch.end(&self.energy, joules);
        self.at = until;
        let shallow_c = REST_C + LATENT_K[0] + dot(&SHALLOW, &self.energy);
        if joules > 0.0 {
            self.dose.heat(shallow_c, stretch.seconds);
        } else {
            self.dose.relax(shallow_c, stretch.seconds);
        }
    }

    fn pasts(&self, until: u64) -> [f64; 8] {
        core::array::from_fn(|n| {
            let looked = if n == 0 { 0 } else { AHEAD[n - 1] * BIN_US };
            let first = (until + looked).saturating_sub(WINDOW_US) / BIN_US;
            let bins = (first..self.at.div_ceil(BIN_US)).rev();
            bins.fold(0.0, |sum, bin| sum + self.bins[bin as usize % 41])
        })
    }
}

/// Time integral of each decay of the shallow response until a look ahead, K s/J.
fn ahead(n: usize) -> Decays {
    let seconds = (AHEAD[n] * BIN_US) as f64 * 1e-6;
    core::array::from_fn(|k| SHALLOW[k] / RATES[k] * (1.0 - libm::exp(-RATES[k] * seconds)))
}

/// Spans that matter: one bin, a window, the gap of a cadence, and anything.
fn pause_us() -> impl Strategy<Value = u64> {
    prop_oneof![
        Just(0),
        Just(17_000),
        Just(BIN_US),
        0..600_000u64,
        0..30_000_000u64
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_budget_decides_and_predicts_the_same_bits(
        (peak, mean, deep) in (33_400..=43_000u64, 33_200..=41_000u64, 33_200..=41_000u64),
        (omega, cem43) in (prop_oneof![Just(10_000u64), 0..50u64], prop_oneof![Just(120_000u64), 0..100_000u64]),
        bursts in prop::collection::vec((pause_us(), 1..300_000u64, 0.0..1.2f64), 1..60),
    ) {
        let limits = Limits {
            skin_peak_mc: peak,
            skin_mean_mc: mean,
            skin_deep_mc: deep,
            dose_omega_ppm: omega,
            dose_cem43_ms: cem43,
            ..HARD
        };
        let (mut budget, mut tissue, mut plain) = (budget(&limits), Tissue::new(REST_C), Plain::new(&limits));
        let mut at = 0;
        for (pause, length, part) in bursts {
            let from = at + pause;
            at = from + length;
            let booking = Booking { from: Instant::from_micros(from), until: Instant::from_micros(at) };
            let (room, reason) = tissue.room(&mut budget, booking);
            let (plain_room, plain_reason) = plain.room(booking);
            prop_assert_eq!((room.to_bits(), reason), (plain_room.to_bits(), plain_reason));
            let joules = (part * room).clamp(0.0, 0.02);
            let bits = |p: Predicted| [p.peak_c, p.mean_c, p.deep_c, p.omega, p.cem43_min].map(f64::to_bits);
            prop_assert_eq!(bits(tissue.heat(&mut budget, booking, joules)), bits(plain.heat(booking, joules)));
        }
    }

    /// Against a count of what is on at every tick of a period where a pulse can begin or end.
    #[test]
    fn the_supply_bears_what_a_count_says(
        supply in 0..9_000u32,
        wishes in prop::collection::vec((0..10usize, 1..=128u16, prop::bool::weighted(0.8)), 1..40),
    ) {
        let place = |i: u8| DisplayWire {
            place: Point::new(f32::from(i), 0.0),
            board: Board(i % 3),
            channel: Channel(5 * i % 16),
        };
        let wires: Vec<DisplayWire> = (0..10).map(place).collect();
        let plant = Plant { prescale: Prescale::MIN, wire_milliohm: 1900, peak: Milliamps(1000), bus: crate::units::Duration::ZERO };
        let limits = Limits { supply: Milliamps(supply), ..HARD };
        let mut guard = Guard::new(limits, plant, &wires, WornWire::default()).unwrap();
        for (index, width, drive) in wishes {
            let was = guard.wires[index].now.take();
            if !drive {
                continue;
            }
            // The wire's own pulse may still be on when a wish comes: it is replaced.
            guard.wires[index].now = was;
            let (on, off) = stagger(wires[index].channel, Ticks::new(16 * width));
            let setting = Setting { on, off };
            let bears = guard.supply_bears(index, setting);
            guard.wires[index].now = Some(Running { setting, since: Instant::ZERO, until: Instant::ZERO });
            let on_at = |board: u8, tick: u16| {
                let there = guard.wires.iter().filter(|w| w.place.0 == Board(board)).filter_map(|w| w.now);
                there.filter(|now| (now.setting.on..now.setting.off).contains(&tick)).count()
            };
            let most_on = |board| (0..256).map(|tick| on_at(board, 16 * tick)).max();
            let most: usize = (0..3).filter_map(most_on).sum();
            prop_assert_eq!(bears, most as u64 * 1000 <= u64::from(supply));
            if !bears {
                guard.wires[index].now = was;
            }
        }
    }
}

#[test]
fn pulses_are_apart_when_one_ends_where_the_other_begins() {
    let pulse = |on, off| Setting { on, off };
    for (a, b, apart) in [
        ((0, 100), (100, 200), true),
        ((0, 101), (100, 200), false),
        ((0, 300), (100, 200), false),
        ((0, 50), (100, 200), true),
    ] {
        let (a, b) = (pulse(a.0, a.1), pulse(b.0, b.1));
        assert_eq!((a.is_apart(&b), b.is_apart(&a)), (apart, apart));
    }
}
