//! The whole guard against its plainest form: each rule of the table as docs/guard.md says it, every line of the
//! ledger the same. Times and lengths are drawn at the boundaries of bursts and their gaps as often as anywhere.

use alloc::{vec, vec::Vec};

use proptest::prelude::*;

use super::plain_tests::Plain;
use super::power::{Bucket, Window};
use super::thermal::{Booking, Predicted};
use super::{Guard, HARD, Limits, Plant, WornWire};
use crate::illusion::DisplayWire;
use crate::schedule::{Entry, Reason, Stimulus};
use crate::units::{Board, Channel, Duration, Instant, Milliamps, Point, Prescale, Ticks};

/// Two on one board, one on another.
const BOARDS: [u8; 3] = [0, 0, 1];
/// At PRE_SCALE 30 and 23 MHz a period is 5521 us; the bus may take 1000 us.
const LATENCY_US: u64 = 2 * 5521 + 1000;
const SURPLUS_US: u64 = 5521 + 1000;

struct PlainWire {
    burst: Option<Burst>,
    power: Bucket,
    tissue: Plain,
    on: Option<(u16, u64)>,
}

#[derive(Clone, Copy)]
struct Burst {
    start: u64,
    spent_nj: u64,
    end: u64,
}

struct PlainGuard {
    limits: Limits,
    plant: Plant,
    wires: Vec<PlainWire>,
    fingertip: Bucket,
    predicted: Predicted,
}

impl PlainGuard {
    fn new(limits: Limits, plant: Plant) -> Self {
        let reach = limits.burst.as_micros() + LATENCY_US + SURPLUS_US;
        let bucket = |short_uw, long_s: u64, long_uw| {
            let window = |s: u64, mean_uw| Window {
                length: Duration::from_micros(s * 1_000_000),
                mean_uw,
            };
            Bucket::new(
                window(1, short_uw),
                window(long_s, long_uw),
                Duration::from_micros(reach),
            )
        };
        let wire = |_| PlainWire {
            burst: None,
            power: bucket(limits.wire_1s_uw, 10, limits.wire_10s_uw),
            tissue: Plain::new(&limits),
            on: None,
        };
        Self {
            wires: BOARDS.iter().map(wire).collect(),
            fingertip: bucket(limits.fingertip_1s_uw, 60, limits.fingertip_60s_uw),
            predicted: Predicted::REST,
            limits,
            plant,
        }
    }

    /// A pulse and the bus.
    fn slack(&self) -> u64 {
        self.limits.pulse_width_ns.div_ceil(1000) + 1000
    }

    /// When the next pulse of a wire begins a burst of its own.
    fn gap_end(&self, wire: usize) -> u64 {
        self.wires[wire]
            .burst
            .map_or(0, |b| b.end + 20_000 + self.slack())
    }

    fn burst(&self, wire: usize, at: u64) -> Burst {
        let none = Burst {
            start: at,
            spent_nj: 0,
            end: at,
        };
        let goes_on = at < self.gap_end(wire);
        self.wires[wire].burst.filter(|_| goes_on).unwrap_or(none)
    }

    /// When a burst with a pulse of this wire at `at` has to be over.
    fn latest(&self, wire: usize, at: u64) -> u64 {
        self.burst(wire, at).start + self.limits.burst.as_micros() - self.slack()
    }

    fn nj(&self, width: u16, span: u64) -> u64 {
        self.plant.energy_nj(width, Duration::from_micros(span))
    }

    fn booking(&self, wire: usize, at: u64, until: u64) -> Booking {
        let from = self.wires[wire].tissue.at.max(at + LATENCY_US);
        let until = (from + 1).max(until + SURPLUS_US + LATENCY_US);
        Booking {
            from: Instant::from_micros(from),
            until: Instant::from_micros(until),
        }
    }

    fn spend(&mut self, wire: usize, at: u64, until: u64, nj: u64) {
        let booking = self.booking(wire, at, until);
        let state = &mut self.wires[wire];
        state.power.spend(nj);
        self.fingertip.spend(nj);
        let felt = state.tissue.heat(booking, nj as f64 * 1e-9);
        self.predicted.raise(&felt);
    }

