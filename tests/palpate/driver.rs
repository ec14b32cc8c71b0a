//! The PCA9685 driver's bytes on the wire, against embedded-hal's own mock.

use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, NoAcknowledgeSource, Operation};
use embedded_hal_mock::eh1::i2c::{Mock, Transaction};
use palpate_core::driver::Actuators;
use palpate_core::driver::{DriverError, Pca9685Bank};
use palpate_core::guard::{Guard, HARD, Plant, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Channel, Clock, Instant, Milliamps, Point, Prescale, Ticks};
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Pca9685};
use proptest::prelude::*;

const PRE: Prescale = Prescale::new(30);

fn guard(outputs: &[(u8, u8)]) -> Guard {
    let plant = Plant {
        prescale: PRE,
        wire_milliohm: 1900,
        peak: Milliamps(1970),
        bus: palpate_core::units::Duration::ZERO,
    };
    let wire = |(i, &(board, channel)): (usize, &(u8, u8))| DisplayWire {
        place: Point::new(i as f32, 0.0),
        board: Board(board),
        channel: Channel(channel),
    };
    let wires: Vec<DisplayWire> = outputs.iter().enumerate().map(wire).collect();
    Guard::new(HARD, plant, &wires, WornWire::default()).unwrap()
}

fn stimulus(wire: u16, width: u16, at_us: u64) -> Stimulus {
    Stimulus {
        wire,
        width: Ticks::new(width),
        peak: Milliamps(1970),
        at: Instant::from_micros(at_us),
        until: Instant::from_micros(at_us + 35_000),
    }
}

/// The registers of one chip that counts addresses up within a write, and says no to some writes half way.
struct Registers {
    bytes: [u8; 256],
    refuse: u32,
    writes: u32,
}

impl ErrorType for Registers {
    type Error = ErrorKind;
}

impl I2c for Registers {
    fn transaction(
        &mut self,
        _address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), ErrorKind> {
        for operation in operations {
            let Operation::Write([register, data @ ..]) = operation else {
                continue;
            };
            self.writes += 1;
            let refused = self.refuse > 0 && self.writes.is_multiple_of(self.refuse);
            let taken = if refused { data.len() / 2 } else { data.len() };
            for (n, byte) in data[..taken].iter().enumerate() {
                let register = usize::from(*register) + n;
                self.bytes[register] = *byte;
                if register == 0xFD {
                    (0..16).for_each(|c| self.bytes[9 + 4 * c] = *byte);
                }
            }
            if refused {
                return Err(ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data));
            }
        }
        Ok(())
    }
}

proptest! {
    /// What is left out because a register holds it already is not missed: after every update that arrived, the
    /// chip does what writing every channel of every update would have it do.
    #[test]
    fn registers_left_out_hold_what_they_should(
        ops in prop::collection::vec((0..80_000u64, 0..8u8, prop::collection::vec(0..160u16, 4)), 1..60),
        refuse in prop::option::of(2..9u32),
    ) {
        let outputs = [(0, 0), (0, 3), (0, 4), (0, 15)];
        let mut guard = guard(&outputs);
        let mut bus = Registers { bytes: [0; 256], refuse: 0, writes: 0 };
        (0..16).for_each(|c| bus.bytes[9 + 4 * c] = 0x10);
        bus.refuse = refuse.unwrap_or(0);
        let mut bank = Pca9685Bank::new(&mut bus, &[0x40], PRE);
        // ON and OFF of every channel, `None` for off, and whether the last write arrived.
        let mut wanted: [Option<(u16, u16)>; 16] = [None; 16];
        let (mut at, mut known) = (0, [true; 16]);
        for (dt, kind, widths) in ops {
            at += dt;
            let now = Instant::from_micros(at);
            guard.hear(now);
            let update = match kind {
                0 => guard.release(now, Board(0)),
                1 | 2 => guard.expire(now, Board(0)),
                3 => {
                    guard.all_off(now);
                    if bank.all_off().is_ok() {
                        (wanted, known) = ([None; 16], [true; 16]);
                    } else {
                        known = [false; 16];
                    }
                    continue;
                }
                _ => {
                    let stimuli: Vec<_> = (0..4).map(|w| stimulus(w, widths[usize::from(w)] / 2, at)).collect();
                    guard.admit(now, Board(0), &stimuli, |_| ())
                }
            };
            let arrived = bank.apply(&update).is_ok();
            for (channel, setting) in update.channels().iter().enumerate() {
                if let Some(s) = setting {
                    wanted[channel] = (s.off > s.on).then_some((s.on, s.off));
                    // A torn write leaves what it was about unknown until it is asked for again.
                    known[channel] = arrived;
                }
            }
            for channel in (0..16).filter(|c| known[*c]) {
                let bytes: [u8; 4] = bank.bus().bytes[6 + 4 * channel..][..4].try_into().unwrap();
                let [on, off] = [[bytes[0], bytes[1]], [bytes[2], bytes[3]]].map(u16::from_le_bytes);
                let does = (off & 0x1000 == 0).then_some((on, off));
                prop_assert_eq!(does, wanted[channel], "channel {} at {} us", channel, at);
            }
        }
    }
}

