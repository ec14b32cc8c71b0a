//! Answer of a publisher to a wearer: the time at which it heard it. By this the wearer's machine knows how old
//! readings can be.

use palpate_records::mcap::{Described, Visit};

/// An answer to one message of a wearer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Echo {
    /// Version of the messages.
    pub version: u32,
    /// The publisher's session.
    pub session: u64,
    /// The wearer's session.
    pub wearer: u64,
    /// Time of the wearer's message, microseconds of the wearer's clock.
    pub said_us: u64,
    /// Time at which the message was heard, microseconds of the publisher's clock.
    pub heard_us: u64,
}

impl<'a> Described<'a> for Echo {
    const NAME: &'static str = "Echo";

    fn fields(&mut self, visit: &mut impl Visit<'a>) {
        visit.whole("version", &mut self.version);
        visit.whole("session", &mut self.session);
        visit.whole("wearer", &mut self.wearer);
        visit.whole("said_us", &mut self.said_us);
        visit.whole("heard_us", &mut self.heard_us);
    }
}
