//! Drivers that share a board: each switches its own channels, and what befalls the chip befalls both.

use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use palpate_core::driver::{Actuators, Banks, Pca9685Bank};
use palpate_core::guard::{Guard, HARD, Plant, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Channel, Instant, Milliamps, Point, Prescale, Ticks};
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Pca9685, Pin};
use palpate_emulators::time::Nanos;

const PRE: Prescale = Prescale::new(30);
const LOWER: u16 = 0x00FF;
const UPPER: u16 = 0xFF00;

/// A guard over eight wires from a channel on.
fn guard(first: u8) -> Guard {
    let wire = |channel| DisplayWire {
        place: Point::new(f32::from(channel), 0.0),
        board: Board(0),
        channel: Channel(channel),
    };
    let wires: Vec<DisplayWire> = (first..first + 8).map(wire).collect();
    let plant = Plant {
        prescale: PRE,
        wire_milliohm: 1900,
        peak: Milliamps(990),
        bus: palpate_core::units::Duration::ZERO,
    };
    let mut guard = Guard::new(HARD, plant, &wires, WornWire::default()).unwrap();
    guard.hear(Instant::ZERO);
    guard
}

/// A chip, and the drivers of its lower and of its upper eight channels.
fn shared() -> (I2cHandle, [Pca9685Bank<I2cHandle>; 2]) {
    let chip = Pca9685::new(Config::new(0x40));
    let bus = I2cHandle::new(I2cSegment::new(BusClock::Fast, vec![chip]));
    let bank = |own| Pca9685Bank::new(bus.clone(), &[0x40], PRE).sharing(&[own]);
    let banks = [LOWER, UPPER].map(bank);
    (bus, banks)
}

/// Drives the first wire of a guard for 35 ms.
fn drive(guard: &mut Guard, bank: &mut Pca9685Bank<I2cHandle>, now: Instant) {
    let stimulus = Stimulus {
        wire: 0,
        width: Ticks::new(100),
        peak: Milliamps(990),
        at: now,
        until: now + palpate_core::units::Duration::from_millis(35),
    };
    let update = guard.admit(now, Board(0), &[stimulus], |_| ());
    bank.apply(&update).unwrap();
}

/// Rising edges by channel until `ms`.
fn rises(bus: &I2cHandle, ms: u64) -> [u32; 16] {
    let mut count = [0; 16];
    bus.with(|segment| {
        segment.advance(Nanos::from_micros(1000 * ms), &mut |_, edge| {
            count[usize::from(edge.channel.0)] += u32::from(edge.pin == Pin::High);
        });
    })
    .unwrap();
    count
}

#[test]
fn an_all_off_of_one_leaves_the_others_burst() {
    let (bus, [mut lower, mut upper]) = shared();
    lower.start(Instant::ZERO).unwrap();
    upper.start(Instant::ZERO).unwrap();
    let (mut left, mut right) = (guard(0), guard(8));
    rises(&bus, 10);
    let now = Instant::from_micros(10_000);
    drive(&mut left, &mut lower, now);
    drive(&mut right, &mut upper, now);
    let both = rises(&bus, 30);
    assert!(both[0] >= 2 && both[8] >= 2, "{both:?}");
    lower.all_off().unwrap();
    rises(&bus, 36); // the end of the period
    let after = rises(&bus, 50);
    assert!(after[0] == 0 && after[8] >= 2, "{after:?}");
    // A restart by one of them does not reach the other either.
    lower.start(Instant::from_micros(50_000)).unwrap();
    let after = rises(&bus, 60);
    assert!(after[0] == 0 && after[8] >= 1, "{after:?}");
}

/// The driver that finds a chip without its settings switches it off whole and starts it for both.
#[test]
fn a_chip_that_lost_its_settings_is_started_for_both() {
    let (bus, [mut lower, mut upper]) = shared();
    lower.start(Instant::ZERO).unwrap();
    upper.start(Instant::ZERO).unwrap();
    bus.with(|segment| {
        let now = segment.now();
        segment.chips_mut()[0].power_cycle(now);
    })
    .unwrap();
    assert!(lower.verify().is_err() && upper.verify().is_err());
    upper.start(Instant::from_micros(20_000)).unwrap();
    lower.verify().unwrap();
    let (mut left, now) = (guard(0), Instant::from_micros(30_000));
    left.hear(now);
    rises(&bus, 30);
    drive(&mut left, &mut lower, now);
    let after = rises(&bus, 50);
    assert!(after[0] >= 3, "{after:?}");
}

/// A channel at a time by its own register, and nothing by all-call; whole boards as ever.
#[test]
fn bytes_of_an_all_off_on_a_shared_bus() {
    let off = |register: u8| Transaction::write(0x40, vec![register, 0x10]);
    let mut mock = Mock::new(&[
        off(0x06 + 3),
        off(0x06 + 4 * 2 + 3),
        off(0x06 + 4 * 15 + 3),
        Transaction::write(0x41, vec![0xFD, 0x10]),
    ]);
    let boards = [0x40, 0x41];
    let banks = Banks::new([(mock.clone(), &boards[..])], PRE);
    let mut banks = banks.sharing(&[1 | 1 << 2 | 1 << 15, u16::MAX]);
    banks.all_off().unwrap();
    mock.done();
}

/// Channels of another driver lie between: they are not written.
#[test]
fn an_update_is_written_around_channels_of_others() {
    let wire = |channel| DisplayWire {
        place: Point::new(f32::from(channel), 0.0),
        board: Board(0),
        channel: Channel(channel),
    };
    let plant = Plant {
        prescale: PRE,
        wire_milliohm: 1900,
        peak: Milliamps(990),
        bus: palpate_core::units::Duration::ZERO,
    };
    let mut guard = Guard::new(HARD, plant, &[wire(0), wire(2)], WornWire::default()).unwrap();
    guard.hear(Instant::ZERO);
    let until = Instant::from_micros(35_000);
    let stimulus = |wire| Stimulus {
        wire,
        width: Ticks::new(100),
        peak: Milliamps(990),
        at: Instant::ZERO,
        until,
    };
    let update = guard.admit(Instant::ZERO, Board(0), &[stimulus(0), stimulus(1)], |_| ());
    let mut mock = Mock::new(&[
        Transaction::write(0x40, vec![0x06, 0, 0, 100, 0]),
        Transaction::write(0x40, vec![0x0E, 0x00, 0x02, 0x64, 0x02]),
    ]);
    let mut bank = Pca9685Bank::new(mock.clone(), &[0x40], PRE).sharing(&[0b101]);
    bank.apply(&update).unwrap();
    assert_eq!((bank.traffic().writes, bank.traffic().channels), (2, 2));
    mock.done();
}
