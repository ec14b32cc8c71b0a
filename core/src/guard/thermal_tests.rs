//! The budget's arithmetic against sums over its history, written out.

use alloc::vec::Vec;

use super::decays::{RATES, dot};
use super::kernel::REST_C;
use super::kernel::tests::{DEEP, SHALLOW, budget as final_budget};
use super::limits::{HARD, Limits};
use super::table;
use super::thermal::{Booking, Predicted, Tissue};
use crate::random::RandomStream;
use crate::schedule::Reason;
use crate::units::{Duration, Instant};

const fn us(us: u64) -> Instant {
    Instant::from_micros(us)
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * (1.0 + b.abs()), "{a} is not {b}");
}

/// Everything booked: (from, until, J).
#[derive(Default)]
struct History(Vec<(u64, u64, f64)>);

impl History {
    /// What `coefficients` make of it at `at`, K: integrals of decays, one by one.
    fn now(&self, coefficients: &[f64], at: u64) -> f64 {
        let mut sum = 0.0;
        for &(from, until, joules) in &self.0 {
            let (age, length) = ((at - until) as f64 * 1e-6, (until - from) as f64 * 1e-6);
            for (k, c) in coefficients.iter().enumerate() {
                let rate = table::SLOWEST * libm::exp2(k as f64);
                let mean = -libm::expm1(-rate * length) / (rate * length);
                sum += c * joules * mean * libm::exp(-rate * age);
            }
        }
        sum
    }

    /// Time integral of the shallow temperature from `since` to `at`, K s; no booking lies astride `since`.
    fn integral(&self, since: u64, at: u64) -> f64 {
        let mut sum = 0.0;
        for &(from, until, joules) in &self.0 {
            let length = (until - from) as f64 * 1e-6;
            for (k, c) in SHALLOW.iter().enumerate() {
                let rate = table::SLOWEST * libm::exp2(k as f64);
                let mean = -libm::expm1(-rate * length) / (rate * length);
                // Heat given off from its booking to the end of time, less what is still to come.
                let left = |t: u64| {
                    if t <= from {
                        1.0
                    } else {
                        mean * libm::exp(-rate * (t - until) as f64 * 1e-6)
                    }
                };
                sum += c * joules / rate * (left(since) - left(at));
            }
        }
        sum
    }
}

fn booking(from: u64, until: u64) -> Booking {
    Booking {
        from: us(from),
        until: us(until),
    }
}

#[test]
fn predictions_are_sums_over_history() {
    let mut budget = final_budget(&HARD);
    let (mut tissue, mut history, mut at) = (Tissue::new(REST_C), History::default(), 0);
    let mut s = RandomStream::new(1, "bookings");
    for round in 0..300 {
        // Pauses within a bin, over bins, over the window; ends on bins' edges too.
        let pause = match round % 5 {
            0 => s.next_u64() % 30_000_000,
            1 => 250_000 - at % 250_000,
            _ => s.next_u64() % 600_000,
        };
        let from = at + pause;
        let until = from + 1 + s.next_u64() % 300_000;
        let joules = 1e-3 * s.uniform();
        history.0.push((from, until, joules));
        let predicted = tissue.heat(&mut budget, booking(from, until), joules);
        at = until;
        close(
            predicted.peak_c,
            33.0 + table::LATENT_K[0] + history.now(&SHALLOW, at),
        );
        close(
            predicted.deep_c,
            33.0 + table::LATENT_K[2] + history.now(&DEEP, at),
        );
    }
}

