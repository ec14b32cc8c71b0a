//! The line that cuts a display's outputs.

use palpate_core::units::Instant;
use palpate_emulators::time::Nanos;
use palpate_emulators::worn::WornDisplay;

/// The line that cuts every output whatever the chips' registers say, and needs no bus.
pub trait OutputEnable {
    /// Releases the line, or cuts the outputs.
    fn set_enabled(&self, now: Instant, enabled: bool);

    /// Tells whether outputs that were cut are off: the line is there, or they go off by themselves.
    fn cuts(&self) -> bool;

    /// Words of a note for outputs that were cut, or could not be.
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
