//! A unit and a host's driver, joined by what a test does to the datagrams between them.

use alloc::collections::{BTreeSet, VecDeque};
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::RefCell;

use embedded_hal::digital::{ErrorKind as PinError, ErrorType as PinErrorType, OutputPin};
use embedded_hal::i2c::{Error, ErrorKind, ErrorType, I2c, Operation};
use palpate_core::codec::link::{
    Buffer, Command, HELD, Header, Key, Kind, MOST, Planned, Request, Said, State, Warmth,
};
use palpate_core::driver::{Actuators, UnitDriver, UnitFault, UnitSettings};
use palpate_core::guard::{Cause, CurrentControl, Guard, HARD, Plant, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::random::RandomStream;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Channel, Duration, Instant, Milliamps, Point, Ticks};

use crate::{Converters, Datagrams, Settings, SettingsError, Unit};

const KEY: [u8; 32] = [9; 32];
/// Amplifiers whose current is set.
const CONTROL: CurrentControl = CurrentControl {
    full_scale: Milliamps(990),
    gain_ppm: 10_000,
    offset: Milliamps(5),
};
const DELAY: Duration = Duration::from_millis(20);
/// Virtual time between two looks.
const STEP: u64 = 200;

/// Registers of two boards, and whether their bus and OE pin work.
#[derive(Debug)]
struct Chips {
    registers: [[u8; 256]; 2],
    dead: bool,
    cut: bool,
    unwired: bool,
}

impl Default for Shared {
    fn default() -> Self {
        let mut chips = Chips {
            registers: [[0; 256]; 2],
            dead: false,
            cut: false,
            unwired: false,
        };
        (0..2).for_each(|board| chips.reset(board));
        Self(Rc::new(RefCell::new(chips)))
    }
}

impl Chips {
    /// Ticks that a channel is on in each period.
    fn width(&self, board: usize, channel: usize) -> u16 {
        let r = &self.registers[board][6 + 4 * channel..];
        let [on, off] = [[r[0], r[1]], [r[2], r[3]]].map(u16::from_le_bytes);
        // Full off, and a chip that sleeps.
        if self.cut || off & 0x1000 != 0 || self.registers[board][0] & 0x10 != 0 {
            return 0;
        }
        (off & 0xFFF).wrapping_sub(on & 0xFFF) & 0xFFF
    }

    fn any_on(&self) -> bool {
        (0..2).any(|b| (0..8).any(|c| self.width(b, c) > 0))
    }

    fn reset(&mut self, board: usize) {
        self.registers[board] = [0; 256];
        self.registers[board][0] = 0x11;
        for channel in 0..16 {
            self.registers[board][9 + 4 * channel] = 0x10;
        }
    }
}

#[derive(Clone, Debug)]
struct Shared(Rc<RefCell<Chips>>);

#[derive(Debug)]
struct Dead;

impl Error for Dead {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl ErrorType for Shared {
    type Error = Dead;
}

impl I2c for Shared {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Dead> {
        let mut chips = self.0.borrow_mut();
        if chips.dead {
            return Err(Dead);
        }
        let boards = match address {
            0x70 => 0..2,
            0x40 | 0x41 => usize::from(address - 0x40)..usize::from(address - 0x3F),
            _ => return Err(Dead),
        };
        for board in boards {
            let mut pointer = 0;
            for operation in operations.iter_mut() {
                match operation {
                    Operation::Write(bytes) => {
                        pointer = usize::from(bytes[0]);
                        for byte in &bytes[1..] {
                            chips.registers[board][pointer] = *byte;
                            if pointer == 0xFD {
                                (0..16).for_each(|c| chips.registers[board][9 + 4 * c] = *byte);
                            }
                            pointer += 1;
                        }
                    }
                    Operation::Read(bytes) => {
                        for byte in bytes.iter_mut() {
                            *byte = chips.registers[board][pointer];
                            pointer += 1;
                        }
                    }
                }
            }
        }
        Ok(())
    }
}

impl PinErrorType for Shared {
    type Error = PinError;
}

impl OutputPin for Shared {
    fn set_low(&mut self) -> Result<(), PinError> {
        self.0.borrow_mut().cut = false;
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), PinError> {
        let mut chips = self.0.borrow_mut();
        chips.cut = !chips.unwired;
        chips.cut.then_some(()).ok_or(PinError::Other)
    }
}

#[derive(Debug, Default)]
struct Air {
    there: VecDeque<Vec<u8>>,
    back: VecDeque<Vec<u8>>,
}

impl Datagrams for Air {
    type Peer = ();

    fn receive(&mut self, buffer: &mut Buffer) -> Option<(usize, ())> {
        let datagram = self.there.pop_front()?;
        buffer[..datagram.len()].copy_from_slice(&datagram);
        Some((datagram.len(), ()))
    }

