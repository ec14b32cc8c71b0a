//! A guard that goes on from another one's memory is the guard that one long run would have.

use alloc::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::guard::{HARD, Plant, Used, WornWire};
use crate::illusion::DisplayWire;
use crate::schedule::Stimulus;
use crate::units::{Board, Channel, Milliamps, Point, Prescale, Ticks};

fn guard() -> Guard {
    let wire = |channel| DisplayWire {
        place: Point::new(f32::from(channel), 0.0),
        board: Board(0),
        channel: Channel(channel),
    };
    let plant = Plant {
        prescale: Prescale::new(30),
        wire_milliohm: 1900,
        peak: Milliamps(990),
        bus: Duration::ZERO,
    };
    Guard::new(HARD, plant, &[wire(0), wire(1)], WornWire::default()).unwrap()
}

const fn ms(ms: u64) -> Instant {
    Instant::from_micros(1000 * ms)
}

const fn span(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// Drives a burst; what was booked, if anything passed.
fn drive(guard: &mut Guard, at: Instant, wire: u16, width: u16) -> Option<(u16, Booked)> {
    let stimulus = Stimulus {
        wire,
        width: Ticks::new(width),
        peak: Milliamps(990),
        at,
        until: at + span(35),
    };
    let mut entry = None;
    let _ = guard.change(at, Board(0), &[stimulus], |e| entry = Some(e));
    let entry = entry?;
    let _ = guard.expire(entry.until, Board(0));
    let booked = guard.booked([&entry].into_iter()).next()?;
    (entry.width() > Ticks::ZERO).then_some((wire, booked))
}

/// The response of the table rises by less than this within a few milliseconds: shares of a limit.
const ROUNDING: f64 = 1e-5;

/// A guard that goes on from a memory.
fn from(memory: &Memory, at: Instant) -> Guard {
    let mut guard = guard();
    guard.remember(memory, at).unwrap();
    guard
}

/// A guard whose wire 0 was driven for a while, and when that was over.
fn warm(bursts: u64) -> (Guard, Instant) {
    let mut guard = guard();
    for n in 0..bursts {
        drive(&mut guard, ms(117 * n), 0, 60);
    }
    (guard, ms(117 * bursts))
}

/// Every row to the last bit.
fn bits(used: &Used) -> Vec<u64> {
    used.rows()
        .iter()
        .map(|(_, share)| share.to_bits())
        .collect()
}

/// The rows of heat and power, without those of what is on.
const fn heat(used: &Used) -> [f64; 7] {
    [
        used.wire_power,
        used.fingertip_power,
        used.skin_mean,
        used.skin_peak,
        used.skin_deep,
        used.omega,
        used.cem43,
    ]
}

prop_compose! {
    /// Gap before a burst, ms; wire; width.
    fn burst()(gap_ms in 60u64..900, wire in 0u16..2, width in 10u16..140) -> (u64, u16, u16) {
        (gap_ms, wire, width)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Guards one after the other, each from the memory of the one before, whatever their clocks show and however long the
    /// pause is, and one guard through all of them.
    #[test]
    fn what_is_remembered_is_what_one_long_run_has(
        runs in prop::collection::vec(
            (prop::collection::vec(burst(), 0..12), 0u64..20_000_000, 0u64..1_000_000_000_000, 0u64..100_000),
            1..6,
        ),
    ) {
        let mut whole = guard();
        let mut alone = guard();
        // The time of the whole run, and that of the one that goes on.
        let (mut long, mut short) = (Instant::ZERO, Instant::ZERO);
        for (bursts, pause_us, starts_us, later_us) in &runs {
            for (gap_ms, wire, width) in bursts {
                (long, short) = (long + span(*gap_ms), short + span(*gap_ms));
                let one = drive(&mut alone, short, *wire, *width);
                let other = drive(&mut whole, long, *wire, *width);
                let energy = |burst: Option<(u16, Booked)>| burst.map(|(_, b)| b.energy_nj);
                prop_assert_eq!(energy(one), energy(other));
            }
            let later = span(100) + Duration::from_micros(*later_us);
            (long, short) = (long + later, short + later);
            prop_assert_eq!(bits(&alone.used(short)), bits(&whole.used(long)));
            let pause = Duration::from_micros(*pause_us);
            let memory = alone.memory(short).after(Some(pause));
            (long, short) = (long + pause, Instant::from_micros(*starts_us));
            alone = from(&memory, short);
            prop_assert_eq!(bits(&alone.used(short)), bits(&whole.used(long)));
        }
    }

    /// The less time is known to have passed, the warmer; of an unknown time none.
    #[test]
    fn nothing_cools_in_a_time_that_is_not_known(
        bursts in prop::collection::vec(burst(), 1..40),
        mut elapsed_us in prop::array::uniform3(0u64..30_000_000),
    ) {
        let mut guard = guard();
        let mut at = Instant::ZERO;
        for (gap_ms, wire, width) in bursts {
            at += span(gap_ms);
            drive(&mut guard, at, wire, width);
        }
        at += span(50);
        let memory = guard.memory(at);
        prop_assert_eq!(memory.after(None), memory.clone());
        prop_assert_eq!(memory.after(Some(Duration::ZERO)), memory.clone());
        elapsed_us.sort_unstable();
        let after = |us: u64| {
            let later = memory.after(Some(Duration::from_micros(us)));
            from(&later, Instant::ZERO).used(Instant::ZERO)
        };
        let mut before = from(&memory, Instant::ZERO).used(Instant::ZERO);
        for us in elapsed_us {
            let used = after(us);
            let pairs = [
                (before.wire_power, used.wire_power),
                (before.fingertip_power, used.fingertip_power),
                (before.skin_peak, used.skin_peak),
                (before.skin_deep, used.skin_deep),
                (used.omega, before.omega),
                (used.cem43, before.cem43),
            ];
            prop_assert!(pairs.iter().all(|(more, less)| *more >= less - ROUNDING), "{:?} {:?}", before, used);
            before = used;
        }
    }

    /// A guard that is driven as hard as it goes, and one that goes on from what was reserved for it: whenever the program
    /// dies, and whenever the next one begins.
    #[test]
    fn a_reserve_lies_above_all_that_its_span_can_bring(
        before in prop::collection::vec(burst(), 0..40),
        within in prop::collection::vec((60u64..120, 0u16..2, 60u16..148), 1..60),
        span_ms in 500u64..5000,
        later_us in 200_000u64..20_000_000,
        starts_ms in 0u64..100_000,
    ) {
        let mut guard = guard();
        let mut at = Instant::ZERO;
        for (gap_ms, wire, width) in before {
            at += span(gap_ms);
            drive(&mut guard, at, wire, width);
        }
        if let Some(starts_ms) = starts_ms.checked_sub(50_000) {
            // The guard goes on from an earlier run.
            let memory = guard.memory(at + span(50));
            at = ms(starts_ms);
            guard = from(&memory, at);
        }
        let end = at + span(span_ms);
        let reserve = guard.reserve(at, span(span_ms));
        for (gap_ms, wire, width) in within {
            if at + span(gap_ms) > end {
                break;
            }
            at += span(gap_ms);
            drive(&mut guard, at, wire, width);
        }
        let later = Duration::from_micros(later_us);
        let reserved = from(&reserve.after(Some(later)), Instant::ZERO).used(Instant::ZERO);
        let true_one = guard.used(end + later);
        let mut pairs = heat(&reserved).into_iter().zip(heat(&true_one));
        prop_assert!(pairs.all(|(more, less)| more >= less - ROUNDING), "{:?} {:?}", reserved, true_one);
    }

    /// Bursts that are booked again come to what they came to.
    #[test]
    fn bursts_that_are_repeated_are_those_that_were_passed(
        bursts in prop::collection::vec(burst(), 1..40),
        began_ms in 0u64..100_000,
    ) {
        let mut first = guard();
        let (mut at, mut passed) = (ms(began_ms), Vec::new());
        for (gap_ms, wire, width) in bursts {
            at += span(gap_ms);
            passed.extend(drive(&mut first, at, wire, width));
        }
        let shift = span(began_ms);
        for (_, burst) in &mut passed {
            (burst.on, burst.off) = (burst.on - shift, burst.off - shift);
        }
        passed.reverse();
        let mut again = guard();
        let over = again.repeat(ms(began_ms), &passed);
        let last = passed.iter().map(|(_, b)| b.off + shift).max();
        prop_assert_eq!(over, last.unwrap_or(ms(began_ms)));
        at += span(100);
        // A burst that was refused has let tissue relax in two steps in place of one.
        let pairs = heat(&again.used(at)).into_iter().zip(heat(&first.used(at)));
        prop_assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 0.02), "{:?}", pairs);
    }
}