#[test]
fn the_mean_is_the_windows_and_what_is_to_come() {
    let mut budget = final_budget(&HARD);
    for (bursts, pause) in [
        (1, 0),
        (3, 2_000_000),
        (60, 200_000),
        (12, 4_000_000),
        (3, 40_000_000),
    ] {
        let (mut tissue, mut history) = (Tissue::new(REST_C), History::default());
        let (mut at, mut predicted) = (0, Predicted::REST);
        for _ in 0..bursts {
            let from = at + pause;
            let until = from + 50_000;
            history.0.push((from, until, 5e-3));
            predicted = tissue.heat(&mut budget, booking(from, until), 5e-3);
            at = until;
        }
        // Windows end up to 10 s from now; between two looks the heat is the later one's, the past the earlier's.
        let mut most = 0.0f64;
        for ahead in [
            [0, 1],
            [1, 2],
            [2, 4],
            [4, 8],
            [8, 14],
            [14, 20],
            [20, 30],
            [30, 40],
        ] {
            let since = (at + ahead[0] * 250_000).saturating_sub(10_000_000) / 250_000 * 250_000;
            let past = history.integral(since, at);
            let future = history.integral(at, at + ahead[1] * 250_000);
            most = most.max((past + future) / 10.0);
        }
        close(predicted.mean_c, 33.0 + table::LATENT_K[1] + most);
    }
}

#[test]
fn the_room_leads_exactly_to_the_limit() {
    let cases = [
        (
            Limits {
                skin_peak_mc: 35_000,
                ..HARD
            },
            Reason::SkinPeak,
        ),
        (
            Limits {
                skin_deep_mc: 33_300,
                ..HARD
            },
            Reason::SkinDeep,
        ),
        (
            Limits {
                skin_mean_mc: 33_400,
                ..HARD
            },
            Reason::SkinMean,
        ),
    ];
    for (limits, reason) in cases {
        let mut budget = final_budget(&limits);
        let mut tissue = Tissue::new(REST_C);
        for (from, until) in [
            (10_000, 52_000),
            (300_000, 342_000),
            (9_000_000, 9_050_000),
            (40_000_000, 40_050_000),
        ] {
            let (room, cause) = tissue.room(&mut budget, booking(from, until));
            assert!(cause == reason && room > 0.0, "{cause:?} {room}");
            let reached = tissue.clone().heat(&mut budget, booking(from, until), room);
            let limit = |mc: u64| mc as f64 * 1e-3;
            match reason {
                Reason::SkinPeak => close(reached.peak_c, limit(limits.skin_peak_mc)),
                Reason::SkinDeep => close(reached.deep_c, limit(limits.skin_deep_mc)),
                _ => close(reached.mean_c, limit(limits.skin_mean_mc)),
            }
            tissue.heat(&mut budget, booking(from, until), 0.6 * room);
        }
        let (first, _) = tissue.room(&mut budget, booking(40_060_000, 40_100_000));
        tissue.heat(&mut budget, booking(40_060_000, 40_100_000), 2.0 * first);
        assert!(tissue.room(&mut budget, booking(40_100_000, 40_142_000)).0 < 0.0);
    }
}

#[test]
fn a_spent_dose_lowers_the_ceiling() {
    // A millisecond at 43 C: what is left is gone after little.
    let limits = Limits {
        dose_cem43_ms: 10,
        ..HARD
    };
    let mut budget = final_budget(&limits);
    let mut tissue = Tissue::new(REST_C);
    let (room, cause) = tissue.room(&mut budget, booking(0, 42_000));
    assert_eq!(cause, Reason::Dose);
    let reached = tissue.heat(&mut budget, booking(0, 42_000), room);
    // 10 ms in 60 s: 43 C less log4 of 6000.
    close(reached.peak_c, 43.0 - libm::log2(6000.0) / 2.0);
    assert!(reached.cem43_min > 0.0 && reached.omega > 0.0);
    let omega = Limits {
        dose_omega_ppm: 1,
        ..HARD
    };
    let mut budget = final_budget(&omega);
    let mut tissue = Tissue::new(REST_C);
    assert_eq!(tissue.room(&mut budget, booking(0, 42_000)).1, Reason::Dose);
}