    fn send(&mut self, datagram: &[u8], (): ()) {
        self.back.push_back(datagram.to_vec());
    }
}

fn wires() -> Vec<DisplayWire> {
    let wire = |n: u8| DisplayWire {
        place: Point::new(f32::from(n), 0.0),
        board: Board(n / 8),
        channel: Channel(n % 8),
    };
    (0..16).map(wire).collect()
}

fn settings<'a>(wires: &'a [DisplayWire], boot: u64) -> Settings<'a> {
    Settings {
        key: &KEY,
        boot,
        wires,
        addresses: &[0x40, 0x41],
        limits: HARD,
        plant: Plant::default(),
        worn: None,
        converters: None,
    }
}

/// Both ends. Host time is `now`; the unit's is five seconds ahead.
struct Rig {
    chips: Shared,
    unit: Unit<Shared, Shared>,
    air: Air,
    driver: UnitDriver,
    guard: Guard,
    now: u64,
    reading: u64,
    /// The network is cut.
    cut: bool,
    /// The host is dead.
    killed: bool,
    /// Every datagram to the unit.
    seen: Vec<Vec<u8>>,
}

const AHEAD: u64 = 5_000_000;

impl Rig {
    fn new() -> Self {
        let (chips, wires) = (Shared::default(), wires());
        let unit = Unit::new(&settings(&wires, 77), chips.clone(), chips.clone());
        let mut rig = Self {
            unit: unit.unwrap(),
            chips,
            air: Air::default(),
            driver: driver(1, true),
            guard: Guard::new(HARD, Plant::default(), &wires, WornWire::default()).unwrap(),
            now: 0,
            reading: 0,
            cut: false,
            killed: false,
            seen: Vec::new(),
        };
        rig.unit.start(Instant::from_micros(AHEAD));
        rig
    }

    fn unit_now(&self) -> Instant {
        Instant::from_micros(self.now + AHEAD)
    }

    /// A step of time; `read` says whether the skin is alive.
    fn step(&mut self, read: bool) {
        self.now += STEP;
        let now = Instant::from_micros(self.now);
        if read {
            self.reading = self.now;
        }
        let mut buffer = [0; MOST];
        let reading = Some(Instant::from_micros(self.reading));
        if !self.killed
            && let Some(datagram) = self.driver.datagram(now, reading, &mut buffer)
        {
            self.seen.push(datagram.to_vec());
            if !self.cut {
                self.air.there.push_back(datagram.to_vec());
            }
        }
        let unit_now = self.unit_now();
        self.unit.turn(unit_now, &mut self.air);
        while let Some(mut datagram) = self.air.back.pop_front() {
            if !self.cut && !self.killed {
                let _ = self.driver.hear(now, &mut datagram);
            }
        }
    }

    fn run(&mut self, ms: u64, read: bool) {
        (0..ms * 1000 / STEP).for_each(|_| self.step(read));
    }

    /// Asks for a burst of 38 ms of some wires of a board.
    fn burst(&mut self, board: u8, wires: &[u16], width: u16) {
        let at = Instant::from_micros(self.now);
        let stimulus = |wire: &u16| Stimulus {
            wire: *wire,
            width: Ticks::new(width),
            peak: Milliamps(990),
            at,
            until: at + Duration::from_millis(38),
        };
        let stimuli: Vec<_> = wires.iter().map(stimulus).collect();
        self.guard.hear(at);
        let update = self.guard.admit(at, Board(board), &stimuli, |_| ());
        let _ = self.driver.apply(&update);
    }

    fn any_on(&self) -> bool {
        self.chips.0.borrow().any_on()
    }
}

fn driver(nonce: u64, resumes: bool) -> UnitDriver {
    UnitDriver::new(
        &KEY,
        nonce,
        UnitSettings {
            delay: DELAY,
            resumes,
        },
    )
}

mod hostile;
mod overrun;
mod sessions;

#[test]
fn a_burst_begins_and_ends_at_its_time() {
    let mut rig = Rig::new();
    rig.run(50, true);
    assert_eq!(rig.driver.ready(Instant::from_micros(rig.now)), Ok(()));
    let from = rig.now;
    rig.burst(0, &[3], 100);
    let (mut on, mut phases) = (Vec::new(), BTreeSet::new());
    for _ in 0..500 {
        rig.step(true);
        if rig.chips.0.borrow().width(0, 3) > 0 {
            on.push(rig.now - from);
            phases.insert(rig.driver.status().unwrap().phase_us[0]);
        }
    }
    assert_eq!(rig.chips.0.borrow().width(0, 2), 0);
    // A report each 10 ms, of a period of 5.08 ms that began with the first pulse.
    phases.remove(&HELD);
    assert!(
        phases.len() >= 3 && phases.iter().all(|us| *us < 5080),
        "{phases:?}"
    );
    let (first, last) = (on[0], on[on.len() - 1]);
    assert!((20_000..=20_000 + 2 * STEP).contains(&first), "{first}");
    assert!(
        (58_000 - 2 * STEP..=58_000 + STEP).contains(&last),
        "{last}"
    );
    let status = rig.driver.status().unwrap();
    assert_eq!((status.applied, status.limited, status.dropped), (1, 0, 0));
    assert!(u64::from(status.late_us) <= STEP);
    assert_eq!(status.phase_us, [HELD; 16]);
}

