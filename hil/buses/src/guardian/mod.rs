//! The guardian: a process of its own that switches everything off when the run beside it dies or hangs.
//!
//! A PWM chip keeps driving its last pulses. Whatever ends a run, a process must be left to switch it off: SIGKILL, an
//! out-of-memory kill or a hung loop leave no working code in the run itself. Run and guardian are joined by a pair of
//! sockets. The run sends heartbeats; when they stop, or its end closes without a good-bye, the guardian cuts the OE
//! line, switches every board off, kills the rest of the run, switches off again
//!
//! `decide` makes decisions, `server` carries them out with a `hand` for each adapter, and `scribe` writes records and
//! words where nothing waits for them.

mod client;
mod decide;
mod hand;
mod latch;
mod outputs;
mod scribe;
mod server;
mod sweep;

pub use client::{Guardian, Lost, StartError};
pub use latch::{Armed, Latch, Latched, stops_folder};
pub(crate) use latch::{folder as state_folder, remedy};
pub use outputs::Channels;
pub(crate) use outputs::haptics;
pub use server::serve;
pub use sweep::{BoardFound, Sweeper};

use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

use palpate_core::codec::drv2605;

/// An I2C adapter with its boards.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WatchedBus {
    /// The device node.
    pub path: PathBuf,
    /// Addresses of the boards.
    pub boards: Vec<u8>,
    /// Addresses of the converters, board by board; empty where amplifiers have a current of their own.
    pub converters: Vec<u8>,
    /// Drivers of motors in place of boards: the switch before each, and its channel; `None` for one alone on the bus.
    pub motors: Vec<Option<(u8, u8)>>,
}

impl WatchedBus {
    /// Every address that is written to.
    pub fn addresses(&self) -> Vec<u8> {
        let switches = self.motors.iter().map(|behind| Some(behind.as_ref()?.0));
        let drivers = self.motors.first().map(|_| drv2605::ADDRESS);
        let mut motors: Vec<u8> = switches.flatten().chain(drivers).collect();
        motors.dedup();
        [&*self.boards, &*self.converters, &motors].concat()
    }
}

/// `PATH=40,41` or, with converters, `PATH=40,41+48,49`; with motors `PATH=70.0,70.1`, and `PATH=5a.0` for one alone.
impl fmt::Display for WatchedBus {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let list = |addresses: &[u8]| -> Vec<String> {
            addresses.iter().map(|a| format!("{a:02x}")).collect()
        };
        let motors = self.motors.iter().map(|behind| {
            let (address, channel) = behind.unwrap_or((drv2605::ADDRESS, 0));
            format!("{address:02x}.{channel}")
        });
        let boards = list(&self.boards).into_iter().chain(motors);
        let boards = boards.collect::<Vec<_>>().join(",");
        write!(out, "{}={boards}", self.path.display())?;
        match &*self.converters {
            [] => Ok(()),
            some => write!(out, "+{}", list(some).join(",")),
        }
    }
}

/// Hardware that a guardian guards, and its patience.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Watch {
    /// I2C adapters.
    pub buses: Vec<WatchedBus>,
    /// The GPIO line on the chips' OE pins: device and offset. High cuts.
    pub oe: Option<(PathBuf, u32)>,
    /// Silence after which the run counts as hung.
    pub heartbeat: Duration,
    /// Longest time of one I2C transfer.
    pub transfer: Duration,
}

impl Watch {
    /// The command line of the guardian process, after the program's name.
    pub fn arguments(&self) -> Vec<String> {
        let mut arguments = vec!["guardian".to_owned()];
        arguments.extend(self.buses.iter().map(|bus| format!("--i2c={bus}")));
        if let Some((chip, line)) = &self.oe {
            arguments.push(format!("--oe={}={line}", chip.display()));
        }
        arguments.push(format!("--heartbeat-ms={}", self.heartbeat.as_millis()));
        arguments.push(format!("--transfer-ms={}", self.transfer.as_millis()));
        arguments
    }
}

/// Reads `PATH=40,41+48,49` or `PATH=70.0,70.1` of [`Watch::arguments`].
///
/// # Errors
/// Words of the expected text.
pub fn parse_bus(text: &str) -> Result<WatchedBus, String> {
    let expected = || "expected PATH=ADDRESS,ADDRESS.. with addresses in hexadecimal".to_owned();
    let list = |text: &str| -> Result<Vec<u8>, String> {
        let addresses = text.split(',').map(|a| u8::from_str_radix(a, 16));
        addresses.collect::<Result<_, _>>().map_err(|_| expected())
    };
    let (path, chips) = text.rsplit_once('=').ok_or_else(expected)?;
    let motor = |text: &str| {
        let (address, channel) = text.split_once('.')?;
        let place = (u8::from_str_radix(address, 16).ok()?, channel.parse().ok()?);
        Some((place.0 != drv2605::ADDRESS).then_some(place))
    };
    if chips.contains('.') {
        let motors = chips.split(',').map(motor).collect::<Option<_>>();
        return Ok(WatchedBus {
            path: path.into(),
            boards: Vec::new(),
            converters: Vec::new(),
            motors: motors.ok_or_else(expected)?,
        });
    }
    let (boards, converters) = match chips.split_once('+') {
        Some((boards, converters)) => (boards, list(converters)?),
        None => (chips, Vec::new()),
    };
    Ok(WatchedBus {
        path: path.into(),
        boards: list(boards)?,
        converters,
        motors: Vec::new(),
    })
}

/// Reads `CHIP=LINE` of [`Watch::arguments`].
///
/// # Errors
/// Words of the expected text.
pub fn parse_line(text: &str) -> Result<(PathBuf, u32), String> {
    let parsed = text
        .rsplit_once('=')
        .and_then(|(chip, line)| Some((chip.into(), line.parse().ok()?)));
    parsed.ok_or_else(|| "expected CHIP=LINE".into())
}

/// Words between the two processes: one packet, whose first byte is the word.
mod word {
    /// Run to guardian: the loop is alive. Guardian to run: the guardian is alive.
    pub const BEAT: u8 = b'.';
    /// Run to guardian: boards are configured, the OE line may be released.
    pub const RELEASE: u8 = b'e';
    /// Run to guardian: cut the OE line.
    pub const CUT: u8 = b'c';
    /// Run to guardian: outputs are off and stay off until a person clears that; the cause follows.
    pub const STOP: u8 = b's';
    /// Run to guardian: a part of the outputs is off and stays off until a person clears that, the others go on; the
    /// cause follows.
    pub const LATCH: u8 = b'l';
    /// Run to guardian: everything is off, good-bye.
    pub const BYE: u8 = b'q';
    /// Run to guardian: the run cannot switch off any more; the cause follows.
    pub const TRIP: u8 = b'x';
    /// Guardian to run: everything is off; the boards that were found driving follow.
    pub const READY: u8 = b'R';
    /// Guardian to run: it cannot guard, or not everything is known to be off; the reason follows.
    pub const REFUSED: u8 = b'E';
    /// Guardian to run: it does not guard while an earlier stop is latched; the stop follows.
    pub const LATCHED: u8 = b'L';
    /// Guardian to run: it has switched everything off by itself, the run is to end; the cause follows.
    pub const HALT: u8 = b'h';
}

/// The longest packet: a report of 16 boards.
const PACKET: usize = 4096;

/// A packet: a word and its text.
fn packet(word: u8, text: &str) -> Vec<u8> {
    let mut packet = vec![word];
    packet.extend_from_slice(text.as_bytes());
    packet.truncate(PACKET);
    packet
}

#[cfg(test)]
mod tests;