#[test]
fn heat_and_dose_of_earlier_runs_count() {
    let (first, end) = warm(200);
    let memory = first.memory(end);
    let (used, before) = (
        from(&memory, Instant::ZERO).used(Instant::ZERO),
        first.used(end),
    );
    assert_eq!(bits(&used), bits(&before));
    assert!(used.skin_mean > 0.3 && used.cem43 > 0.0, "{used:?}");
    let predicted = from(&memory, Instant::ZERO).predicted().peak_c;
    assert!(predicted > guard().predicted().peak_c + 1.0);
    let doses = memory.doses();
    assert_eq!(doses, memory.wires[0].doses);
    let share = |dose: f64, limit: f64| dose / limit;
    assert!(share(doses.omega, 0.01) <= used.omega && share(doses.cem43_min, 2.0) <= used.cem43);
    assert!(doses.omega > memory.wires[1].doses.omega);
    // An hour later skin is cold, and the dose is as it was.
    let later = from(&memory.after(Some(span(3_600_000))), Instant::ZERO);
    let rested = later.used(Instant::ZERO);
    assert!(
        rested.skin_mean < 0.02 && rested.wire_power < 1e-6,
        "{rested:?}"
    );
    assert!(rested.cem43 >= used.cem43, "{rested:?}");
    assert!(later.predicted().peak_c < guard().predicted().peak_c + 0.3);
    // A time that never ends is as long as thirty years.
    let always = memory.after(Some(Duration::from_micros(u64::MAX)));
    let rested = from(&always, ms(1)).used(ms(2));
    assert!(
        rested.skin_peak < 1e-9 && rested.fingertip_power < 1e-9,
        "{rested:?}"
    );
}

