//! What a publisher answers a wearer: when it heard it. By this the wearer's machine knows how old readings can be.

use palpate_records::mcap::proto::Message;

use super::{VERSION, each, number};

/// An answer to one message of a wearer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Echo {
    /// Version of the messages.
    pub version: u32,
    /// The publisher's session.
    pub session: u64,
    /// The wearer's session.
    pub wearer: u64,
    /// When the wearer said it, microseconds of its clock.
    pub said_us: u64,
    /// When it was heard, microseconds of the publisher's clock.
    pub heard_us: u64,
}

impl Echo {
    /// The message.
    #[must_use]
    pub fn write(&self) -> Message {
        let mut message = Message::default();
        message
            .uint(1, VERSION)
            .uint(2, self.session)
            .uint(3, self.wearer)
            .uint(4, self.said_us)
            .uint(5, self.heard_us);
        message
    }

    /// Reads one; `None` where it is damaged.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let mut echo = Self::default();
        each(bytes, |field, value| {
            match field {
                1 => echo.version = u32::try_from(number(value)?).ok()?,
                2 => echo.session = number(value)?,
                3 => echo.wearer = number(value)?,
                4 => echo.said_us = number(value)?,
                5 => echo.heard_us = number(value)?,
                _ => {}
            }
            Some(())
        })?;
        Some(echo)
    }
}
