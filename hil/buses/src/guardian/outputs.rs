//! Outputs of one adapter, boards of wires or drivers of motors: everything off, and what is read back. Nothing here
//! allocates once it is made.

use std::io;

use arrayvec::ArrayVec;
use palpate_core::codec::drv2605;
use palpate_core::driver::{
    Actuators, DriverError, HapticCalibration, HapticChannel, HapticMotor, Haptics, Pca9685Bank,
};
use palpate_core::units::{Milliamps, Prescale};

use super::WatchedBus;
use crate::i2c::{Adapter, Direct, FaultKind};

/// Most boards of a bus.
const BOARDS: usize = 16;

/// Reasons why the state of a bus is unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Why {
    /// A transfer failed.
    #[error("address {0:#04x}: {words}", words = .1.words(*.0))]
    Bus(u8, FaultKind),
    /// A board reads back as on.
    #[error("address {0:#04x}: reads back as on")]
    On(u8),
    /// The driver found another error.
    #[error(transparent)]
    Driver(DriverError),
    /// The program failed.
    #[error("switching off has failed within the program")]
    Failed,
    /// No answer has come yet.
    #[error("the adapter has not answered yet")]
    Waits,
}

/// Channels of a board, or of a switch before drivers of motors, a bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Channels {
    /// Those that drove an output when they were read.
    pub driving: u16,
    /// Those that did until the board was switched off just before.
    pub drove: u16,
    /// Those and the ones that only sleep kept from driving.
    pub loaded: u16,
}

/// Address of a board, and its channels as they were found.
pub(super) type Looked = (u8, Result<Channels, Why>);

/// Result of an order.
#[derive(Clone, Debug)]
pub(super) struct Report {
    /// `Ok` where everything is known to be off, else the reason. After a look alone, `Ok` where all boards answered.
    pub(super) off: Result<(), Why>,
    /// The boards, as they were read.
    pub(super) found: ArrayVec<Looked, BOARDS>,
}

impl Report {
    const fn new() -> Self {
        Self {
            off: Ok(()),
            found: ArrayVec::new_const(),
        }
    }

    /// Adds channels of a board; an error of one of them is the board's.
    fn add(&mut self, address: u8, seen: Result<Channels, Why>) {
        match self.found.iter_mut().find(|(own, _)| *own == address) {
            Some((_, all)) => {
                *all = all.and_then(|all| {
                    let seen = seen?;
                    Ok(Channels {
                        driving: all.driving | seen.driving,
                        drove: all.drove | seen.drove,
                        loaded: all.loaded | seen.loaded,
                    })
                });
            }
            None => self.found.push((address, seen)),
        }
    }
}

type Bus = Direct<Box<dyn Adapter>>;

/// Boards of wires, or drivers of motors.
enum Kind {
    /// PCA9685 chips, with their addresses.
    Boards(Pca9685Bank<Bus>, ArrayVec<u8, BOARDS>),
    /// DRV2605L chips, with the address and channel under which each is found.
    Motors(Haptics<Bus>, ArrayVec<(u8, u8), BOARDS>),
}

/// Everything that one adapter drives.
pub(super) struct Outputs(Kind);

impl Outputs {
    /// Outputs of a bus. Nothing is sent.
    ///
    /// # Errors
    /// Places at which no drivers of motors can be.
    pub(super) fn new(bus: &WatchedBus, adapter: Box<dyn Adapter>) -> io::Result<Self> {
        let direct = Direct::new(adapter);
        Ok(Self(match &*bus.motors {
            [] => {
                // Switching off and reading back need neither PRE_SCALE nor full scale.
                let bank = Pca9685Bank::new(direct, &bus.boards, Prescale::MIN);
                let bank = bank.with_converters(&bus.converters, Milliamps(0));
                Kind::Boards(bank, bus.boards.iter().copied().take(BOARDS).collect())
            }
            motors => {
                let place = |behind: &Option<_>| behind.unwrap_or((drv2605::ADDRESS, 0));
                let haptics = haptics(direct, motors)?;
                let places = motors.iter().map(place).take(BOARDS).collect();
                Kind::Motors(haptics, places)
            }
        }))
    }

    /// Lets the adapter rest.
    pub(super) fn rest(&mut self) {
        match &mut self.0 {
            Kind::Boards(bank, _) => bank.bus_mut().rest(),
            Kind::Motors(haptics, _) => haptics.bus_mut().rest(),
        }
    }

    /// Switches everything off, sets every current that can be set to zero, and reads back.
    pub(super) fn off(&mut self) -> Report {
        let said = match &mut self.0 {
            Kind::Boards(bank, _) => {
                let off = bank.all_off();
                // A board that does not answer keeps no other one unread.
                let mut report = self.look(true);
                let zero = self.zero();
                report.off = off
                    .map_err(|error| self.why(error))
                    .and(zero)
                    .and(report.off);
                if report.off.is_ok() {
                    self.forget();
                }
                return report;
            }
            Kind::Motors(haptics, places) => silence(haptics, places),
        };
        let mut report = self.look(true);
        report.off = said.off.and(report.off);
        // What could not be read before has been read since, or is an error already.
        for (address, seen) in said.found.into_iter().filter(|(_, seen)| seen.is_ok()) {
            report.add(address, seen);
        }
        report
    }

