//! A scene's readings over a network: how late they come, and how many never.

use serde::Deserialize;

use super::error::FileError;
use super::source::Source;

/// The way of readings from the machine that takes them to the host; each scan of all modules is one message.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Stream {
    /// The shortest way, milliseconds.
    pub delay_ms: f64,
    /// What is added to it: evenly drawn from nothing to this, milliseconds.
    pub jitter_ms: f64,
    /// Share of messages that come `late_ms` later still.
    pub late: f64,
    /// How much later, milliseconds.
    pub late_ms: f64,
    /// Share of messages that never come.
    pub loss: f64,
}

impl Default for Stream {
    /// A quiet local network.
    fn default() -> Self {
        Self {
            delay_ms: 1.0,
            jitter_ms: 0.0,
            late: 0.0,
            late_ms: 100.0,
            loss: 0.0,
        }
    }
}

impl Stream {
    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        for (key, ms) in [
            ("stream.delay_ms", self.delay_ms),
            ("stream.jitter_ms", self.jitter_ms),
            ("stream.late_ms", self.late_ms),
        ] {
            source.range(key, ms, 0.0..=10_000.0, "ms")?;
        }
        source.range("stream.late", self.late, 0.0..=1.0, "")?;
        source.range("stream.loss", self.loss, 0.0..=0.99, "")
    }
}
