//! Tests of `plant.rs`.

use super::*;
use crate::units::Clock;

const PLANT: Plant = Plant {
    prescale: Prescale::new(30),
    wire_milliohm: 1900,
    peak: Milliamps(1970),
    bus: Duration::ZERO,
};

#[test]
fn times_are_those_of_the_slowest_oscillator() {
    // 31 / 23 MHz = 1.3478 us; 4096 of them are 5.5207 ms.
    assert_eq!(PLANT.tick_ps(), 1_347_827);
    assert_eq!(PLANT.period().as_micros(), 5521);
    assert_eq!(PLANT.surplus().as_micros(), 6521);
    assert_eq!(PLANT.latency().as_micros(), 12_042);
}

#[test]
fn the_widest_pulse_is_never_a_period() {
    for (ns, ticks) in [
        (0, 0),
        (1_347, 0),
        (1_348, 1),
        (200_000, 148),
        (u64::MAX, 4095),
    ] {
        assert_eq!(PLANT.widest(ns), ticks, "{ns} ns");
    }
}

#[test]
fn energy_is_that_of_the_most_pulses_any_oscillator_fits_in() {
    // I^2 R / 4096 of a tick's width: 7.373_710 W / 4096.
    let watts = 7.373_71 / 4096.0;
    // 36 ms are 6.52 slowest periods: 7 of 5.521 ms, or 8 of at most 36 / 7 ms.
    for (span_us, on_us) in [
        (35_000, 41_143),
        (5_521, 11_042),
        (4_521, 11_042),
        (4_520, 11_040),
        (10_100, 16_563),
        (0, 5_521),
    ] {
        let exact = watts * 100.0 * f64::from(on_us) * 1e3;
        let counted = PLANT.energy_nj(100, Duration::from_micros(span_us)) as f64;
        assert!(
            (counted - exact).abs() < 2.0 + 1e-6 * exact,
            "{span_us}: {counted} {exact}"
        );
    }
    assert_eq!(PLANT.energy_nj(0, Duration::from_millis(35)), 0);
    // Full on for a quarter of an hour: beyond what one multiplication holds.
    let long = PLANT.energy_nj(4096, Duration::from_micros(1_000_000_000)) as f64;
    assert!((long / 7_373.71e9 - 1.0).abs() < 1e-4, "{long}");
    assert_eq!(
        PLANT.energy_nj(4096, Duration::from_micros(u64::MAX)),
        u64::MAX / 4
    );
}

/// Counted one by one over oscillators and phases.
#[test]
fn no_oscillator_and_no_phase_delivers_more() {
    for span_us in (500..50_000).step_by(499) {
        let counted = PLANT.energy_nj(4096, Duration::from_micros(span_us));
        for hz in (23_000_000..=27_400_000).step_by(20_000) {
            let period_us = 4096.0 * 31.0 / f64::from(hz) * 1e6;
            let starts = libm::floor((span_us + 1000) as f64 / period_us) + 1.0;
            let delivered = 7.373_71 * starts * period_us * 1e3;
            assert!(delivered <= counted as f64 + 1.0, "{span_us} us at {hz} Hz");
        }
    }
}

/// 25 MHz within 100 ppm on EXTCLK.
fn clocked(ppm: u32) -> Plant {
    let clock = Clock::external(25_000_000, ppm).unwrap();
    Plant {
        prescale: PLANT.prescale.with_clock(clock),
        ..PLANT
    }
}

