//! Failures of an I2C transfer on Linux, told apart by errno (Documentation/i2c/fault-codes.rst, and the habits of
//! drivers).

use std::fmt;

use embedded_hal::i2c::{Error as I2cError, ErrorKind, NoAcknowledgeSource};
use nix::errno::Errno;

/// The kinds of failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// `ENXIO`: no chip acknowledged the address.
    NoAddress,
    /// `EREMOTEIO`: a chip refused, address or data; which one the adapter does not say.
    Refused,
    /// `EAGAIN`: another master won.
    ArbitrationLost,
    /// `EBUSY`: the bus or adapter is busy, or a kernel driver holds the address.
    Busy,
    /// `ETIMEDOUT`: the adapter gave up; a line is held low, or a chip stretches the clock for too long.
    TimedOut,
    /// `EIO`: the adapter tells no more than that.
    Disturbed,
    /// `ENODEV`, `ESHUTDOWN`, `EPIPE`, `ENOENT`: the adapter is gone.
    Gone,
    /// `EOPNOTSUPP`, `EINVAL`: the adapter cannot do this transfer.
    Unsupported,
    /// The adapter has not answered within this program's own limit; the transfer may still happen.
    Stuck,
    /// Anything else.
    Other(Errno),
}

impl From<Errno> for FaultKind {
    fn from(errno: Errno) -> Self {
        match errno {
            Errno::ENXIO => Self::NoAddress,
            Errno::EREMOTEIO => Self::Refused,
            Errno::EAGAIN => Self::ArbitrationLost,
            Errno::EBUSY => Self::Busy,
            Errno::ETIMEDOUT => Self::TimedOut,
            Errno::EIO | Errno::EPROTO | Errno::EBADMSG => Self::Disturbed,
            Errno::ENODEV | Errno::ESHUTDOWN | Errno::EPIPE | Errno::ENOENT | Errno::ENOTCONN => {
                Self::Gone
            }
            Errno::EOPNOTSUPP | Errno::EINVAL | Errno::ENOTTY => Self::Unsupported,
            other => Self::Other(other),
        }
    }
}

/// A transfer that failed: its bus, its chip, and the kind of failure.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{bus}, address {address:#04x}: {}", self.kind.words(*address))]
pub struct Fault {
    /// The device node.
    pub bus: String,
    /// The chip's address.
    pub address: u8,
    /// Kind of the failure.
    pub kind: FaultKind,
}

/// The words of a [`FaultKind`] about a chip, written without memory of their own.
pub struct FaultWords(FaultKind, u8);

impl FaultKind {
    /// Words of the failure of a transfer with the chip of this address, with the way out.
    pub const fn words(self, address: u8) -> FaultWords {
        FaultWords(self, address)
    }
}

impl fmt::Display for FaultWords {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self.0 {
            FaultKind::NoAddress => {
                "no chip answers (ENXIO); check wiring, power and address straps"
            }
            FaultKind::Refused => {
                "the transfer was not acknowledged (EREMOTEIO); check wiring and power"
            }
            FaultKind::ArbitrationLost => "another master took the bus (EAGAIN)",
            FaultKind::Busy => {
                return write!(
                    out,
                    "busy (EBUSY); a kernel driver may hold the address: see /sys/bus/i2c/devices/*-00{:02x}/driver",
                    self.1
                );
            }
            FaultKind::TimedOut => {
                "the adapter gave up (ETIMEDOUT); is SDA or SCL held low, are the pull-ups there?"
            }
            FaultKind::Disturbed => "the transfer failed (EIO); check wiring and supply",
            FaultKind::Gone => "the adapter is gone; plug it in again",
            FaultKind::Unsupported => {
                "the adapter cannot do this transfer; `i2cdetect -F` shows what it can"
            }
            FaultKind::Stuck => "no answer from the adapter in time",
            FaultKind::Other(errno) => return write!(out, "{} ({errno:?})", errno.desc()),
        })
    }
}

impl I2cError for FaultKind {
    /// Kind of the error. Only failures that may pass by themselves are of a kind that the driver tries again at once.
    fn kind(&self) -> ErrorKind {
        match self {
            Self::NoAddress => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address),
            Self::Refused => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Unknown),
            Self::ArbitrationLost => ErrorKind::ArbitrationLoss,
            Self::Busy | Self::Disturbed => ErrorKind::Bus,
            _ => ErrorKind::Other,
        }
    }
}

impl I2cError for Fault {
    fn kind(&self) -> ErrorKind {
        self.kind.kind()
    }
}

#[cfg(test)]
#[path = "fault_tests.rs"]
mod tests;
