//! Errors of the bus: Linux's names for them, and embedded-hal's.

use embedded_hal::i2c::{Error as I2cError, ErrorKind, NoAcknowledgeSource};

/// A failed transaction, as the Linux I2C subsystem tells it (`Documentation/i2c/fault-codes.rst`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, thiserror::Error)]
pub enum Error {
    /// No device acknowledged the address (ENXIO).
    #[error("no device acknowledged the address (ENXIO)")]
    AddressNack,
    /// A data byte was not acknowledged (EREMOTEIO).
    #[error("a data byte was not acknowledged (EREMOTEIO)")]
    DataNack,
    /// Another controller won the bus (EAGAIN).
    #[error("arbitration lost to another controller (EAGAIN)")]
    ArbitrationLost,
    /// A device held SCL low for longer than the adapter waits (ETIMEDOUT).
    #[error("clock held low for too long (ETIMEDOUT)")]
    Timeout,
    /// SDA or SCL is stuck low (EBUSY).
    #[error("a bus line is stuck low (EBUSY)")]
    BusBusy,
    /// The adapter failed (EIO).
    #[error("the adapter failed (EIO)")]
    Io,
    /// The adapter cannot do this kind of transaction (EOPNOTSUPP).
    #[error("the adapter cannot do this transaction (EOPNOTSUPP)")]
    Unsupported,
}

impl Error {
    /// The Linux error number.
    pub const fn errno(self) -> i32 {
        match self {
            Self::AddressNack => 6,
            Self::DataNack => 121,
            Self::ArbitrationLost => 11,
            Self::Timeout => 110,
            Self::BusBusy => 16,
            Self::Io => 5,
            Self::Unsupported => 95,
        }
    }
}

impl I2cError for Error {
    /// Maps the numbers as linux-embedded-hal does, but for EREMOTEIO: linux-embedded-hal calls it `Other`, here it is
    /// a data byte without acknowledge.
    fn kind(&self) -> ErrorKind {
        match self {
            Self::AddressNack => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address),
            Self::DataNack => ErrorKind::NoAcknowledge(NoAcknowledgeSource::Data),
            Self::ArbitrationLost => ErrorKind::ArbitrationLoss,
            Self::BusBusy | Self::Io => ErrorKind::Bus,
            Self::Timeout | Self::Unsupported => ErrorKind::Other,
        }
    }
}
