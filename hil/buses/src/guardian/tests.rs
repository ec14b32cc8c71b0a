//! The sweep over emulated chips: what is found, what is switched off, and a bus that is stuck.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use embedded_hal::i2c::{Error as _, ErrorKind, NoAcknowledgeSource, Operation};
use palpate_emulators::display::dac7578::Dac7578;
use palpate_emulators::display::i2c::{BusClock, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Pca9685};

use palpate_emulators::haptic::Motor;
use palpate_emulators::haptic::drv2605::Drv2605;
use palpate_emulators::haptic::drv2605::registers::{self as regs, mode};
use palpate_emulators::haptic::lra::{Lra, LraParameters};
use palpate_emulators::haptic::tca9548a::Tca9548a;
use palpate_emulators::time::Nanos;

use super::{BoardFound, Sweeper, Watch, WatchedBus, parse_bus, parse_line};
use crate::i2c::{Adapter, FaultKind};

/// How long a sweep of emulated chips may take.
const PATIENCE: Duration = Duration::from_millis(50);

/// What went over a bus, by address: a bus is stuck while a test holds it.
type Line = Arc<Mutex<Vec<(u8, Vec<u8>)>>>;

/// An emulated bus as an adapter.
struct Emulated {
    segment: I2cSegment,
    line: Line,
}

impl Adapter for Emulated {
    fn name(&self) -> String {
        "emulated".into()
    }

    fn transfer(&mut self, address: u8, write: &[u8], read: &mut [u8]) -> Result<(), FaultKind> {
        let mut line = self.line.lock().unwrap();
        line.push((address, write.to_vec()));
        let mut operations = vec![Operation::Write(write)];
        if !read.is_empty() {
            operations.push(Operation::Read(read));
        }
        let done = self.segment.transaction(address, &mut operations);
        done.map_err(|error| match error.kind() {
            ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address) => FaultKind::NoAddress,
            _ => FaultKind::Disturbed,
        })
    }
}

/// A bus with a chip at 0x40 whose channels 3 and 5 were left driving, a converter at 0x48 whose output 3 was left at half its
/// scale, and no chip at 0x41 and 0x49.
fn bus(boards: &[u8], converters: &[u8]) -> ((WatchedBus, Box<dyn Adapter>), Line) {
    let chips = vec![Pca9685::new(Config::new(0x40))];
    let segment = I2cSegment::new(BusClock::Fast, chips);
    let mut segment = segment.with_converters(vec![Dac7578::new(0x48)]);
    let mut write = |address, bytes: &[u8]| {
        let sent = segment.transaction(address, &mut [Operation::Write(bytes)]);
        sent.unwrap();
    };
    write(0x40, &[0x00, 0x21, 0x04]); // awake, auto-increment, all-call
    write(0x40, &[0x06 + 4 * 3, 0, 0, 100, 0]);
    write(0x40, &[0x06 + 4 * 5, 0, 0x10, 0, 0]);
    write(0x48, &[0x33, 0x80, 0]);
    let line = Line::default();
    let adapter = Emulated {
        segment,
        line: Arc::clone(&line),
    };
    let watched = watched("/dev/emulated", boards, converters);
    ((watched, Box::new(adapter)), line)
}

fn over(lines: Vec<(WatchedBus, Box<dyn Adapter>)>) -> Sweeper {
    let (sweeper, missing) = Sweeper::over(lines);
    assert!(missing.is_empty(), "{missing:?}");
    sweeper
}

fn watched(path: &str, boards: &[u8], converters: &[u8]) -> WatchedBus {
    WatchedBus {
        path: path.into(),
        boards: boards.to_vec(),
        converters: converters.to_vec(),
        motors: Vec::new(),
    }
}

#[test]
fn a_chip_left_driving_is_found_named_and_switched_off() {
    let mut sweeper = over(vec![bus(&[0x40], &[]).0]);
    let found = sweeper.look(PATIENCE);
    assert!(found[0].was_driving());
    assert_eq!(
        found[0].to_string(),
        "/dev/emulated 0x40: was driving channels 3,5"
    );
    sweeper.off(PATIENCE);
    let after = sweeper.look(PATIENCE);
    assert_eq!(after[0].to_string(), "/dev/emulated 0x40: was off");
}

