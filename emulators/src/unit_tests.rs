//! Tests of `unit.rs`: a unit with a chip, a host far away, and jitter.

use palpate_core::codec::link::MOST;
use palpate_core::driver::{Actuators, UnitDriver, UnitSettings};
use palpate_core::guard::{Guard, HARD, Plant, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::random::RandomStream;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Channel, Duration, Milliamps, Point, Ticks};

use super::*;
use crate::display::i2c::{BusClock, I2cSegment};
use crate::display::pca9685::{Config, Pca9685, Pin};

const KEY: [u8; 32] = [4; 32];
const DELAY: Duration = Duration::from_millis(20);

#[test]
fn a_crystal_shows_what_it_will_show() {
    for ppm in [-1000, -100, 0, 100, 1000] {
        let crystal = Crystal { ppm };
        for ns in [0, 1, 999, 1_000_000_007, 86_400_000_000_000] {
            let shown = crystal.shows(Nanos(ns));
            let when = crystal.when(shown);
            assert!(
                when <= Nanos(ns) && crystal.shows(when) == shown,
                "{ppm} {ns}"
            );
        }
    }
}

/// Onsets a second apart, over ways with `jitter_us`; how late each one's first edge is, us.
fn lateness(jitter_us: u32, ppm: i32, seed: u64) -> Vec<i64> {
    let wires = [DisplayWire {
        place: Point::new(0.0, 0.0),
        board: Board(0),
        channel: Channel(0),
    }];
    let bus = I2cHandle::new(I2cSegment::new(
        BusClock::Fast,
        vec![Pca9685::new(Config::new(0x40))],
    ));
    let settings = Settings {
        key: &KEY,
        boot: seed,
        wires: &wires,
        addresses: &[0x40],
        limits: HARD,
        plant: Plant::default(),
        worn: None,
        converters: None,
    };
    let profile = Profile {
        delay_us: [2000, jitter_us / 2, jitter_us, jitter_us, 2000 + jitter_us]
            .map(|us| us.max(2000)),
        loss_ppm: 10_000,
        burst: 1.0,
        twice_ppm: 10_000,
    };
    let lines = (bus.clone(), OeLine(bus.clone()));
    let mut unit = EmulatedUnit::new(&settings, lines, (profile, Crystal { ppm }), seed).unwrap();
    let mut driver = UnitDriver::new(
        &KEY,
        seed,
        UnitSettings {
            delay: DELAY,
            resumes: true,
        },
    );
    let mut guard = Guard::new(HARD, Plant::default(), &wires, WornWire::default()).unwrap();
    let mut dice = RandomStream::new(seed, "onsets");
    let (mut late, mut expected, mut onset) = (Vec::new(), None, 1_000_000);
    for ms in 0..30_000u64 {
        let now = Instant::from_micros(1000 * ms);
        // The unit ends its stimuli by itself; the host's guard is told when, so that it books no more.
        guard.expire(now, Board(0));
        if now.as_micros() >= onset {
            let stimulus = Stimulus {
                wire: 0,
                width: Ticks::new(100),
                peak: Milliamps(990),
                at: now,
                until: now + Duration::from_millis(35),
            };
            guard.hear(now);
            let update = guard.admit(now, Board(0), &[stimulus], |_| ());
            driver.apply(&update).unwrap();
            expected = Some(now + DELAY);
            onset += 900_000 + dice.next_u64() % 100_000;
        }
        let mut buffer = [0; MOST];
        if let Some(datagram) = driver.datagram(now, Some(now), &mut buffer) {
            unit.send(Nanos::from(now), datagram);
        }
        let until = Nanos::from(now) + Nanos::from_micros(1000);
        loop {
            let at = unit.next().min(until);
            let mut seen = |_: usize, edge: crate::display::pca9685::Edge| {
                if edge.pin == Pin::High
                    && let Some(expected) = expected.take()
                {
                    late.push(edge.at.as_micros() as i64 - expected.as_micros() as i64);
                }
            };
            bus.with(|segment| segment.advance(at, &mut seen)).unwrap();
            if at == until {
                break;
            }
            unit.run(at);
            while let Some(mut datagram) = unit.hear(at) {
                let _ = driver.hear(Instant::from_micros(at.as_micros()), &mut datagram);
            }
        }
    }
    assert_eq!(unit.unit().counts().limited, 0);
    late
}

#[test]
fn with_10_ms_of_jitter_a_pulse_is_at_most_a_period_late() {
    for (seed, ppm) in [(1, 100), (2, -100), (3, 0)] {
        let late = lateness(10_000, ppm, seed);
        assert!(late.len() > 25, "{}", late.len());
        // A chip's outputs change with its period, 5.08 ms, which begins with a first pulse; the clock is known to half of
        // what two ways differ by.
        assert!(
            late.iter().all(|us| (-5080..=5080).contains(us)),
            "{late:?}"
        );
    }
}
