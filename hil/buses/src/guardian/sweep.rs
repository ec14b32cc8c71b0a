//! Switching every board of every bus off and reading back that it is.

use std::fmt;
use std::path::PathBuf;
use std::thread;
use std::time::Duration;

use palpate_core::driver::Actuators;
use palpate_core::driver::{Pca9685Bank, Seen};
use palpate_core::units::{Milliamps, Prescale};

use super::WatchedBus;
use crate::i2c::{AdapterError, Blocking, LinuxAdapter};
use crate::pacer::RunClock;

/// Between two tries of a bus that does not answer.
const PAUSE: palpate_core::units::Duration = palpate_core::units::Duration::from_millis(20);

/// What a board was found doing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoardFound {
    /// The adapter's node.
    pub bus: PathBuf,
    /// The board's address.
    pub address: u8,
    /// Its registers, or why they could not be read.
    pub seen: Result<Seen, String>,
}

impl BoardFound {
    /// Whether it drove an output.
    pub fn was_driving(&self) -> bool {
        self.seen.as_ref().is_ok_and(|seen| seen.driving() != 0)
    }
}

impl fmt::Display for BoardFound {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} {:#04x}: ", self.bus.display(), self.address)?;
        let seen = match &self.seen {
            Ok(seen) => seen,
            Err(reason) => return out.write_str(reason),
        };
        let list = |bits: u16| {
            let on = (0..16).filter(|n| bits >> n & 1 == 1);
            on.map(|n| n.to_string()).collect::<Vec<_>>().join(",")
        };
        if seen.driving() != 0 {
            write!(out, "was driving channels {}", list(seen.driving()))
        } else if seen.loaded != 0 {
            write!(out, "was asleep with channels {} loaded", list(seen.loaded))
        } else {
            out.write_str("was off")
        }
    }
}

/// The boards of a bench with a bus each for the way out.
#[derive(Debug)]
pub struct Sweeper {
    banks: Vec<(WatchedBus, Pca9685Bank<Blocking>)>,
}

impl Sweeper {
    /// Opens the adapters; transfers that take longer than `limit` fail. Nothing is sent.
    ///
    /// # Errors
    /// [`AdapterError`] for the first adapter that cannot be used.
    pub fn open(buses: &[WatchedBus], limit: Duration) -> Result<Self, AdapterError> {
        let open = |bus: &WatchedBus| {
            let adapter = LinuxAdapter::open(&bus.path, &bus.addresses())?;
            let line = Blocking::new(adapter, limit).map_err(|e| AdapterError {
                path: bus.path.display().to_string(),
                reason: e.to_string(),
            })?;
            Ok((bus.clone(), line))
        };
        let lines = buses
            .iter()
            .map(open)
            .collect::<Result<Vec<_>, AdapterError>>()?;
        Ok(Self::over(lines))
    }

    /// Over lines that are open already.
    pub fn over(lines: Vec<(WatchedBus, Blocking)>) -> Self {
        // Switching off and reading back need neither PRE_SCALE nor full scale.
        let bank = |(bus, line): (WatchedBus, Blocking)| {
            let bank = Pca9685Bank::new(line, &bus.boards, Prescale::MIN);
            let bank = bank.with_converters(&bus.converters, Milliamps(0));
            (bus, bank)
        };
        Self {
            banks: lines.into_iter().map(bank).collect(),
        }
    }

    /// Reads every board and changes nothing.
    pub fn look(&mut self) -> Vec<BoardFound> {
        let mut found = Vec::new();
        for (bus, bank) in &mut self.banks {
            for (&address, board) in bus.boards.iter().zip(bank.numbers()) {
                let seen = bank.look(board).map_err(|error| {
                    let fault = bank.bus().last_fault();
                    fault.map_or_else(|| error.to_string(), ToString::to_string)
                });
                found.push(BoardFound {
                    bus: bus.path.clone(),
                    address,
                    seen,
                });
            }
        }
        found
    }

    /// [`Self::off`] until it succeeds, or fails after `patience`: an adapter may be slow to wake.
    ///
    /// # Errors
    /// In words, why not.
    pub fn off_within(&mut self, patience: Duration) -> Result<(), String> {
        let clock = RunClock::start();
        loop {
            let result = self.off();
            let spent = Duration::from_micros(clock.now().as_micros());
            if result.is_ok() || spent >= patience {
                return result;
            }
            clock.sleep_until(clock.now() + PAUSE);
        }
    }

    /// Everything off, all buses at once, then every current that is set to zero, and read back. `Err` names the first
    /// board that is not known to be off.
    ///
    /// # Errors
    /// In words, why.
    pub fn off(&mut self) -> Result<(), String> {
        let one = |(bus, bank): &mut (WatchedBus, Pca9685Bank<Blocking>)| {
            bank.all_off().map_err(|error| {
                let fault = bank.bus().last_fault();
                fault.map_or_else(|| error.to_string(), ToString::to_string)
            })?;
            for board in bank.numbers() {
                match bank.look(board) {
                    Ok(seen) if seen.loaded == 0 => {}
                    Ok(_) => {
                        return Err(format!(
                            "{}: board {} reads back as on",
                            bus.path.display(),
                            board.0
                        ));
                    }
                    Err(error) => return Err(error.to_string()),
                }
            }
            bank.numbers()
                .try_for_each(|board| bank.confirm_zero(board))
                .map_err(|error| format!("{}: {error}", bus.path.display()))
        };
        if let [only] = self.banks.as_mut_slice() {
            return one(only);
        }
        // A bus that is stuck must not keep the others on.
        thread::scope(|scope| {
            let started: Vec<_> = self
                .banks
                .iter_mut()
                .map(|bank| scope.spawn(move || one(bank)))
                .collect();
            let join = |t: thread::ScopedJoinHandle<'_, Result<(), String>>| {
                t.join()
                    .unwrap_or_else(|_| Err("switching off has failed within".into()))
            };
            started.into_iter().map(join).fold(Ok(()), Result::and)
        })
    }
}