#[test]
fn power_of_an_earlier_run_counts() {
    let mut first = guard();
    for n in 0..20 {
        drive(&mut first, ms(30 * n), n as u16 % 2, 140);
    }
    let used = first.used(ms(600));
    let next = from(&first.memory(ms(600)), Instant::ZERO);
    assert_eq!(heat(&next.used(Instant::ZERO)), heat(&used));
    assert!(used.wire_power > 0.1 && used.fingertip_power > 0.02);
}

#[test]
fn nothing_cools_before_its_booking_is_over() {
    let (first, end) = warm(200);
    let mut memory = first.memory(end);
    let skin = |guard: &Guard, at: Instant| heat(&guard.used(at))[3];
    let (at, hot) = (ms(70_000), skin(&first, memory.wires[0].at));
    memory.wires[0].at += span(100_000);
    for ahead in [0, 1, 40, 10_000, 60_000].map(span) {
        memory.wires[0].now = memory.wires[0].at - ahead;
        let next = from(&memory, at);
        let over = at + ahead;
        assert_eq!([at, over].map(|time| skin(&next, time)), [hot; 2]);
        assert!(skin(&next, over + span(1000)) < hot);
    }
}

#[test]
fn a_memory_of_other_wires_keeps_to_those_that_are_there() {
    let (first, end) = warm(50);
    let memory = first.memory(end);
    let mut one = memory.clone();
    one.wires = memory.wires.iter().take(1).cloned().collect();
    let known = from(&one, Instant::ZERO);
    assert_eq!(bits(&known.used(Instant::ZERO)), bits(&first.used(end)));
    let mut three = memory.clone();
    let more = memory.wires.iter().chain(memory.wires.first()).cloned();
    three.wires = more.collect();
    assert_eq!(
        bits(&from(&three, Instant::ZERO).used(Instant::ZERO)),
        bits(&first.used(end))
    );
    let mut again = guard();
    let burst = Booked {
        on: Instant::ZERO,
        off: ms(35),
        energy_nj: 1_000_000,
    };
    assert_eq!(again.repeat(ms(7), &[(9, burst)]), ms(42));
    assert!(heat(&again.used(ms(42))).iter().all(|share| *share < 1e-6));
    // What has no thermal rows has power to remember.
    let plant = *first.plant();
    let wires = [0, 1].map(|channel| DisplayWire {
        place: Point::new(f32::from(channel), 0.0),
        board: Board(0),
        channel: Channel(channel),
    });
    let mut plain = Guard::last_word(HARD, plant, &wires, None).unwrap();
    plain.remember(&memory, Instant::ZERO).unwrap();
    let used = plain.used(Instant::ZERO);
    assert_eq!(
        used.wire_power.to_bits(),
        first.used(end).wire_power.to_bits()
    );
    let kept = plain.memory(Instant::ZERO);
    assert_eq!(kept.wires[0].power, memory.wires[0].power);
    assert_eq!(kept.doses(), Doses::default());
    let reserve = plain.reserve(Instant::ZERO, span(1000));
    assert_eq!(
        (reserve.wires[1].power, reserve.tip),
        (Spent::ALL, Spent::ALL)
    );
}

