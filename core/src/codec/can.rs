//! Classic CAN data frames with an 11-bit identifier: all that the sensor boards use.

use embedded_can::{ExtendedId, Frame, Id, StandardId};

/// A classic CAN data frame, 11-bit identifier, up to eight bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CanFrame {
    id: u16,
    dlc: u8,
    data: [u8; 8],
}

impl CanFrame {
    /// A frame from its identifier (11 bits) and data (at most 8 bytes); `None` if either is too long.
    pub fn new(id: u16, data: &[u8]) -> Option<Self> {
        if id > StandardId::MAX.as_raw() || data.len() > 8 {
            return None;
        }
        let mut bytes = [0; 8];
        bytes[..data.len()].copy_from_slice(data);
        Some(Self {
            id,
            dlc: data.len() as u8,
            data: bytes,
        })
    }

    /// The 11-bit identifier.
    pub const fn id(&self) -> u16 {
        self.id
    }

    /// The data bytes, as many as the data length code says.
    #[inline]
    pub fn data(&self) -> &[u8] {
        &self.data[..usize::from(self.dlc)]
    }

    /// The data bytes with zeros behind them.
    #[inline]
    pub const fn padded(&self) -> [u8; 8] {
        self.data
    }
}

impl Frame for CanFrame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        match id.into() {
            Id::Standard(id) => Self::new(id.as_raw(), data),
            Id::Extended(_) => None,
        }
    }

    /// Always `None`: the boards use no remote frames.
    fn new_remote(_id: impl Into<Id>, _dlc: usize) -> Option<Self> {
        None
    }

    fn is_extended(&self) -> bool {
        false
    }

    fn is_remote_frame(&self) -> bool {
        false
    }

    fn id(&self) -> Id {
        // `new` refused anything over 11 bits.
        StandardId::new(self.id).map_or(Id::Extended(ExtendedId::ZERO), Id::Standard)
    }

    fn dlc(&self) -> usize {
        usize::from(self.dlc)
    }

    fn data(&self) -> &[u8] {
        self.data()
    }
}

#[cfg(test)]
#[path = "can_tests.rs"]
mod tests;
