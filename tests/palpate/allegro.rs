//! The bus arithmetic of an Allegro hand: 15 boards, 240 taxels, 24,000 frames a second.

use std::collections::BTreeMap;

use palpate_core::bus::CanBus;
use palpate_core::codec::uskin::{ALL_BOARDS, Command};
use palpate_core::units::Point;
use palpate_emulators::sensor::board::{BoardConfig, Overload};
use palpate_emulators::sensor::rig::{Handle, SkinBus};
use palpate_emulators::sensor::{EmulatedModule, ModuleConfig, Press};
use palpate_emulators::time::Nanos;

/// The hand's boards spread over `buses`, each pressed by a sphere, started by one command a bus.
fn hand(buses: usize, overload: Overload, phase_us: impl Fn(u8) -> u64) -> Handle {
    let mut hand: Vec<_> = (0..buses).map(|_| SkinBus::new(1_000_000)).collect();
    for n in 0..15u8 {
        let mut module = EmulatedModule::new(ModuleConfig {
            number: usize::from(n),
            seed: 1,
            ..ModuleConfig::default()
        });
        module.touch(Box::new(|now: Nanos, out: &mut Vec<Press>| {
            let x = 5.0 * libm::sin(now.as_secs_f64()) as f32;
            out.push(Press {
                at: Point::new(x, 0.0),
                force_n: 1.0,
                diameter_mm: 19.45,
            });
        }));
        let config = BoardConfig {
            address: n,
            overload,
            phase: Nanos::from_micros(phase_us(n)),
            ..BoardConfig::default()
        };
        hand[usize::from(n) % buses]
            .add_board(config, vec![module])
            .unwrap();
    }
    let mut handle = Handle::new(hand);
    let start = Command {
        board: ALL_BOARDS,
        start: true,
    }
    .encode()
    .unwrap();
    for bus in 0..buses {
        handle.transmit(bus as u8, &start).unwrap();
    }
    handle
}

/// Refresh rate of each identifier over `seconds`, Hz, and the mean load of the buses.
fn rates(handle: &mut Handle, seconds: u64) -> (BTreeMap<u16, f64>, f64) {
    let mut counts = BTreeMap::new();
    for ms in (0..=seconds * 1000).step_by(10) {
        handle.advance(Nanos::from_micros(ms * 1000));
        while let Some(received) = handle.receive().unwrap() {
            *counts.entry(received.frame.id()).or_insert(0u32) += 1;
        }
    }
    let load = handle.with(|buses| {
        assert!(buses.iter().all(|b| b.segment().overflows(b.host()) == 0));
        buses.iter().map(|b| b.segment().load()).sum::<f64>() / buses.len() as f64
    });
    let rate = |n: u32| f64::from(n) / seconds as f64;
    (
        counts.into_iter().map(|(id, n)| (id, rate(n))).collect(),
        load,
    )
}

#[test]
fn one_bus_with_waiting_boards_refreshes_every_taxel_at_31_to_36_hz() {
    let (rates, load) = rates(&mut hand(1, Overload::Wait, |_| 0), 10);
    assert_eq!(rates.len(), 240);
    for (id, hz) in &rates {
        assert!((31.0..=36.0).contains(hz), "{id:03x} at {hz} Hz");
    }
    println!(
        "load {load:.3}, slowest {:?}",
        rates.values().copied().fold(f64::MAX, f64::min)
    );
    assert!(load > 0.9, "{load}");
}

#[test]
fn one_bus_with_overwriting_boards_starves_the_high_identifiers() {
    let (rates, load) = rates(&mut hand(1, Overload::Overwrite, |_| 0), 10);
    println!("load {load:.4}, {} of 240 taxels seen", rates.len());
    assert!(load > 0.99, "{load}");
    // SDA line 0: 60 taxels at their full rate. SDA line 3: nothing at all.
    assert!((0x000..0x0F).all(|id| (99.0..=100.2).contains(&rates[&id])));
    assert_eq!(
        rates.range(..0x100).filter(|(_, hz)| **hz > 99.0).count(),
        60
    );
    assert_eq!(
        rates
            .range(0x300..)
            .filter(|(id, hz)| **id < 0x400 && **hz > 1.0)
            .count(),
        0
    );
}

#[test]
fn four_buses_carry_the_hand_at_100_hz_and_74_percent() {
    for phase in [0, 613] {
        let mut hand = hand(4, Overload::Wait, |n| phase * u64::from(n));
        let (rates, load) = rates(&mut hand, 10);
        let fullest = hand.with(|b| b.iter().map(|b| b.segment().load()).fold(0.0, f64::max));
        println!("mean load {load:.3}, fullest {fullest:.3}");
        assert_eq!(rates.len(), 240);
        assert!(rates.values().all(|hz| (99.5..=100.5).contains(hz)));
        assert!((0.72..0.77).contains(&fullest), "{fullest}");
    }
}

#[test]
fn real_readings_make_frames_of_about_116_bits() {
    let mut hand = hand(4, Overload::Wait, |_| 0);
    rates(&mut hand, 5);
    hand.with(|buses| {
        for bus in buses {
            let statistics = bus.segment().statistics();
            let mean = statistics.bits as f64 / statistics.frames as f64;
            assert!((114.0..118.5).contains(&mean), "{mean}");
        }
    });
}

/// Waiting boards share the bus evenly only while they tick together: with clocks spread over the
/// scan period a low board number that is ready again gets in before a high one that waits.
#[test]
fn waiting_boards_out_of_step_share_the_bus_unevenly() {
    let (rates, _) = rates(&mut hand(1, Overload::Wait, |n| 667 * u64::from(n)), 10);
    let slowest = rates.values().copied().fold(f64::MAX, f64::min);
    let fastest = rates.values().copied().fold(0.0, f64::max);
    println!("{slowest} to {fastest} Hz over {} taxels", rates.len());
    assert_eq!(rates.len(), 240);
    assert!(fastest > 40.0 && slowest < 20.0);
}
