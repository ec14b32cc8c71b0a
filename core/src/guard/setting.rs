//! The setting of a channel.

/// The setting of one channel from now on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setting {
    /// Tick at which the pulse starts in each period.
    pub on: u16,
    /// Tick at which the pulse ends; equal to `on` for a channel that is off.
    pub off: u16,
}

impl Setting {
    /// Ticks of a period that the channel is on for.
    pub(super) const fn width(&self) -> u16 {
        self.off.saturating_sub(self.on)
    }

    /// Returns true if the pulses of two channels of one board are never on together.
    pub(super) const fn is_apart(&self, other: &Self) -> bool {
        self.off <= other.on || other.off <= self.on
    }
}