#[test]
fn commands_that_are_lost_cost_nothing() {
    let mut rig = Rig::new();
    rig.run(50, true);
    rig.cut = true;
    rig.burst(0, &[3], 100);
    rig.run(10, true);
    rig.cut = false;
    rig.run(30, true);
    assert!(rig.any_on());
    assert_eq!(rig.driver.status().unwrap().applied, 1);
}

#[test]
fn an_update_ends_what_another_began() {
    let mut rig = Rig::new();
    rig.run(50, true);
    rig.burst(0, &[3, 4], 100);
    rig.run(10, true);
    rig.burst(0, &[4], 100);
    rig.run(15, true);
    assert!(rig.chips.0.borrow().width(0, 3) > 0);
    rig.run(8, true);
    assert_eq!(rig.chips.0.borrow().width(0, 3), 0);
    assert!(rig.chips.0.borrow().width(0, 4) > 0);
}

#[test]
fn outputs_are_off_100_ms_after_the_reading_and_on_again_after_the_next() {
    let mut rig = Rig::new();
    rig.run(50, true);
    let last = rig.reading;
    let mut longest = 0;
    for n in 0..4000u64 {
        // A wire after the other: the burst row alone would let them go on.
        if n % 200 == 0 {
            rig.burst(0, &[n as u16 / 200 % 8], 100);
        }
        rig.step(false);
        if rig.any_on() {
            longest = rig.now - last;
        }
    }
    assert!((80_000..=100_000).contains(&longest), "{longest}");
    let stopped = State::Stopped(Cause::StaleInput);
    assert_eq!(rig.driver.status().unwrap().state, stopped);
    rig.run(20, true);
    assert_eq!(rig.driver.status().unwrap().state, State::Ready);
    rig.burst(0, &[1], 100);
    rig.run(30, true);
    assert!(rig.any_on());
}

#[test]
fn a_dead_bus_is_cut_by_the_pin_and_comes_back() {
    let mut rig = Rig::new();
    rig.run(50, true);
    rig.burst(1, &[8], 100);
    rig.run(30, true);
    assert!(rig.any_on());
    rig.chips.0.borrow_mut().dead = true;
    rig.run(35, true);
    assert!(rig.chips.0.borrow().cut);
    let stopped = State::Stopped(Cause::ActuatorError);
    assert_eq!(rig.driver.status().unwrap().state, stopped);
    rig.chips.0.borrow_mut().dead = false;
    rig.run(50, true);
    assert!(!rig.chips.0.borrow().cut);
    rig.burst(1, &[9], 100);
    rig.run(30, true);
    assert!(rig.any_on());
}

#[test]
fn a_chip_that_fell_back_is_found_and_set_up_anew() {
    let mut rig = Rig::new();
    rig.run(300, true);
    rig.chips.0.borrow_mut().reset(0);
    rig.run(600, true);
    rig.burst(0, &[0], 100);
    rig.run(30, true);
    assert!(rig.any_on());
    assert_eq!(rig.driver.status().unwrap().stops, 1);
}

#[test]
fn settings_that_cannot_be_are_refused_with_a_sentence() {
    let wires = wires();
    let good = settings(&wires, 1);
    let refused = |settings: &Settings<'_>| {
        let chips = Shared::default();
        Unit::new(settings, chips.clone(), chips)
            .map(drop)
            .unwrap_err()
    };
    let many = [0x40; 17];
    let set = |addresses: &'static [u8]| Settings {
        converters: Some(Converters {
            addresses,
            control: CONTROL,
        }),
        ..good
    };
    let beyond = [DisplayWire {
        channel: Channel(8),
        ..wires[0]
    }];
    let chips = Shared::default();
    assert!(Unit::new(&set(&[0x48, 0x49]), chips.clone(), chips).is_ok());
    for (settings, error, word) in [
        (
            Settings {
                addresses: &[0x40, 0x40],
                ..good
            },
            SettingsError::SameAddress(0x40),
            "twice",
        ),
        (
            Settings {
                addresses: &many,
                ..good
            },
            SettingsError::Boards(17),
            "1 to 16",
        ),
        (
            Settings {
                addresses: &[],
                ..good
            },
            SettingsError::Boards(0),
            "1 to 16",
        ),
        (
            Settings {
                addresses: &[0x40],
                ..good
            },
            SettingsError::NoSuchOutput(Board(1), Channel(0)),
            "channel 0 of board 1",
        ),
        (set(&[0x48]), SettingsError::Converters(1), "found 1"),
        (
            set(&[0x48, 0x41]),
            SettingsError::SameAddress(0x41),
            "0x41 twice",
        ),
        (
            Settings {
                wires: &beyond,
                ..set(&[0x48, 0x49])
            },
            SettingsError::NoSuchOutput(Board(0), Channel(8)),
            "0 to 7 beside a converter",
        ),
    ] {
        let found = refused(&settings);
        assert_eq!(found, error);
        assert!(alloc::string::ToString::to_string(&found).contains(word));
    }
}