#[test]
fn start_switches_off_verifies_and_configures_asleep() {
    let mut mock = Mock::new(&[
        Transaction::write(0x70, vec![0xFD, 0x10]),
        Transaction::write(0x40, vec![0xFD, 0x10]),
        Transaction::write_read(0x40, vec![0x09], vec![0x10]),
        Transaction::write(0x40, vec![0x00, 0x31, 0x04]),
        Transaction::write(0x40, vec![0xFE, 30]),
        Transaction::write_read(0x40, vec![0xFE], vec![30]),
        Transaction::write(0x40, vec![0x00, 0x21]),
        Transaction::write_read(0x40, vec![0x00], vec![0x21]),
    ]);
    let mut bank = Pca9685Bank::new(mock.clone(), &[0x40], PRE);
    let ready = bank.start(Instant::from_micros(10)).unwrap();
    assert_eq!(ready, Instant::from_micros(510));
    mock.done();
}

#[test]
fn an_external_clock_is_switched_to_asleep_and_read_back() {
    let mut mock = Mock::new(&[
        Transaction::write(0x70, vec![0xFD, 0x10]),
        Transaction::write(0x40, vec![0xFD, 0x10]),
        Transaction::write_read(0x40, vec![0x09], vec![0x10]),
        Transaction::write(0x40, vec![0x00, 0x31, 0x04]),
        Transaction::write(0x40, vec![0x00, 0x71]),
        Transaction::write(0x40, vec![0xFE, 19]),
        Transaction::write_read(0x40, vec![0xFE], vec![19]),
        Transaction::write(0x40, vec![0x00, 0x61]),
        Transaction::write_read(0x40, vec![0x00], vec![0x61]),
        // A brown-out: the chip sleeps, and would wake up on its own oscillator.
        Transaction::write_read(0x40, vec![0x00], vec![0x11]),
    ]);
    let clock = Clock::external(16_000_000, 50).unwrap();
    let prescale = Prescale::from_hz(clock, 200.0).unwrap();
    let mut bank = Pca9685Bank::new(mock.clone(), &[0x40], prescale);
    bank.start(Instant::ZERO).unwrap();
    let fallen = bank.verify().unwrap_err();
    assert_eq!(fallen, DriverError::Readback(Board(0), 0x00, 0x61, 0x11));
    mock.done();
}

/// EXTCLK outlives the program that set it; without it in the bench the guard would count by the wrong clock.
#[test]
fn a_chip_left_on_its_external_clock_is_refused() {
    let chip = Pca9685::new(Config::new(0x40));
    let mut bus = I2cHandle::new(I2cSegment::new(BusClock::Fast, vec![chip]));
    bus.write(0x40, &[0x00, 0x51]).unwrap();
    let mut bank = Pca9685Bank::new(bus, &[0x40], PRE);
    let error = bank.start(Instant::ZERO).unwrap_err();
    assert_eq!(error, DriverError::Readback(Board(0), 0x00, 0x21, 0x61));
    assert!(
        error.to_string().contains("or state drive.clock"),
        "{error}"
    );
}

