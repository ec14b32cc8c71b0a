//! The converter's driver: its bytes against embedded-hal's mock, and driver and emulated chip against each other.

use embedded_hal::i2c::I2c;
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use palpate_core::codec::dac7578::{WRITE_UPDATE, data, frame};
use palpate_core::driver::{Actuators, DriverError, Pca9685Bank};
use palpate_core::guard::{CurrentControl, Guard, Guarded, HARD, Plant, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Channel, Instant, Milliamps, Point, Prescale, Ticks};
use palpate_emulators::display::dac7578::Dac7578;
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Pca9685, Pin};
use palpate_emulators::time::Nanos;
use proptest::prelude::*;

const PRE: Prescale = Prescale::new(30);
const BOARD: u8 = 0x40;
const CONVERTER: u8 = 0x48;
const FULL: Milliamps = Milliamps(990);

fn guard(wires: u8) -> Guard {
    let wire = |n: u8| DisplayWire {
        place: Point::new(f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    let control = CurrentControl {
        full_scale: FULL,
        gain_ppm: 0,
        offset: Milliamps(0),
    };
    let wires: Vec<DisplayWire> = (0..wires).map(wire).collect();
    let fixed = Guard::new(HARD, Plant::default(), &wires, WornWire::default()).unwrap();
    fixed.with_current(control).unwrap()
}

fn stimulus(wire: u16, width: u16, milliamps: u32, at_us: u64) -> Stimulus {
    Stimulus {
        wire,
        width: Ticks::new(width),
        peak: Milliamps(milliamps),
        at: Instant::from_micros(at_us),
        until: Instant::from_micros(at_us + 35_000),
    }
}

/// What a guard passes of some stimuli at one onset.
fn admit(guard: &mut Guard, stimuli: &[Stimulus]) -> Guarded {
    let at = stimuli[0].at;
    guard.hear(at);
    guard.admit(at, Board(0), stimuli, |_| ())
}

fn bus() -> I2cHandle {
    let chips = vec![Pca9685::new(Config::new(BOARD))];
    let segment = I2cSegment::new(BusClock::Fast, chips);
    I2cHandle::new(segment.with_converters(vec![Dac7578::new(CONVERTER)]))
}

fn bank(bus: &I2cHandle) -> Pca9685Bank<I2cHandle> {
    Pca9685Bank::new(bus.clone(), &[BOARD], PRE).with_converters(&[CONVERTER], FULL)
}

fn converter<T>(bus: &I2cHandle, work: impl FnOnce(&mut Dac7578, Nanos) -> T) -> T {
    bus.with(|segment| {
        let now = segment.now();
        work(&mut segment.converters_mut()[0], now)
    })
    .unwrap()
}

fn code(bus: &I2cHandle, channel: u8) -> u16 {
    converter(bus, |chip, _| chip.level(Channel(channel)))
}

/// Whether any output of the board gets a pulse within 50 ms, once the periods are over in which an update arrives.
fn pulses(bus: &I2cHandle) -> bool {
    let mut high = false;
    bus.with(|segment| {
        let arrived = segment.now() + Nanos::from_micros(12_000);
        segment.advance(arrived, &mut |_, _| ());
        let to = segment.now() + Nanos::from_micros(50_000);
        segment.advance(to, &mut |_, edge| high |= edge.pin == Pin::High);
    })
    .unwrap();
    high
}

#[test]
fn a_current_is_written_and_read_back_before_the_pulse() {
    let write = |bytes: Vec<u8>| Transaction::write(CONVERTER, bytes);
    let read = |register: u8, code: u16| {
        let bytes = data(code).to_be_bytes().to_vec();
        Transaction::write_read(CONVERTER, vec![register], bytes)
    };
    // 495 of 990 mA are 2047.5 of 4095: rounded down.
    let mut mock = Mock::new(&[
        write(vec![0x31, 0x7F, 0xF0]),
        read(0x11, 2047),
        Transaction::write(BOARD, vec![0x0A, 0, 1, 50, 1]),
        // The same again an onset later: it is read, and not written.
        Transaction::write(BOARD, vec![0x0A, 0, 1, 0, 0x11]),
        read(0x11, 2047),
        Transaction::write(BOARD, vec![0x0A, 0, 1, 50, 1]),
        // Off: all-call, the board itself, then all currents.
        Transaction::write(0x70, vec![0xFD, 0x10]),
        Transaction::write(BOARD, vec![0xFD, 0x10]),
        write(vec![0x3F, 0, 0]),
    ]);
    let mut bank =
        Pca9685Bank::new(mock.clone(), &[BOARD], PRE).with_converters(&[CONVERTER], FULL);
    let mut guard = guard(2);
    let update = admit(&mut guard, &[stimulus(1, 50, 495, 0)]);
    assert_eq!(update.current(1), Some(Milliamps(495)));
    bank.apply(&update).unwrap();
    guard.confirm(&update, update.at());
    bank.apply(&guard.expire(Instant::from_micros(35_000), Board(0)))
        .unwrap();
    bank.apply(&admit(&mut guard, &[stimulus(1, 50, 495, 100_000)]))
        .unwrap();
    bank.all_off().unwrap();
    mock.done();
}

#[test]
fn start_sets_all_currents_to_zero_and_verify_finds_a_lost_supply() {
    let bus = bus();
    bus.clone()
        .write(CONVERTER, &frame(WRITE_UPDATE, 0x0F, data(0xFFF)))
        .unwrap();
    let mut bank = bank(&bus);
    bank.start(Instant::ZERO).unwrap();
    assert_eq!((0..8).map(|n| code(&bus, n)).sum::<u16>(), 0);
    let mut guard = guard(8);
    let update = admit(&mut guard, &[stimulus(7, 50, 990, 10_000)]);
    bank.apply(&update).unwrap();
    assert_eq!(code(&bus, 7), 4095);
    bank.verify().unwrap();
    converter(&bus, |chip, now| {
        chip.power_off(now);
        chip.power_on(now);
    });
    let lost = DriverError::Current(Board(0), 7, 4095, 0);
    assert_eq!(bank.verify(), Err(lost));
    assert!(lost.to_string().contains("output 7 reads 0, expected 4095"));
}

#[test]
fn no_pulse_comes_where_a_current_does_not_read_back() {
    type Break = fn(&mut Dac7578, Nanos);
    let breaks: [(&str, Break); 4] = [
        ("dead", |chip, now| chip.power_off(now)),
        ("stuck", |chip, _| chip.set_stuck(Channel(0), true)),
        ("flipped", |chip, now| chip.flip(now, Channel(0), 3)),
        ("power lost", |chip, now| {
            chip.power_off(now);
            chip.power_on(now);
        }),
    ];
    for (name, fault) in breaks {
        let bus = bus();
        let (mut bank, mut guard) = (bank(&bus), guard(1));
        bank.start(Instant::ZERO).unwrap();
        let first = admit(&mut guard, &[stimulus(0, 50, 500, 10_000)]);
        bank.apply(&first).unwrap();
        guard.confirm(&first, first.at());
        assert!(pulses(&bus), "{name}: it works before");
        let end = Instant::from_micros(45_000);
        bank.apply(&guard.expire(end, Board(0))).unwrap();
        pulses(&bus);
        converter(&bus, fault);
        // What is stuck shows where the code changes, everything else also where it stays.
        let milliamps = if name == "stuck" { 400 } else { 500 };
        let next = admit(&mut guard, &[stimulus(0, 50, milliamps, 200_000)]);
        let refused = bank.apply(&next);
        assert!(refused.is_err(), "{name}");
        assert!(!pulses(&bus), "{name}");
    }
}

#[test]
fn an_output_without_a_converter_is_refused() {
    let bus = bus();
    let (mut bank, mut guard) = (bank(&bus), guard(9));
    let update = admit(&mut guard, &[stimulus(8, 50, 500, 0)]);
    let none = DriverError::NoConverter(Board(0), 8);
    assert_eq!(bank.apply(&update), Err(none));
    assert!(!pulses(&bus));
}

proptest! {
    /// Whatever is asked, torn, lost and flipped: an update that the driver reports as done has left every output that it
    /// switched on with the code of its current, never more than was commanded.
    #[test]
    fn driver_and_chip_agree(
        steps in prop::collection::vec((40_000..120_000u64, prop::collection::vec(0..1100u32, 8), 0..6u8, 0..8u8, 0..12u8), 1..25),
    ) {
        let bus = bus();
        let (mut bank, mut guard) = (bank(&bus), guard(8));
        bank.start(Instant::ZERO).unwrap();
        let mut at = 0;
        for (pause, currents, fault, channel, bit) in steps {
            at += pause;
            match fault {
                0 => converter(&bus, |chip, now| chip.flip(now, Channel(channel), bit)),
                1 => converter(&bus, |chip, now| { chip.power_off(now); chip.power_on(now); }),
                2 => {
                    let torn = &frame(WRITE_UPDATE, channel, data(0xFFF))[..2];
                    bus.clone().write(CONVERTER, torn).unwrap();
                }
                3 => converter(&bus, |chip, _| chip.set_stuck(Channel(channel), bit < 6)),
                _ => {}
            }
            let stimuli: Vec<_> = (0..8).map(|w| stimulus(w, 10, currents[usize::from(w)], at)).collect();
            let update = admit(&mut guard, &stimuli);
            if bank.apply(&update).is_ok() {
                guard.confirm(&update, update.at());
                for n in 0..8 {
                    if let Some(current) = update.current(n) {
                        let expected = current.0 * 4095 / FULL.0;
                        prop_assert_eq!(u32::from(code(&bus, n)), expected, "output {} at {} us", n, at);
                    }
                }
            } else {
                guard.all_off(Instant::from_micros(at));
                // The outputs are off whatever the converter says.
                let _ = bank.all_off();
                prop_assert!(!pulses(&bus));
            }
        }
    }
}

#[test]
fn drivers_that_share_a_board_touch_their_own_outputs_alone() {
    let bus = bus();
    let own = |channels: u16| bank(&bus).sharing(&[channels]);
    let (mut low, mut high) = (own(0x0F), own(0xF0));
    low.start(Instant::ZERO).unwrap();
    high.start(Instant::ZERO).unwrap();
    let mut guard = guard(8);
    let update = admit(&mut guard, &[stimulus(1, 50, 495, 0)]);
    low.apply(&update).unwrap();
    let mut others = guard.clone();
    let update = admit(&mut others, &[stimulus(6, 50, 990, 100_000)]);
    high.apply(&update).unwrap();
    assert_eq!((code(&bus, 1), code(&bus, 6)), (2047, 4095));
    low.all_off().unwrap();
    assert_eq!((code(&bus, 1), code(&bus, 6)), (0, 4095));
    assert_eq!((low.verify(), high.verify()), (Ok(()), Ok(())));
    // One that starts anew leaves the other's current.
    low.start(Instant::ZERO).unwrap();
    assert_eq!(code(&bus, 6), 4095);
    assert_eq!(high.verify(), Ok(()));
    converter(&bus, |chip, now| chip.flip(now, Channel(6), 0));
    assert_eq!(low.verify(), Ok(()));
    assert_eq!(
        high.verify(),
        Err(DriverError::Current(Board(0), 6, 4095, 4094))
    );
    // A converter that lost its codes gives none of a driver's currents until it was started.
    converter(&bus, |chip, now| {
        chip.power_off(now);
        chip.power_on(now);
    });
    high.start(Instant::ZERO).unwrap();
    assert_eq!((code(&bus, 1), code(&bus, 6)), (0, 0));
}