#[test]
fn a_stated_clock_counts_whole_periods_and_no_more() {
    let plant = clocked(100);
    // 31 / 24.9975 MHz; 4096 of them are 5.07955 ms. The widest pulse of 200 us has 161 ticks instead of 148.
    assert_eq!(plant.tick_ps(), 1_240_125);
    assert_eq!(
        (plant.period().as_micros(), plant.shortest_us()),
        (5080, 5078)
    );
    assert_eq!(plant.widest(200_000), 161);
    for pulses in 1..=9 {
        let span = plant.prescale.counted(Duration::from_micros(5079 * pulses));
        let exact = 7_373.71 * 5.079_04 * 100.0 / 4096.0 * pulses as f64 * 1e3;
        let counted = plant.energy_nj(100, span) as f64;
        // Exact but for the tolerance and for the whole microseconds of a period.
        assert!(
            (1.0..1.0003).contains(&(counted / exact)),
            "{counted} {exact}"
        );
        assert!(PLANT.energy_nj(100, span) as f64 > 1.08 * exact, "{pulses}");
    }
    // A tolerance as wide as the oscillator's own lets one more in.
    let loose = clocked(Clock::MOST_PPM);
    let span = loose.prescale.counted(Duration::from_millis(35));
    // 34.013 ms take eight of 34.013 / 7 ms.
    let on_us = 38_872_u64;
    let booked = (1970 * 1970 * 1900 * on_us * 100).div_ceil(4096 * 1_000_000);
    assert_eq!(loose.energy_nj(100, span), booked);
}

/// Counted one by one over clocks within the tolerance, and phases; what is late counts once.
#[test]
fn no_clock_within_its_tolerance_and_no_phase_delivers_more() {
    for ppm in [0, 100, 5_000, 30_000, Clock::MOST_PPM] {
        let plant = clocked(ppm);
        for span_us in (500..50_000).step_by(499) {
            let span = Duration::from_micros(span_us);
            let counted = plant.energy_nj(4096, span);
            let late = Duration::from_micros(span_us / 7);
            let whole = plant.energy_nj(4096, span + late);
            assert_eq!(
                counted + plant.late_nj(4096, span, late),
                whole.max(counted)
            );
            for off in [-1.0, -0.5, 0.0, 0.3, 0.7, 0.99, 1.0] {
                let hz = 25e6 * (1.0 + off * f64::from(ppm) * 1e-6);
                let period_us = 4096.0 * 31.0 / hz * 1e6;
                let starts = libm::floor((span_us + 1000) as f64 / period_us) + 1.0;
                let delivered = 7_373.71 * starts * period_us;
                assert!(delivered <= counted as f64 + 1.0, "{span_us} us at {hz} Hz");
            }
        }
    }
}

#[test]
fn implausible_plants_are_refused() {
    for (wire_milliohm, peak, good) in [
        (1, 1, true),
        (1_000_000, 100_000, true),
        (0, 1, false),
        (1_000_001, 1, false),
        (1, 0, false),
        (1, 100_001, false),
    ] {
        let plant = Plant {
            wire_milliohm,
            peak: Milliamps(peak),
            ..PLANT
        };
        assert_eq!(plant.check().is_ok(), good);
    }
    assert!(alloc::format!("{}", PlantError::OutOfRange).contains("1 to 100000 mA"));
}

/// On a bus that other displays use, a channel may be on for as much longer as their transfers take.
#[test]
fn transfers_of_others_on_the_bus_count_as_time_on() {
    let bus = Duration::from_micros(1580);
    let shared = Plant { bus, ..PLANT };
    assert_eq!(shared.surplus(), PLANT.surplus() + bus);
    assert_eq!(shared.latency(), PLANT.latency() + bus);
    let span = Duration::from_millis(35);
    assert_eq!(
        shared.energy_nj(100, span),
        PLANT.energy_nj(100, span + bus)
    );
}

#[test]
fn of_two_plants_the_worse_has_what_heats_more_of_each() {
    let cold = Plant {
        prescale: Prescale::new(92),
        wire_milliohm: 2500,
        peak: Milliamps(990),
        bus: Duration::from_millis(2),
    };
    let worse = Plant {
        wire_milliohm: 2500,
        bus: Duration::from_millis(2),
        ..PLANT
    };
    assert_eq!(PLANT.worse(&cold), worse);
    // The divider is the first's: it is its boards that count.
    let prescale = cold.prescale;
    assert_eq!(cold.worse(&PLANT), Plant { prescale, ..worse });
}