#[test]
fn a_chip_that_does_not_read_back_is_refused() {
    let mut mock = Mock::new(&[
        Transaction::write(0x70, vec![0xFD, 0x10]),
        Transaction::write(0x40, vec![0xFD, 0x10]),
        Transaction::write_read(0x40, vec![0x09], vec![0x00]),
    ]);
    let mut bank = Pca9685Bank::new(mock.clone(), &[0x40], PRE);
    let error = bank.start(Instant::ZERO).unwrap_err();
    assert_eq!(error, DriverError::Readback(Board(0), 0x09, 0x10, 0x00));
    assert!(
        error
            .to_string()
            .contains("register 0x09 reads 0x00, expected 0x10"),
        "{error}"
    );
    mock.done();
}

#[test]
fn an_update_is_one_contiguous_write_of_what_changed() {
    // Wires 0 and 2 start: channels 2 .. 4 in one message, the unknown one between them off.
    let mut mock = Mock::new(&[
        Transaction::write(
            0x40,
            vec![
                0x06 + 8, // LED2_ON_L
                0x00,
                0x02,
                0x32,
                0x02, // ON 512, OFF 562
                0x00,
                0x00,
                0x00,
                0x10, // full off
                0x00,
                0x04,
                0x19,
                0x04, // ON 1024, OFF 1049
            ],
        ),
        // Only wire 0 widens: one channel.
        Transaction::write(0x40, vec![0x06 + 8, 0x00, 0x02, 0x37, 0x02]),
        // The end: both off, full-off bit set, ON kept.
        Transaction::write(
            0x40,
            vec![
                0x06 + 8,
                0x00,
                0x02,
                0x00,
                0x12,
                0x00,
                0x00,
                0x00,
                0x10,
                0x00,
                0x04,
                0x00,
                0x14,
            ],
        ),
    ]);
    let mut guard = guard(&[(0, 2), (0, 3), (0, 4)]);
    let mut bank = Pca9685Bank::new(mock.clone(), &[0x40], PRE);
    let first = [stimulus(0, 50, 0), stimulus(2, 25, 0)];
    let update = guard.admit(Instant::ZERO, Board(0), &first, |_| ());
    bank.apply(&update).unwrap();
    // The same again writes nothing.
    bank.apply(&update).unwrap();
    // In mid-burst, which then lasts 45 of its 50 ms.
    let at = Instant::from_micros(10_000);
    let second = [stimulus(0, 55, 10_000), stimulus(2, 25, 10_000)];
    bank.apply(&guard.admit(at, Board(0), &second, |_| ()))
        .unwrap();
    bank.apply(&guard.release(Instant::from_micros(45_000), Board(0)))
        .unwrap();
    mock.done();
}

#[test]
fn a_failed_write_is_told_with_its_board_and_written_again_in_full() {
    let nack = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data);
    let bytes = vec![0x06, 0x00, 0x00, 0x64, 0x00];
    let mut mock = Mock::new(&[
        Transaction::write(0x41, bytes.clone()).with_error(nack),
        Transaction::write(0x41, bytes),
    ]);
    let mut guard = guard(&[(1, 0)]);
    let mut bank = Pca9685Bank::new(mock.clone(), &[0x40, 0x41], PRE);
    let update = guard.admit(Instant::ZERO, Board(1), &[stimulus(0, 100, 0)], |_| ());
    let error = bank.apply(&update).unwrap_err();
    assert_eq!(error, DriverError::Bus(Board(1), nack));
    assert!(!error.is_transient());
    bank.apply(&update).unwrap();
    mock.done();
}

#[test]
fn all_off_reaches_every_board_even_if_one_is_gone() {
    let nack = ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address);
    let off = || vec![0xFD, 0x10];
    let mut mock = Mock::new(&[
        Transaction::write(0x70, off()).with_error(nack),
        Transaction::write(0x40, off()).with_error(nack),
        Transaction::write(0x41, off()),
    ]);
    let mut bank = Pca9685Bank::new(mock.clone(), &[0x40, 0x41], PRE);
    assert_eq!(bank.all_off(), Err(DriverError::Bus(Board(0), nack)));
    mock.done();
}

#[test]
fn a_board_the_bench_does_not_have_is_an_error() {
    let mut mock = Mock::new(&[]);
    let mut bank = Pca9685Bank::new(mock.clone(), &[0x40], PRE);
    let update = guard(&[(3, 0)]).release(Instant::ZERO, Board(3));
    assert_eq!(bank.apply(&update), Err(DriverError::NoSuchBoard(Board(3))));
    mock.done();
}
