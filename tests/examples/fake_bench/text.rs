//! Text in a place of its own, without memory from anybody.

use std::ffi::CStr;
use std::fmt::{self, Arguments, Write};

/// Text of at most `N - 1` bytes and a zero.
pub struct Text<const N: usize> {
    bytes: [u8; N],
    length: usize,
}

impl<const N: usize> Text<N> {
    /// Text as formatted; what does not fit makes all of it useless.
    pub fn new(text: Arguments<'_>) -> Self {
        let mut own = Self {
            bytes: [0; N],
            length: 0,
        };
        if own.write_fmt(text).is_err() {
            own.length = N;
        }
        own
    }

    /// With its zero; none where it did not fit.
    pub fn c(&self) -> Option<&CStr> {
        CStr::from_bytes_with_nul(self.bytes.get(..=self.length)?).ok()
    }
}

impl<const N: usize> Write for Text<N> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let end = self.length + text.len();
        let place = self.bytes.get_mut(self.length..end).ok_or(fmt::Error)?;
        place.copy_from_slice(text.as_bytes());
        self.length = end;
        Ok(())
    }
}
