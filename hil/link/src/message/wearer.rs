//! What a wearer's machine says, ten times per second; and what a publisher says of itself when it is asked.

use palpate_records::mcap::proto::Message;
use palpate_records::mcap::proto::Value;

use super::{VERSION, each, number, text};

/// Publishers that are named as refused at most.
const MOST_REFUSED: usize = 8;

/// What a wearer's machine says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wearer {
    /// Version of the messages.
    pub version: u32,
    /// The wearer's session.
    pub session: u64,
    /// When it was said, microseconds of the wearer's clock.
    pub said_us: u64,
    /// The publisher's session that is felt; 0 for none.
    pub feels: u64,
    /// Sessions of publishers that are refused, because another is felt.
    pub refused: Vec<u64>,
    /// Why the wearer's outputs are off for good; empty while they are not.
    pub stopped: String,
    /// Why the newest frame that was not felt was not; empty where all are.
    pub trouble: String,
}

impl Wearer {
    /// The message.
    #[must_use]
    pub fn write(&self) -> Message {
        let mut message = Message::default();
        message
            .uint(1, VERSION)
            .uint(2, self.session)
            .uint(3, self.said_us)
            .uint(4, self.feels);
        for session in self.refused.iter().take(MOST_REFUSED) {
            message.uint(5, *session);
        }
        message.text(6, &self.stopped).text(7, &self.trouble);
        message
    }

    /// Reads one; `None` where it is damaged.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let mut wearer = Self::default();
        each(bytes, |field, value| {
            match field {
                1 => wearer.version = u32::try_from(number(value)?).ok()?,
                2 => wearer.session = number(value)?,
                3 => wearer.said_us = number(value)?,
                4 => wearer.feels = number(value)?,
                5 if wearer.refused.len() < MOST_REFUSED => wearer.refused.push(number(value)?),
                6 => wearer.stopped = text(value)?,
                7 => wearer.trouble = text(value)?,
                _ => {}
            }
            Some(())
        })?;
        Some(wearer)
    }
}

/// What a publisher says of itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct About {
    /// Version of the messages.
    pub version: u32,
    /// The publisher's session.
    pub session: u64,
    /// Digest of the skin's layout.
    pub layout: u64,
    /// The layout's name.
    pub layout_name: String,
    /// The scene that touches it, or the recording.
    pub scene: String,
    /// `contacts` or `scans`.
    pub kind: String,
    /// The scans that its reference was made of, each a `Scanned`; for wearers that compress. Only where it sends scans.
    pub rest: Vec<Vec<u8>>,
}

impl About {
    /// The message.
    #[must_use]
    pub fn write(&self) -> Message {
        let mut message = Message::default();
        message
            .uint(1, VERSION)
            .uint(2, self.session)
            .uint(3, self.layout)
            .text(4, &self.layout_name)
            .text(5, &self.scene)
            .text(6, &self.kind);
        for scan in &self.rest {
            message.data(7, scan);
        }
        message
    }

    /// Reads one; `None` where it is damaged.
    #[must_use]
    pub fn read(bytes: &[u8]) -> Option<Self> {
        let mut about = Self::default();
        each(bytes, |field, value| {
            match (field, value) {
                (1, value) => about.version = u32::try_from(number(value)?).ok()?,
                (2, value) => about.session = number(value)?,
                (3, value) => about.layout = number(value)?,
                (4, value) => about.layout_name = text(value)?,
                (5, value) => about.scene = text(value)?,
                (6, value) => about.kind = text(value)?,
                (7, Value::Data(bytes)) => about.rest.push(bytes.to_vec()),
                _ => {}
            }
            Some(())
        })?;
        Some(about)
    }
}