    fn switch_off(&mut self, at: u64, which: impl Fn(usize, u64) -> bool) {
        for wire in 0..self.wires.len() {
            let on = self.wires[wire].on;
            let Some((width, until)) = on.filter(|on| which(wire, on.1)) else {
                continue;
            };
            self.wires[wire].on = None;
            if at > until {
                let nj = self.nj(width, at - until);
                self.spend(wire, until, at, nj);
                let burst = self.wires[wire].burst.as_mut().unwrap();
                burst.spent_nj += nj;
                burst.end = at;
            }
        }
    }

    /// Width, end and reason of one stimulus.
    fn clamp(&mut self, wire: usize, at: u64, wish: Wish) -> (u16, u64, Option<Reason>) {
        let (mut width, mut until, mut reason) = (wish.width, wish.until, None);
        if width == 0 || until <= at {
            return (0, until, None);
        }
        // 31 periods of 23 MHz are 1,347,827 ps.
        let widest = (self.limits.pulse_width_ns * 1000 / 1_347_827) as u16;
        if width > widest {
            (width, reason) = (widest, Some(Reason::PulseWidth));
        }
        let burst = self.burst(wire, at);
        if until > self.latest(wire, at) {
            (until, reason) = (self.latest(wire, at), Some(Reason::Burst));
        }
        if until <= at {
            return (0, wish.until, Some(Reason::Burst));
        }
        let booking = self.booking(wire, at, until);
        let now = Instant::from_micros(at);
        let (heat, cause) = self.wires[wire].tissue.room(booking);
        // Of what fills again a burst takes three quarters.
        let faded = |left: u64| left - left.div_ceil(4);
        let rows = [
            (
                self.limits.burst_energy_nj.saturating_sub(burst.spent_nj),
                Reason::Burst,
            ),
            (faded((heat * 1e9) as u64), cause),
            (
                faded(self.wires[wire].power.left_nj(now)),
                Reason::WirePower,
            ),
            (faded(self.fingertip.left_nj(now)), Reason::FingertipPower),
        ];
        let (left, row) = *rows.iter().min_by_key(|row| row.0).unwrap();
        let asked = self.nj(width, until - at);
        if asked > left {
            let part = u128::from(width) * u128::from(left) / u128::from(asked);
            (width, reason) = (part as u16, Some(row));
        }
        if width > 0 {
            let nj = self.nj(width, until - at);
            self.spend(wire, at, until, nj);
            self.wires[wire].burst = Some(Burst {
                start: burst.start,
                spent_nj: burst.spent_nj + nj,
                end: until,
            });
            self.wires[wire].on = Some((width, until));
        }
        (width, until, reason)
    }
}

#[derive(Clone, Copy, Debug)]
struct Wish {
    width: u16,
    until: u64,
}

impl Wish {
    fn stimulus(self, wire: u16, at: u64) -> Stimulus {
        Stimulus {
            wire,
            width: Ticks::new(self.width),
            peak: Milliamps(1),
            at: Instant::from_micros(at),
            until: Instant::from_micros(self.until),
        }
    }
}

/// A time at a boundary of the burst rules, or anywhere.
#[derive(Clone, Copy, Debug)]
enum When {
    In(u64),
    /// As many microseconds beside the end of the first wire's gap, or before the end of its burst's time.
    Gap(i64),
    Latest(i64),
}

fn when() -> impl Strategy<Value = When> {
    prop_oneof![
        2 => Just(When::In(58_500)),
        2 => (0..80_000u64).prop_map(When::In),
        1 => (0..20_000_000u64).prop_map(When::In),
        2 => (-1..=1i64).prop_map(When::Gap),
    ]
}

fn length() -> impl Strategy<Value = When> {
    prop_oneof![
        2 => Just(When::In(35_000)),
        2 => (0..70_000u64).prop_map(When::In),
        1 => (-1..=1i64).prop_map(When::Latest),
    ]
}

#[derive(Clone, Debug)]
enum Act {
    Admit(u8, Vec<(u16, u16, When)>),
    Expire(u8),
    AllOff,
}

fn act() -> impl Strategy<Value = Act> {
    let width = prop_oneof![4 => 1..200u16, 1 => Just(0u16), 1 => 0..=4096u16];
    let wish = (0..3u16, width, length());
    prop_oneof![
        6 => (0..2u8, prop::collection::vec(wish, 0..4)).prop_map(|(b, w)| Act::Admit(b, w)),
        2 => (0..2u8).prop_map(Act::Expire),
        1 => Just(Act::AllOff),
    ]
}

