//! Transfers on an actuator bus.

/// One message of an I2C transfer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Transfer {
    /// START of the transfer that it is part of, nanoseconds since the start of the run.
    pub start_ns: u64,
    /// End of that transfer's STOP.
    pub end_ns: u64,
    /// Zero-based actuator bus.
    pub bus: u8,
    /// 7-bit address.
    pub address: u8,
    /// Direction: `true` from the chip.
    pub read: bool,
    /// Bytes after the address.
    pub data: Vec<u8>,
    /// Error of the transfer.
    pub error: Option<String>,
}