#[test]
fn dose_adds_up_while_skin_cools() {
    let mut budget = final_budget(&HARD);
    let mut tissue = Tissue::new(REST_C);
    tissue.heat(&mut budget, booking(0, 42_000), 15e-3);
    let short = tissue
        .clone()
        .heat(&mut budget, booking(100_000, 100_001), 0.0);
    let long = tissue
        .clone()
        .heat(&mut budget, booking(60_000_000, 60_000_001), 0.0);
    assert!(long.omega > short.omega && long.cem43_min > short.cem43_min);
    // Rest alone: 2^-20 of a minute a minute, and a little for the latent allowance.
    let mut rest = Tissue::new(REST_C);
    let hour = rest.heat(&mut budget, booking(3_600_000_000, 3_600_000_001), 0.0);
    let expected = 60.0 * libm::exp2(2.0 * (REST_C + table::LATENT_K[0] - 43.0));
    assert!(
        (hour.cem43_min / expected - 1.0).abs() < 1e-6,
        "{}",
        hour.cem43_min
    );
}

#[test]
fn heat_is_booked_late_and_never_before_what_is_booked() {
    let mut budget = final_budget(&HARD);
    let latency = Duration::from_micros(12_000);
    let mut tissue = Tissue::new(REST_C);
    assert_eq!(
        tissue.booking(us(1_000), us(42_000), latency),
        booking(13_000, 54_000)
    );
    tissue.heat(&mut budget, booking(13_000, 54_000), 1e-3);
    assert_eq!(
        tissue.booking(us(50_000), us(60_000), latency),
        booking(62_000, 72_000)
    );
    assert_eq!(
        tissue.booking(us(30_000), us(60_000), latency),
        booking(54_000, 72_000)
    );
    assert_eq!(
        tissue.booking(us(30_000), us(40_000), latency),
        booking(54_000, 54_001)
    );
}

#[test]
fn a_run_after_others_goes_on_where_they_ended() {
    let mut budget = final_budget(&HARD);
    let (began_us, latency) = (7_000_000, Duration::from_micros(12_000));
    let mut whole = Tissue::new(REST_C);
    whole.heat(&mut budget, booking(0, 54_000), 1e-3);
    let mut next = whole.clone();
    next.begun = Duration::from_micros(began_us);
    for (on, off) in [(1_000, 42_000), (0, 0), (3_000_000, 9_000_000)] {
        assert_eq!(
            next.booking(us(on), us(off), latency),
            whole.booking(us(began_us + on), us(began_us + off), latency)
        );
    }
    // and has cooled since
    let later = whole.bears(&budget, us(began_us + 2_000_000), 1.0);
    assert_eq!(next.bears(&budget, us(2_000_000), 1.0), later);
    assert!(later.0.peak_c < whole.bears(&budget, us(54_000), 1.0).0.peak_c - 0.1);
}

#[test]
fn the_most_of_two_predictions_is_taken_row_by_row() {
    let high = Predicted {
        peak_c: 40.0,
        mean_c: 34.0,
        deep_c: 36.0,
        omega: 1.0,
        cem43_min: 0.0,
    };
    let mut most = Predicted {
        mean_c: 39.0,
        cem43_min: 2.0,
        ..Predicted::REST
    };
    most.raise(&high);
    let expected = Predicted {
        mean_c: 39.0,
        cem43_min: 2.0,
        ..high
    };
    assert_eq!(most, expected);
}

#[test]
fn the_end_of_time_is_no_trap() {
    let mut budget = final_budget(&HARD);
    let mut tissue = Tissue::new(REST_C);
    let end = tissue.booking(
        Instant::FAR_FUTURE,
        Instant::FAR_FUTURE,
        Duration::from_millis(12),
    );
    assert!(tissue.room(&mut budget, end).0.is_finite());
    assert!(tissue.heat(&mut budget, end, 1e-3).peak_c.is_finite());
}