#[test]
fn a_chip_is_switched_off_before_it_is_looked_at_and_what_it_drove_is_known_once() {
    let (on, line) = bus(&[0x40], &[]);
    let mut sweeper = over(vec![on]);
    let (found, wrong) = sweeper.off(PATIENCE);
    assert_eq!(
        (found[0].to_string(), wrong),
        (
            "/dev/emulated 0x40: was driving channels 3,5".into(),
            vec![]
        )
    );
    let line = std::mem::take(&mut *line.lock().unwrap());
    let first_off = line.iter().position(|(_, write)| write == &[0xFD, 0x10]);
    let is_read = |(_, write): &(u8, Vec<u8>)| write.len() == 1;
    assert!(first_off < line.iter().position(is_read), "{line:x?}");
    let (found, _) = sweeper.off(PATIENCE);
    assert_eq!(found[0].to_string(), "/dev/emulated 0x40: was off");
}

#[test]
fn a_board_that_does_not_answer_is_not_known_to_be_off_and_keeps_no_other_on() {
    let mut sweeper = over(vec![bus(&[0x40, 0x41], &[]).0]);
    let (found, wrong) = sweeper.off(PATIENCE);
    assert!(
        wrong[0].contains("0x41") && wrong[0].contains("ENXIO"),
        "{wrong:?}"
    );
    assert!(found[0].was_driving() && found[1].seen.is_err());
    let after = sweeper.look(PATIENCE);
    assert!(after[0].seen.as_ref().unwrap().driving == 0);
}

