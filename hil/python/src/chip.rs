//! Emulated PCA9685 on an I2C bus, for drivers written in Python.

use embedded_hal::i2c::Operation;
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Edge, Hazard, Pca9685, Pin};
use palpate_emulators::time::Nanos;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

/// Errors of Linux as adapters give them.
const EIO: i32 = 5;
const EREMOTEIO: i32 = 121;

/// A bus with chips. Time passes with transactions, and with `advance`.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct I2cBus {
    bus: I2cHandle,
    addresses: Vec<u8>,
}

fn refused(what: &str) -> PyErr {
    PyOSError::new_err((EREMOTEIO, format!("Remote I/O error: {what}")))
}

/// A hazard in words.
const fn words(hazard: Hazard) -> &'static str {
    match hazard {
        Hazard::OutputEnableDrivesAll => "OE went high with OUTNE = 01: every output is driven",
        Hazard::RestartTooEarly => "RESTART was written before SLEEP had been clear for 500 us",
        Hazard::TestRegisterWritten => "the TESTMODE register was written",
    }
}

fn edges(found: &mut Vec<(u64, u8, u8, bool)>, addresses: &[u8], chip: usize, edge: &Edge) {
    let address = addresses.get(chip).copied().unwrap_or_default();
    let high = edge.pin == Pin::High;
    found.push((edge.at.0, address, edge.channel.0, high));
}

impl I2cBus {
    fn with<T>(&self, work: impl FnOnce(&mut I2cSegment) -> T) -> PyResult<T> {
        let busy = |_| PyOSError::new_err((EIO, "Input/output error: the bus is taken"));
        self.bus.with(work).map_err(busy)
    }
}

#[pymethods]
impl I2cBus {
    /// A bus of 400 kHz with a chip at each of these addresses (0x40 to 0x7F).
    #[new]
    fn new(addresses: Vec<u8>) -> Self {
        let chips = addresses.iter().map(|a| Pca9685::new(Config::new(*a)));
        let segment = I2cSegment::new(BusClock::Fast, chips.collect());
        Self {
            bus: I2cHandle::new(segment),
            addresses,
        }
    }

    /// Messages with repeated starts between and one stop: address, and bytes to write or how many to read. Returns
    /// what was read.
    fn transfer<'py>(
        &self,
        py: Python<'py>,
        messages: Vec<(u8, Option<Vec<u8>>, usize)>,
    ) -> PyResult<Vec<Bound<'py, PyBytes>>> {
        let mut read: Vec<Vec<u8>> = messages.iter().map(|m| vec![0; m.2]).collect();
        let result = self.with(|segment| {
            let parts = messages.iter().zip(&mut read);
            let mut all: Vec<(u8, Operation<'_>)> = parts
                .map(|((address, written, _), into)| match written {
                    Some(bytes) => (*address, Operation::Write(bytes)),
                    None => (*address, Operation::Read(into)),
                })
                .collect();
            segment.transfer(&mut all)
        })?;
        result.map_err(|e| refused(&format!("{e:?}")))?;
        let wanted = messages.iter().zip(&read).filter(|(m, _)| m.1.is_none());
        Ok(wanted.map(|(_, bytes)| PyBytes::new(py, bytes)).collect())
    }

    /// Lets time pass until `to_ns`; the edges of the outputs since the last call: time (ns), address, channel, high.
    fn advance(&self, to_ns: u64) -> PyResult<Vec<(u64, u8, u8, bool)>> {
        let mut found = Vec::new();
        self.with(|segment| {
            segment.advance(Nanos(to_ns), &mut |chip, edge| {
                edges(&mut found, &self.addresses, chip, &edge);
            });
        })?;
        found.sort_by_key(|edge| edge.0);
        Ok(found)
    }

    /// Virtual time, nanoseconds.
    fn now_ns(&self) -> PyResult<u64> {
        self.with(|segment| segment.now().0)
    }

    /// The outputs of the chip at an address: `high`, `low` or `floating`.
    fn pins(&self, address: u8) -> PyResult<Option<Vec<&'static str>>> {
        let chip = self.addresses.iter().position(|a| *a == address);
        let word = |pin: &Pin| match pin {
            Pin::High => "high",
            Pin::Low => "low",
            Pin::HighZ => "floating",
        };
        self.with(|segment| {
            let chip = segment.chips().get(chip?)?;
            Some(chip.pins().iter().map(word).collect())
        })
    }

    /// Hazards of the chip at an address: time (ns) and kind of each thing that should not have been done to it.
    fn hazards(&self, address: u8) -> PyResult<Vec<(u64, &'static str)>> {
        let chip = self.addresses.iter().position(|a| *a == address);
        self.with(|segment| {
            let chip = chip.and_then(|chip| segment.chips().get(chip));
            let hazards = chip.map_or(&[][..], Pca9685::hazards);
            hazards
                .iter()
                .map(|(at, what)| (at.0, words(*what)))
                .collect()
        })
    }
}
