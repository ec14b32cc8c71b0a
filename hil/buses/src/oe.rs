//! The OE line of the PWM chips, on a GPIO line: high cuts every output without a word on the bus.
//!
//! What the line does when its holder dies is up to the GPIO controller: a pull-up on OE is the hardware
//! that makes a line nobody drives cut.

use std::path::Path;

use gpiocdev::Request;
use gpiocdev::line::Value;

/// A line that is held high (cut) or low (released).
#[derive(Debug)]
pub struct OeLine {
    request: Request,
    line: u32,
}

impl OeLine {
    /// Takes the line and cuts.
    ///
    /// # Errors
    /// In words: the chip's device, the line, what the system said.
    pub fn cut(chip: &Path, line: u32) -> Result<Self, String> {
        let request = Request::builder()
            .on_chip(chip)
            .with_consumer("palpate OE")
            .with_line(line)
            .as_output(Value::Active)
            .request();
        let named = |error| {
            format!(
                "{} line {line}: {error}; `gpioinfo` lists lines and their users",
                chip.display()
            )
        };
        Ok(Self {
            request: request.map_err(named)?,
            line,
        })
    }

    /// Cuts (`true`) or releases.
    ///
    /// # Errors
    /// In words.
    pub fn set(&self, cut: bool) -> Result<(), String> {
        let value = if cut { Value::Active } else { Value::Inactive };
        let set = self.request.set_value(self.line, value);
        set.map(drop)
            .map_err(|e| format!("OE line {}: {e}", self.line))
    }
}
