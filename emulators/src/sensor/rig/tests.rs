//! Boards, segment and host together.

use palpate_core::codec::uskin::{Command, Message, Wiring, decode, id};
use palpate_core::units::Point;

use super::*;
use crate::sensor::board::Overload;
use crate::sensor::{ModuleConfig, Press, grid};

fn module(number: usize) -> EmulatedModule {
    EmulatedModule::new(ModuleConfig {
        number,
        seed: 1,
        ..ModuleConfig::default()
    })
}

fn one_board(config: BoardConfig) -> Handle {
    let mut bus = SkinBus::new(1_000_000);
    bus.add_board(config, vec![module(0)]).unwrap();
    Handle::new(vec![bus])
}

fn drain(handle: &mut Handle) -> Vec<Received> {
    std::iter::from_fn(|| handle.receive().unwrap()).collect()
}

fn command(board: u8, start: bool) -> CanFrame {
    Command { board, start }.encode().unwrap()
}

#[test]
fn a_board_sends_scans_in_wire_order_between_start_and_stop() {
    let mut handle = one_board(BoardConfig {
        address: 4,
        ..BoardConfig::default()
    });
    handle.advance(Nanos::from_micros(50_000));
    assert_eq!(drain(&mut handle), []);
    handle.transmit(0, &command(3, true)).unwrap(); // another board
    handle.advance(Nanos::from_micros(100_000));
    assert_eq!(drain(&mut handle), []);
    handle.transmit(0, &command(4, true)).unwrap();
    handle.advance(Nanos::from_micros(200_000));
    let frames = drain(&mut handle);
    assert_eq!(frames.len(), 160);
    for (n, received) in frames.iter().enumerate() {
        let place = Wiring::FLAT.nth(n % 16).unwrap();
        assert_eq!(Some(received.frame.id()), id(4, place));
    }
    assert!(
        frames
            .windows(2)
            .all(|w| w[1].at.since(w[0].at).as_micros() >= 111)
    );
    let period = frames[16].at.since(frames[0].at).as_micros();
    assert!((9_970..=10_030).contains(&period), "{period}");
    handle.transmit(0, &command(15, false)).unwrap();
    handle.advance(Nanos::from_micros(215_000));
    drain(&mut handle);
    handle.advance(Nanos::from_micros(500_000));
    assert_eq!(drain(&mut handle), []);
    handle.with(|buses| assert!(!buses[0].boards()[0].sending()));
}

#[test]
fn a_touch_raises_the_taxel_beneath_it_and_the_stretch_of_steps_does_not_matter() {
    let run = |step_us: u64| {
        let mut skin = module(0);
        skin.touch(Box::new(|now: Nanos, out: &mut Vec<Press>| {
            let force_n = if now.as_secs_f64() > 0.1 { 1.0 } else { 0.0 };
            out.push(Press {
                at: Point::new(-7.05, 7.05),
                force_n,
                diameter_mm: 19.45,
            });
        }));
        let mut bus = SkinBus::new(1_000_000);
        let autostart = BoardConfig {
            autostart: true,
            ..BoardConfig::default()
        };
        bus.add_board(autostart, vec![skin]).unwrap();
        let mut handle = Handle::new(vec![bus]);
        let mut all = Vec::new();
        for t in (0..=200_000).step_by(step_us as usize) {
            handle.advance(Nanos::from_micros(t));
            all.extend(drain(&mut handle));
        }
        all
    };
    let frames = run(10);
    assert_eq!(frames, run(1000));
    assert_eq!(frames, run(100_000));
    let z = |scan: &[Received], taxel| {
        scan.iter().find_map(|r| match decode(&r.frame) {
            Ok(Message::Data(d)) if Wiring::FLAT.taxel(d.place) == Some((0, taxel)) => {
                Some(d.reading.z)
            }
            _ => None,
        })
    };
    let (first, last) = (&frames[..16], &frames[frames.len() - 32..]);
    let rise = |taxel| i32::from(z(last, taxel).unwrap()) - i32::from(z(first, taxel).unwrap());
    // Row 0, column 0 is top left.
    assert!(
        rise(0) > 200 && rise(15).abs() < 15,
        "{} {}",
        rise(0),
        rise(15)
    );
}

#[test]
fn a_drifting_clock_scans_at_its_own_rate() {
    let count = |drift_ppm| {
        let mut handle = one_board(BoardConfig {
            autostart: true,
            drift_ppm,
            ..BoardConfig::default()
        });
        handle.advance(Nanos::from_micros(20_005_000));
        drain(&mut handle);
        handle.with(|buses| buses[0].boards()[0].scans().0)
    };
    assert_eq!(
        (count(0.0), count(1000.0), count(-1000.0)),
        (2001, 2003, 1999)
    );
}

#[test]
fn two_modules_share_a_board() {
    let half = |number| {
        let taxels = grid(2, 4, 4.7);
        EmulatedModule::new(ModuleConfig {
            number,
            taxels,
            ..ModuleConfig::default()
        })
    };
    let mut bus = SkinBus::new(1_000_000);
    let config = BoardConfig {
        address: 3,
        wiring: Wiring::new(2, 4, 2).unwrap(),
        autostart: true,
        ..BoardConfig::default()
    };
    assert_eq!(
        bus.add_board(config, vec![half(0)]),
        Err(BoardError::Wiring)
    );
    bus.add_board(config, vec![half(0), half(1)]).unwrap();
    let mut handle = Handle::new(vec![bus]);
    handle.advance(Nanos::from_micros(9_000));
    let ids: Vec<_> = drain(&mut handle).iter().map(|r| r.frame.id()).collect();
    assert_eq!(ids.len(), 16);
    assert_eq!((ids[0], ids[8], ids[15]), (0x003, 0x083, 0x1B3));
}

#[test]
fn bad_boards_are_refused() {
    let mut bus = SkinBus::new(1_000_000);
    let default = BoardConfig::default();
    for (config, error) in [
        (
            BoardConfig {
                address: 16,
                ..default
            },
            BoardError::Address,
        ),
        (
            BoardConfig {
                scan_hz: 0.0,
                ..default
            },
            BoardError::Rate,
        ),
        (
            BoardConfig {
                scan_hz: f64::NAN,
                ..default
            },
            BoardError::Rate,
        ),
        (
            BoardConfig {
                wiring: Wiring::CURVED,
                ..default
            },
            BoardError::Wiring,
        ),
    ] {
        assert_eq!(bus.add_board(config, vec![module(0)]), Err(error));
    }
    assert_eq!(
        Handle::new(vec![]).transmit(0, &command(0, true)),
        Err(HostError::NoBus)
    );
}

#[test]
fn overwriting_boards_keep_wire_order_when_chips_are_ready_one_after_another() {
    let mut handle = one_board(BoardConfig {
        autostart: true,
        overload: Overload::Overwrite,
        chip_gap: Nanos::from_micros(2000),
        ..BoardConfig::default()
    });
    handle.advance(Nanos::from_micros(9_000));
    let ids: Vec<_> = drain(&mut handle).iter().map(|r| r.frame.id()).collect();
    let wire: Vec<_> = (0..16)
        .filter_map(|n| id(0, Wiring::FLAT.nth(n)?))
        .collect();
    assert_eq!(ids, wire);
}