#[test]
fn a_stuck_bus_keeps_no_other_bus_on() {
    let ((first, hold), (second, _)) = (bus(&[0x40], &[]), bus(&[0x40], &[]));
    let mut sweeper = over(vec![first, second]);
    let held = hold.lock().unwrap();
    let (found, wrong) = sweeper.off(PATIENCE);
    assert!(found[0].seen.is_err() && found[1].was_driving());
    assert_eq!(
        wrong,
        ["/dev/emulated, the adapter has not answered yet"],
        "the other one is off"
    );
    drop(held);
    // What was ordered is carried out once the bus is free.
    let (_, wrong) = sweeper.off(Duration::from_secs(5));
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn a_current_left_set_goes_to_zero_after_every_output_and_is_read_back() {
    let (on, line) = bus(&[0x40], &[0x48]);
    let mut sweeper = over(vec![on]);
    assert!(sweeper.off(PATIENCE).1.is_empty());
    let line = std::mem::take(&mut *line.lock().unwrap());
    let off = line
        .iter()
        .rposition(|(a, w)| *a == 0x40 && w == &[0xFD, 0x10]);
    let zeroed = line
        .iter()
        .position(|sent| *sent == (0x48, vec![0x3F, 0, 0]));
    assert!(off < zeroed && zeroed.is_some(), "{line:x?}");
    // Each of the eight codes is read after that.
    let read = |channel: u8| {
        line.iter()
            .rposition(|sent| *sent == (0x48, vec![0x10 | channel]))
    };
    assert!((0..8).all(|channel| read(channel) > zeroed), "{line:x?}");
}

#[test]
fn a_converter_that_does_not_answer_is_not_known_to_be_at_zero_and_keeps_no_board_on() {
    let mut sweeper = over(vec![bus(&[0x40], &[0x49]).0]);
    let (_, wrong) = sweeper.off(PATIENCE);
    assert!(wrong[0].contains("0x49"), "{wrong:?}");
    let after = sweeper.look(PATIENCE);
    assert!(after[0].seen.as_ref().unwrap().driving == 0);
}

#[test]
fn a_watch_survives_its_command_line() {
    let watch = Watch {
        buses: vec![
            watched("/dev/i2c-1", &[0x40, 0x7f], &[]),
            watched("/dev/a=b+c", &[0x41], &[0x48]),
        ],
        oe: Some(("/dev/gpiochip0".into(), 17)),
        heartbeat: Duration::from_millis(50),
        transfer: Duration::from_millis(30),
    };
    let arguments = watch.arguments();
    let value = |name: &str| {
        let with = format!("--{name}=");
        let all = arguments.iter().filter_map(|a| a.strip_prefix(&with));
        all.map(str::to_owned).collect::<Vec<_>>()
    };
    let buses: Vec<_> = value("i2c").iter().map(|a| parse_bus(a).unwrap()).collect();
    assert_eq!(buses, watch.buses);
    assert_eq!(parse_line(&value("oe")[0]).ok(), watch.oe);
    assert_eq!(value("heartbeat-ms"), ["50"]);
    for bad in [
        "",
        "/dev/i2c-1",
        "/dev/i2c-1=",
        "/dev/i2c-1=4g",
        "/dev/i2c-1=40,",
        "/dev/i2c-1=40+",
    ] {
        assert!(parse_bus(bad).is_err(), "{bad}");
    }
}

/// A bus with a switch at 0x70 before these drivers of motors, of which the second was left at a level and the last in a
/// calibration.
fn motors(channels: &[usize]) -> ((WatchedBus, Box<dyn Adapter>), Line) {
    let lra = || Drv2605::new(Motor::Lra(Lra::new(LraParameters::COIN_10MM)));
    let switch = channels
        .iter()
        .fold(Tca9548a::new(0x70), |switch, own| switch.with(*own, lra()));
    let segment = I2cSegment::new(BusClock::Fast, Vec::new());
    let mut segment = segment.with_haptics(vec![switch], Vec::new());
    segment.advance(Nanos::from_micros(1000), &mut |_, _| ());
    let mut write = |address, bytes: &[u8]| {
        let sent = segment.transaction(address, &mut [Operation::Write(bytes)]);
        sent.unwrap();
    };
    for (channel, registers) in [
        (
            channels[1],
            [[regs::MODE, mode::REAL_TIME], [regs::RTP_INPUT, 90]],
        ),
        (
            channels[channels.len() - 1],
            [[regs::MODE, mode::CALIBRATE], [regs::GO, 1]],
        ),
    ] {
        write(0x70, &[1 << channel]);
        registers
            .iter()
            .for_each(|bytes| write(regs::ADDRESS, bytes));
    }
    let line = Line::default();
    let watched = WatchedBus {
        path: "/dev/emulated".into(),
        boards: Vec::new(),
        converters: Vec::new(),
        motors: channels
            .iter()
            .map(|own| Some((0x70, *own as u8)))
            .collect(),
    };
    let adapter = Emulated {
        segment,
        line: Arc::clone(&line),
    };
    ((watched, Box::new(adapter)), line)
}

#[test]
fn motors_left_driving_are_found_by_their_switch_and_brought_to_rest() {
    let mut sweeper = over(vec![motors(&[0, 2, 3, 7]).0]);
    let said = |found: &[BoardFound]| found.iter().map(ToString::to_string).collect::<Vec<_>>();
    let driving = ["/dev/emulated 0x70: was driving channels 2,7"];
    assert_eq!(said(&sweeper.look(PATIENCE)), driving);
    let (found, wrong) = sweeper.off(PATIENCE);
    assert_eq!((said(&found), wrong), (said(&found), vec![]));
    assert_eq!(said(&found), driving);
    assert_eq!(
        said(&sweeper.look(PATIENCE)),
        ["/dev/emulated 0x70: was off"]
    );
}

#[test]
fn a_driver_that_does_not_answer_is_not_known_to_be_off_and_keeps_no_other_on() {
    let ((mut watched, adapter), line) = motors(&[0, 2, 7]);
    watched.motors.insert(0, Some((0x70, 5)));
    let mut sweeper = over(vec![(watched, adapter)]);
    let (_, wrong) = sweeper.off(PATIENCE);
    assert!(
        wrong[0].contains("actuator 0: I2C") && wrong[0].contains("no chip"),
        "{wrong:?}"
    );
    let (mut open, mut at_rest) = (0, 0);
    for (address, write) in &*line.lock().unwrap() {
        match (*address, &**write) {
            (0x70, [control]) => open = *control,
            (regs::ADDRESS, [regs::RTP_INPUT, 0]) => at_rest |= open,
            _ => {}
        }
    }
    assert_eq!(at_rest & 0b1000_0101, 0b1000_0101, "{at_rest:#b}");
}

#[test]
fn places_of_motors_go_through_a_command_line() {
    for text in ["/dev/i2c-1=70.0,70.7,71.3", "/dev/i2c-1=5a.0"] {
        assert_eq!(parse_bus(text).unwrap().to_string(), text);
    }
    assert_eq!(parse_bus("/dev/i2c-1=5a.0").unwrap().motors, [None]);
    for bad in ["/dev/i2c-1=70.x", "/dev/i2c-1=70.0,71", "/dev/i2c-1=.0"] {
        assert!(
            parse_bus(bad).unwrap_err().contains("expected PATH="),
            "{bad}"
        );
    }
}
