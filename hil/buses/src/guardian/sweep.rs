//! Switches every board of every bus off, side by side, and reads back.

use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

use palpate_core::codec::drv2605;

use super::WatchedBus;
use super::hand::Hand;
use super::outputs::{Channels, Report, Why};
use crate::i2c::{Adapter, AdapterError, LinuxAdapter};
use crate::pacer::RunClock;

/// Time between two tries of a bus that does not answer.
const PAUSE: palpate_core::units::Duration = palpate_core::units::Duration::from_millis(10);

/// State in which a board was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoardFound {
    /// The adapter's node.
    pub bus: PathBuf,
    /// The address of the board, or of the switch before drivers of motors.
    pub address: u8,
    /// Channels of the board, or the reason why they could not be read.
    pub seen: Result<Channels, String>,
}

impl BoardFound {
    /// Tells whether the board drove an output when it was read, or until it was switched off just before.
    pub fn was_driving(&self) -> bool {
        let seen = self.seen.as_ref();
        seen.is_ok_and(|seen| seen.driving | seen.drove != 0)
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
        if self.was_driving() {
            write!(
                out,
                "was driving channels {}",
                list(seen.driving | seen.drove)
            )
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
    hands: Vec<Hand>,
}

impl Sweeper {
    /// Opens the adapters. Nothing is sent.
    ///
    /// # Errors
    /// [`AdapterError`] for the first adapter that cannot be used.
    pub fn open(buses: &[WatchedBus]) -> Result<Self, AdapterError> {
        let (sweeper, missing) = Self::open_some(buses);
        missing.into_iter().next().map_or(Ok(sweeper), Err)
    }

    /// Opens the adapters that can be used, and returns the errors of the others.
    pub fn open_some(buses: &[WatchedBus]) -> (Self, Vec<AdapterError>) {
        let mut missing = Vec::new();
        let opened = buses.iter().filter_map(|bus| {
            let adapter = LinuxAdapter::open(&bus.path, &bus.addresses());
            let adapter = adapter.map(|adapter| (bus.clone(), Box::new(adapter) as _));
            adapter.map_err(|error| missing.push(error)).ok()
        });
        let opened: Vec<(WatchedBus, Box<dyn Adapter>)> = opened.collect();
        let (sweeper, without) = Self::over(opened);
        missing.extend(without);
        (sweeper, missing)
    }

    /// A sweeper over adapters that are open already, and the errors of those that get no thread.
    pub fn over(lines: Vec<(WatchedBus, Box<dyn Adapter>)>) -> (Self, Vec<AdapterError>) {
        let mut missing = Vec::new();
        let hand = |(bus, adapter): (WatchedBus, Box<dyn Adapter>)| {
            let path = bus.path.display().to_string();
            let without = |error: std::io::Error| AdapterError {
                path,
                reason: format!("no thread for it: {error}"),
            };
            let hand = Hand::new(bus, adapter).map_err(without);
            hand.map_err(|error| missing.push(error)).ok()
        };
        let hands = lines.into_iter().filter_map(hand).collect();
        (Self { hands }, missing)
    }

    /// The adapters, one by one.
    pub(super) fn into_hands(self) -> Vec<Hand> {
        self.hands
    }

    /// Reads every board and changes nothing. An adapter that has not answered within `patience` is waited for no longer.
    pub fn look(&mut self, patience: Duration) -> Vec<BoardFound> {
        self.hands.iter().for_each(Hand::look);
        let reports = reports(&self.hands, patience);
        found(&self.hands, &reports)
    }

    /// Switches everything off, all buses at once, sets every current that can be set to zero, and reads back, again
    /// until it succeeds or `patience` is over. Returns the boards as they were found, and the reason for each adapter
    /// that is not known to be off.
    pub fn off(&mut self, patience: Duration) -> (Vec<BoardFound>, Vec<String>) {
        let clock = RunClock::start();
        let mut all: Vec<Option<Report>> = self.hands.iter().map(|_| None).collect();
        let spent = || Duration::from_micros(clock.now().as_micros());
        self.hands.iter().for_each(Hand::off);
        loop {
            let newest = reports(&self.hands, patience.saturating_sub(spent()));
            for (report, newest) in all.iter_mut().zip(newest) {
                *report = newest.or(report.take());
            }
            let left = |report: &Option<Report>| report.as_ref().is_none_or(|r| r.off.is_err());
            if spent() >= patience || !all.iter().any(left) {
                break;
            }
            clock.sleep_until(clock.now() + PAUSE);
            let again = self
                .hands
                .iter()
                .zip(&all)
                .filter(|(_, report)| left(report));
            again.for_each(|(hand, _)| hand.off());
        }
        let reasons = self.hands.iter().zip(&all).filter_map(|(hand, report)| {
            let why = report.as_ref().map_or(Err(Why::Waits), |report| report.off);
            let why = why.err()?;
            Some(format!("{}, {why}", hand.bus().path.display()))
        });
        (found(&self.hands, &all), reasons.collect())
    }
}

/// Reports of each adapter's last order, waited for until `patience` is over.
fn reports(hands: &[Hand], patience: Duration) -> Vec<Option<Report>> {
    let clock = RunClock::start();
    let left = || patience.saturating_sub(Duration::from_micros(clock.now().as_micros()));
    hands.iter().map(|hand| hand.wait(left())).collect()
}

/// The boards of all adapters; those of one that has not answered are not known.
pub(super) fn found(hands: &[Hand], reports: &[Option<Report>]) -> Vec<BoardFound> {
    let of = |(hand, report): (&Hand, &Option<Report>)| -> Vec<BoardFound> {
        let board = |address: u8, seen: Result<Channels, String>| BoardFound {
            bus: hand.bus().path.clone(),
            address,
            seen,
        };
        match report {
            Some(report) => {
                let boards = report.found.iter();
                let words = |why: Why| why.to_string();
                boards
                    .map(|(address, seen)| board(*address, seen.map_err(words)))
                    .collect()
            }
            None => {
                let motors = hand.bus().motors.iter();
                let switches = motors.map(|behind| behind.map_or(drv2605::ADDRESS, |own| own.0));
                let mut boards = hand.bus().boards.clone();
                boards.extend(switches);
                boards.dedup();
                let boards = boards.into_iter();
                boards
                    .map(|address| board(address, Err(Why::Waits.to_string())))
                    .collect()
            }
        }
    };
    hands.iter().zip(reports).flat_map(of).collect()
}