#[test]
fn a_warm_face_is_remembered() {
    let (mut first, end) = warm(20);
    let cold = first.used(end);
    first.warm(end, 36.0, 36.0);
    let memory = first.memory(end);
    assert!((memory.face_k - 3.0).abs() < 1e-12, "{}", memory.face_k);
    let mut next = from(&memory, Instant::ZERO);
    let used = next.used(Instant::ZERO);
    assert!(used.skin_peak > cold.skin_peak + 0.2, "{used:?} {cold:?}");
    let room =
        |guard: &Guard, at: Instant| guard.budget(0, at, at + span(35)).unwrap().energy_nj[1].1;
    // It leaves a burst no more than before, and counts for as long as in one run.
    assert_eq!(room(&next, Instant::ZERO), room(&first, end));
    next.warm(ms(13_000), 33.0, 33.0);
    let warm = room(&next, ms(13_500));
    next.warm(ms(15_000), 33.0, 33.0);
    assert!(room(&next, ms(15_500)) > warm);
}

#[test]
fn a_reserve_costs_what_a_moment_at_the_limit_does() {
    let fresh = guard();
    let reserve = fresh.reserve(ms(500), span(4000));
    let doses = reserve.doses();
    // Four seconds at 43 C, and the burst that is left on.
    let least = 4.0 / 60.0;
    assert!((least..1.1 * least).contains(&doses.cem43_min), "{doses:?}");
    let now = from(&reserve, Instant::ZERO);
    assert_eq!(now.budget(0, Instant::ZERO, ms(35)).unwrap().least().1, 0);
    // It cools from the limit: what the energies say above it is no dose.
    let later = from(&reserve.after(Some(span(20_000))), Instant::ZERO);
    let cem43_min = 2.0 * later.used(Instant::ZERO).cem43;
    assert!(
        (doses.cem43_min..2.0 * least).contains(&cem43_min),
        "{cem43_min}"
    );
    let (_, left) = later.budget(0, Instant::ZERO, ms(35)).unwrap().least();
    assert!(left > 1_000_000, "{left}");
    // Nor is a reserve of what goes on from one.
    let again = from(&reserve, Instant::ZERO).reserve(Instant::ZERO, span(4000));
    let most = 2.0 * 1.3 * least;
    assert!(
        (2.0 * least..most).contains(&again.doses().cem43_min),
        "{:?}",
        again.doses()
    );
    // The next heat counts with its own temperature again.
    let mut driven = from(&reserve.after(Some(span(20_000))), Instant::ZERO);
    drive(&mut driven, ms(100), 0, 60);
    assert_eq!(driven.memory(ms(200)).wires[0].most_c, None);
    assert!(driven.memory(ms(200)).wires[1].most_c.is_some());
}

