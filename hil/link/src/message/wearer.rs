//! Message of a wearer's machine, ten times per second, and a publisher's answer when it is asked about itself.

use palpate_records::mcap::{Described, FieldKind, Visit};

/// Publishers that are named as refused at most.
const MOST_REFUSED: usize = 8;

/// Message of a wearer's machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wearer {
    /// Version of the messages.
    pub version: u32,
    /// The wearer's session.
    pub session: u64,
    /// Time of the message, microseconds of the wearer's clock.
    pub said_us: u64,
    /// The publisher's session that is felt; 0 for none.
    pub feels: u64,
    /// Sessions of publishers that are refused, because another is felt.
    pub refused: Vec<u64>,
    /// Reason for which the wearer's outputs are off for good; empty while they are not.
    pub stopped: String,
    /// Reason for which the newest refused frame was not felt; empty where all are felt.
    pub trouble: String,
}

impl<'a> Described<'a> for Wearer {
    const NAME: &'static str = "Wearer";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        // The loop may hold more than a message names.
        self.refused.truncate(MOST_REFUSED);
        visit.whole("version", &mut self.version);
        visit.whole("session", &mut self.session);
        visit.whole("said_us", &mut self.said_us);
        visit.whole("feels", &mut self.feels);
        visit.several(&mut self.refused, MOST_REFUSED, |visit, session| {
            visit.whole("refused", session);
        });
        visit.text("stopped", &mut self.stopped);
        visit.text("trouble", &mut self.trouble);
    }
}

/// Facts of a publisher.
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
    /// The scans of its reference, each a `Scanned`, for wearers that compress; empty where it sends contacts.
    pub rest: Vec<Vec<u8>>,
}

impl<'a> Described<'a> for About {
    const NAME: &'static str = "About";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.whole("version", &mut self.version);
        visit.whole("session", &mut self.session);
        visit.whole("layout", &mut self.layout);
        visit.text("layout_name", &mut self.layout_name);
        visit.text("scene", &mut self.scene);
        visit.text("kind", &mut self.kind);
        visit.several(&mut self.rest, usize::MAX, |visit, scan| {
            visit.data("rest", FieldKind::Bytes, scan);
        });
    }
}
