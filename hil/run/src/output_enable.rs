//! The line that cuts a display's outputs.

use palpate_core::units::Instant;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::WornDisplay;

/// The line that cuts every output whatever the chips' registers say, and needs no bus.
pub trait OutputEnable {
    /// Releases it, or cuts.
    fn set_enabled(&self, now: Instant, enabled: bool);

    /// Whether outputs that it has cut are off: it is there, or they go off by themselves.
    fn cuts(&self) -> bool;

    /// How notes say that the outputs were cut, or that they could not be.
    fn words(&self) -> &'static str;
}

impl OutputEnable for WornDisplay {
    fn set_enabled(&self, now: Instant, enabled: bool) {
        self.set_outputs(Nanos::from(now), enabled);
    }

    fn cuts(&self) -> bool {
        true
    }

    fn words(&self) -> &'static str {
        "outputs off by the OE line"
    }
}