#[test]
fn a_reserve_has_all_of_its_span_at_the_peak() {
    let later = from(&guard().memory(ms(3000)), ms(7000));
    let [fresh, later] = [(guard(), ms(500)), (later, ms(8000))].map(|(guard, at)| {
        let reserve = guard.reserve(at, span(4000));
        from(&reserve, Instant::ZERO).used(Instant::ZERO)
    });
    // Four seconds of the ten at 10 K less latent heat, of the 8 K of the mean; up to a bin more at either end.
    let share = |seconds: f64| seconds * 9.8 / 10.0 / 7.9;
    assert!((share(4.0)..share(4.6)).contains(&fresh.skin_mean));
    let mut pairs = heat(&fresh).into_iter().zip(heat(&later));
    assert!(pairs.all(|(a, b)| (a - b).abs() < ROUNDING));
}

#[test]
fn heat_beyond_all_limits_can_be_remembered() {
    let mut burnt = guard();
    let burst = Booked {
        on: Instant::ZERO,
        off: ms(5000),
        energy_nj: 20_000_000_000,
    };
    burnt.repeat(Instant::ZERO, &[(0, burst)]);
    let next = from(&burnt.memory(ms(5100)), Instant::ZERO);
    let used = next.used(Instant::ZERO);
    assert!(used.cem43 >= 1.0 && used.omega >= 1.0, "{used:?}");
    assert_eq!(next.budget(0, Instant::ZERO, ms(35)).unwrap().least().1, 0);
    let reserve = from(&next.reserve(Instant::ZERO, span(1000)), Instant::ZERO);
    assert!(reserve.used(Instant::ZERO).cem43 >= 1.0);
}

/// Something that a hostile hand may have written.
type Change = fn(&mut Memory, f64);

#[test]
fn figures_that_no_guard_has_are_refused() {
    let (first, end) = warm(20);
    let memory = first.memory(end);
    let changes: [Change; 6] = [
        |memory, x| memory.wires[0].energy_j[13] = x,
        |memory, x| memory.wires[1].bins_ks[40] = x,
        |memory, x| memory.wires[0].doses.omega = x,
        |memory, x| memory.wires[1].doses.cem43_min = x,
        |memory, x| memory.wires[0].most_c = Some(x),
        |memory, x| memory.face_k = x,
    ];
    let hostile = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        -1e-9,
        -1.0,
        1.1e6,
        f64::MAX,
    ];
    for (number, change) in changes.iter().enumerate() {
        for x in hostile {
            let mut bad = memory.clone();
            change(&mut bad, x);
            let mut guard = guard();
            assert_eq!(
                guard.remember(&bad, Instant::ZERO),
                Err(MemoryError),
                "{number} {x}"
            );
            assert!(
                heat(&guard.used(Instant::ZERO))
                    .iter()
                    .all(|share| *share < 1e-6)
            );
        }
        let mut good = memory.clone();
        change(&mut good, 1.0);
        assert_eq!(guard().remember(&good, Instant::ZERO), Ok(()), "{number}");
    }
    for (ahead_ms, is_good) in [(60_000, true), (60_001, false), (u64::MAX / 1000, false)] {
        let mut memory = memory.clone();
        let wire = &mut memory.wires[0];
        wire.at = wire.now + span(ahead_ms);
        assert_eq!(
            guard().remember(&memory, Instant::ZERO).is_ok(),
            is_good,
            "{ahead_ms}"
        );
    }
    // Any times and any power can be had.
    let mut strange = memory;
    strange.tip.pj = u64::MAX;
    strange.wires[0].power.ago = Duration::from_micros(u64::MAX);
    (strange.wires[0].now, strange.wires[0].at) = (Instant::FAR_FUTURE, Instant::FAR_FUTURE);
    (strange.wires[1].now, strange.wires[1].at) = (Instant::FAR_FUTURE, Instant::ZERO);
    let used = from(&strange, ms(1)).used(ms(1));
    assert!((used.fingertip_power - 1.0).abs() < 1e-12, "{used:?}");
}