    /// Confirms that every current that can be set is zero.
    fn zero(&mut self) -> Result<(), Why> {
        let Kind::Boards(bank, _) = &mut self.0 else {
            return Ok(());
        };
        let zero = bank.numbers().map(|board| bank.confirm_zero(board));
        let zero = zero.fold(Ok(()), Result::and);
        zero.map_err(|error| self.why(error))
    }

    /// Takes the traces of old pulses off boards that are off: they only tell which outputs were on.
    fn forget(&mut self) {
        if let Kind::Boards(bank, _) = &mut self.0 {
            for board in bank.numbers() {
                let _ = bank.forget_pulses(board);
            }
        }
    }

    /// Reads every board; with `off`, a board that drives an output is wrong.
    pub(super) fn look(&mut self, off: bool) -> Report {
        let mut report = Report::new();
        let mut add = |address: u8, seen: Result<Channels, Why>, is_on: bool| {
            let known = match seen {
                Ok(_) if off && is_on => Err(Why::On(address)),
                other => other.map(|_| ()),
            };
            report.off = report.off.and(known);
            report.add(address, seen);
        };
        match &mut self.0 {
            Kind::Boards(bank, addresses) => {
                for (board, &address) in bank.numbers().zip(&*addresses) {
                    let seen = bank.look(board).map_err(|error| why(bank.bus(), error));
                    let is_on = seen.is_ok_and(|seen| seen.loaded != 0);
                    let channels = seen.map(|seen| Channels {
                        driving: seen.driving(),
                        drove: seen.drove(),
                        loaded: seen.loaded | seen.stopped,
                    });
                    add(address, channels, is_on);
                }
            }
            Kind::Motors(haptics, places) => {
                for (number, &place) in haptics.numbers().zip(&*places) {
                    let seen = motor(haptics, number, place);
                    add(place.0, seen, seen.is_ok_and(|seen| seen.driving != 0));
                }
            }
        }
        report
    }

    fn why(&self, error: DriverError) -> Why {
        match &self.0 {
            Kind::Boards(bank, _) => why(bank.bus(), error),
            Kind::Motors(haptics, _) => why(haptics.bus(), error),
        }
    }
}

/// Reason for an error, with what the adapter said of a transfer to a board.
fn why(bus: &Bus, error: DriverError) -> Why {
    match (error, bus.last_fault()) {
        (DriverError::Bus(..), Some((address, kind))) => Why::Bus(address, kind),
        _ => Why::Driver(error),
    }
}

/// Drivers of motors that are only looked at and switched off, which needs no settings of their own.
///
/// # Errors
/// Places at which no drivers can be.
pub(crate) fn haptics<I: embedded_hal::i2c::I2c>(
    i2c: I,
    motors: &[Option<(u8, u8)>],
) -> io::Result<Haptics<I>> {
    let channel = |behind: &Option<(u8, u8)>| HapticChannel {
        behind: *behind,
        motor: HapticMotor::Erm {
            rated_v: 1.0,
            overdrive_v: 1.0,
        },
        calibration: HapticCalibration {
            compensation: 0,
            back_emf: 0,
            gain: 0,
        },
    };
    let channels: Vec<HapticChannel> = motors.iter().map(channel).collect();
    Haptics::new(i2c, &channels).map_err(io::Error::other)
}

/// The state of one motor, as the channel of its switch.
fn motor(haptics: &mut Haptics<Bus>, number: u8, (_, channel): (u8, u8)) -> Result<Channels, Why> {
    let driving = haptics.is_driving(number).map_err(DriverError::Haptic);
    let channels = |is_on: bool| {
        let bit = u16::from(is_on) << (channel & 15);
        Channels {
            driving: bit,
            loaded: bit,
            ..Channels::default()
        }
    };
    driving.map(channels).map_err(Why::Driver)
}

/// Brings every motor to rest, each whatever the others answer. A level that was overwritten leaves no trace, so each driver
/// is read just before.
fn silence(haptics: &mut Haptics<Bus>, places: &[(u8, u8)]) -> Report {
    let mut report = Report::new();
    for (number, &place) in haptics.numbers().zip(places) {
        let seen = motor(haptics, number, place).map(|seen| Channels {
            driving: 0,
            drove: seen.driving,
            ..seen
        });
        report.add(place.0, seen);
        let off = haptics.silence(number);
        report.off = report
            .off
            .and(off.map_err(DriverError::Haptic).map_err(Why::Driver));
    }
    report
}
