//! Readings of a scene over a network: their delay and loss.

use super::error::FileError;
use super::settings::{bounds, settings};
use super::source::Source;

settings! {
    /// The way of readings from the machine that takes them to the host; each scan of all modules is one message.
    #[derive(Copy)]
    pub struct Stream {
        /// The shortest way, milliseconds.
        pub delay_ms: f64 = 1.0,
        /// Delay added to it: evenly drawn from nothing to this, milliseconds.
        pub jitter_ms: f64 = 0.0,
        /// Share of messages that come `late_ms` later still.
        pub late: f64 = 0.0,
        /// Further delay of late messages, milliseconds.
        pub late_ms: f64 = 100.0,
        /// Share of messages that never come.
        pub loss: f64 = 0.0,
    }

    /// A quiet local network.
    default
}

impl Stream {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        bounds!(source, "stream", self;
            delay_ms: 0.0..=10_000.0, "ms";
            jitter_ms: 0.0..=10_000.0, "ms";
            late_ms: 0.0..=10_000.0, "ms";
            late: 0.0..=1.0;
            loss: 0.0..=0.99)
    }
}
