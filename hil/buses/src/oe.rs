//! The OE line of the PWM chips, on a GPIO line: high cuts every output without a word on the bus.
//!
//! The state of the line after its holder's death is up to the GPIO controller: a pull-up on OE is the hardware that
//! makes an undriven line cut.

use std::path::{Path, PathBuf};

use gpiocdev::Request;
use gpiocdev::line::Value;

/// A line that is held high (cut) or low (released).
#[derive(Debug)]
pub struct OeLine {
    chip: PathBuf,
    line: u32,
    /// Request of the line; `None` while the GPIO chip is gone.
    request: Option<Request>,
}

/// Takes a line, high or low from the first moment on.
fn request(chip: &Path, line: u32, cut: bool) -> Result<Request, String> {
    let request = Request::builder()
        .on_chip(chip)
        .with_consumer("palpate OE")
        .with_line(line)
        .as_output(level(cut))
        .request();
    request.map_err(|error| {
        format!(
            "{} line {line}: {error}; `gpioinfo` lists lines and their users",
            chip.display()
        )
    })
}

const fn level(cut: bool) -> Value {
    if cut { Value::Active } else { Value::Inactive }
}

impl OeLine {
    /// Takes the line and cuts.
    ///
    /// # Errors
    /// Words: the chip's device, the line, the system's error.
    pub fn cut(chip: &Path, line: u32) -> Result<Self, String> {
        Ok(Self {
            chip: chip.to_owned(),
            line,
            request: Some(request(chip, line, true)?),
        })
    }

    /// Cuts (`true`) or releases. A chip that was unplugged may be there again: its line is taken anew.
    ///
    /// # Errors
    /// In words.
    pub fn set(&mut self, cut: bool) -> Result<(), String> {
        let held = self.request.take();
        let set = held.filter(|held| held.set_value(self.line, level(cut)).is_ok());
        self.request = match set {
            Some(held) => Some(held),
            None => Some(request(&self.chip, self.line, cut)?),
        };
        Ok(())
    }
}