/// What is booked late is booked hot only if a joule's warmth never rises again; and skin so deep holds it for a while
/// (tau = depth squared over diffusivity: 0.1 s at 0.1 mm, seconds at 0.4 mm).
#[test]
fn a_joules_warmth_never_rises_and_hardly_falls_at_first() {
    let wires = table::ROWS.iter().flatten();
    for (row, early_s) in wires.flat_map(|[shallow, deep]| [(shallow, 0.1), (deep, 1.0)]) {
        let warmth = |seconds: f64| {
            let left = RATES.map(|rate| libm::exp(-rate * seconds));
            dot(row, &left)
        };
        let (start, early) = (warmth(0.0), warmth(early_s));
        assert!(early < start && start < 1.2 * early, "{start} {early}");
        let mut before = start;
        for n in 1..600 {
            let now = warmth(1e-3 * libm::exp(0.02 * f64::from(n)));
            // the table has six digits
            assert!(
                0.0 < now && now <= before * 1.000_001,
                "{n}: {before} {now}"
            );
            before = now;
        }
    }
}

#[test]
fn of_limits_that_leave_the_same_the_first_is_the_reason() {
    // A minute at 43 C is left for the 60 s it has to last: the dose's ceiling is the peak's.
    let limits = Limits {
        dose_cem43_ms: 60_000,
        ..HARD
    };
    let booking = Booking {
        from: us(0),
        until: us(35_000),
    };
    let (_, reason) = Tissue::new(REST_C).room(&mut final_budget(&limits), booking);
    assert_eq!(reason, Reason::SkinPeak);
    let limits = Limits {
        dose_cem43_ms: 59_999,
        ..HARD
    };
    let (_, reason) = Tissue::new(REST_C).room(&mut final_budget(&limits), booking);
    assert_eq!(reason, Reason::Dose);
}

#[test]
fn power_that_flows_evenly_keeps_to_the_mean_at_either_depth() {
    let budget = final_budget(&HARD);
    // Of 41 C: a watt that warms by so many K leaves so much, by the depth that warms most.
    let (at_first, at_rest) = (budget.even_w(8.0, 1e-9), budget.even_w(1e-9, 8.0));
    close(budget.even_w(8.0, 4.0), at_first);
    close(budget.even_w(4.0, 8.0), at_rest);
    close(budget.even_w(8.0, 8.0), at_first.min(at_rest));
    for (even, about) in [(at_first, 1.0), (at_rest, 1.0)] {
        assert!(even > 0.7 * about && even <= about, "{even} W");
    }
}

#[test]
fn a_face_may_come_as_far_as_the_row_that_binds_first() {
    let (peak, mean, deep) = (43_000, 41_000, 41_000);
    for (binds, limits) in [
        ("peak", (36_000, mean, deep)),
        ("mean", (peak, 35_500, deep)),
        ("deep", (peak, mean, 35_000)),
    ] {
        let limits = Limits {
            skin_peak_mc: limits.0,
            skin_mean_mc: limits.1,
            skin_deep_mc: limits.2,
            ..HARD
        };
        let mut budget = final_budget(&limits);
        let mut tissue = Tissue::new(REST_C);
        tissue.heat(&mut budget, booking(0, 40_000), 1e-3);
        for face_k in [0.0, 1.0, 2.5] {
            let (predicted, left_k) = tissue.bears(&budget, us(45_000), face_k);
            // Of what is predicted with the face, the face is a part; the rest is what it leaves room for.
            let rows = [
                (predicted.peak_c, limits.skin_peak_mc),
                (predicted.mean_c, limits.skin_mean_mc),
                (predicted.deep_c, limits.skin_deep_mc),
            ];
            let left = rows.map(|(c, limit)| limit as f64 * 1e-3 - (c - face_k));
            let least = left.into_iter().fold(f64::INFINITY, f64::min);
            let index = ["peak", "mean", "deep"].iter().position(|b| *b == binds);
            close(left[index.unwrap()], least);
            close(left_k, least);
            assert!(
                predicted.peak_c > 33.0 + face_k && left_k > 0.0,
                "{predicted:?}"
            );
        }
    }
}