fn limits() -> impl Strategy<Value = Limits> {
    let tissue = (33_200..=43_000u64, 33_200..=41_000u64, 33_200..=41_000u64);
    let power = (
        1_000..=45_000u64,
        500..=20_000u64,
        1_000..=110_000u64,
        500..=60_000u64,
    );
    let burst = (
        prop_oneof![Just(200_000u64), 30_000..200_000u64],
        5_000..=50_000u64,
        300_000..=10_000_000u64,
    );
    let tight = (tissue, power, burst).prop_map(|(tissue, power, burst)| Limits {
        skin_peak_mc: tissue.0,
        skin_mean_mc: tissue.1,
        skin_deep_mc: tissue.2,
        wire_1s_uw: power.0,
        wire_10s_uw: power.1,
        fingertip_1s_uw: power.2,
        fingertip_60s_uw: power.3,
        pulse_width_ns: burst.0,
        burst: Duration::from_micros(burst.1),
        burst_energy_nj: burst.2,
        ..HARD
    });
    prop_oneof![1 => Just(HARD), 3 => tight]
}

fn plant(milliamps: u32) -> Plant {
    Plant {
        prescale: Prescale::new(30),
        wire_milliohm: 1900,
        peak: Milliamps(milliamps),
        bus: Duration::ZERO,
    }
}

fn wires() -> Vec<DisplayWire> {
    let numbered = BOARDS.iter().zip(0..);
    let wire = |(board, n): (&u8, u8)| DisplayWire {
        place: Point::new(f32::from(n), 0.0),
        board: Board(*board),
        channel: Channel(n),
    };
    numbered.map(wire).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_ledger_is_what_the_rules_say(
        limits in limits(),
        milliamps in 400..=1970u32,
        acts in prop::collection::vec((when(), act()), 1..50),
    ) {
        let mut guard = Guard::new(limits, plant(milliamps), &wires(), WornWire::default()).unwrap();
        let mut plain = PlainGuard::new(limits, plant(milliamps));
        let mut now = 0;
        for (pause, act) in acts {
            let beside = |time: u64, by: i64| time.saturating_add_signed(by).max(now);
            now = match pause {
                When::In(us) => now + us,
                When::Gap(by) | When::Latest(by) => beside(plain.gap_end(0), by),
            };
            let at = Instant::from_micros(now);
            for (wire, by) in [(0, -1), (0, 0), (0, 1), (1, 0), (2, 1)] {
                let until = plain.latest(wire, now).saturating_add_signed(by);
                prop_assert_eq!(guard.has_time(wire, at, Instant::from_micros(until)), by <= 0);
            }
            prop_assert!(!guard.has_time(BOARDS.len(), at, at));
            match act {
                Act::Admit(board, wishes) => {
                    plain.switch_off(now, |wire, _| BOARDS[wire] == board);
                    let (mut stimuli, mut expected) = (vec![], vec![]);
                    for (wire, width, length) in wishes {
                        let index = usize::from(wire);
                        let latest = plain.latest(index, now);
                        let until = match length {
                            When::In(us) => now + us,
                            When::Latest(by) | When::Gap(by) => latest.saturating_add_signed(by),
                        };
                        let wish = Wish { width: Ticks::new(width).get(), until };
                        stimuli.push(wish.stimulus(wire, now));
                        if BOARDS[index] == board {
                            let (width, until, reason) = plain.clamp(index, now, wish);
                            expected.push((wire as u8, width, Instant::from_micros(until), reason));
                        }
                    }
                    let mut entries = vec![];
                    let said = |e: Entry| entries.push((e.channel.0, e.off - e.on, e.until, e.reason));
                    let update = guard.admit(at, Board(board), &stimuli, said);
                    guard.confirm(&update, at);
                    prop_assert_eq!(entries, expected);
                }
                Act::Expire(board) => {
                    plain.switch_off(now, |wire, until| BOARDS[wire] == board && until <= now);
                    let update = guard.expire(at, Board(board));
                    guard.confirm(&update, at);
                }
                Act::AllOff => {
                    plain.switch_off(now, |_, _| true);
                    guard.all_off(at);
                }
            }
            prop_assert_eq!(guard.predicted(), &plain.predicted);
            let next = plain.wires.iter().filter_map(|w| w.on).map(|on| on.1).min();
            prop_assert_eq!(guard.next_expiry(), next.map(Instant::from_micros));
        }
    }
}
