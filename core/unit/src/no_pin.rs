//! Stand-in for the pin that cuts all outputs, where a unit has none.

use embedded_hal::digital::{ErrorKind, ErrorType, OutputPin};

/// The OE pin of a unit that has none wired: a dead bus then ends with the hardware watchdog alone. It cuts nothing, and
/// says so.
#[derive(Clone, Copy, Debug)]
pub struct NoPin;

impl ErrorType for NoPin {
    type Error = ErrorKind;
}

impl OutputPin for NoPin {
    fn set_low(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), ErrorKind> {
        Err(ErrorKind::Other)
    }
}
