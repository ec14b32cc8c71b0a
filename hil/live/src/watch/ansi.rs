//! Cells as escape sequences that every terminal of today understands (ECMA-48).

use std::io::{self, Write};

use ratatui_core::buffer::{Buffer, Cell};
use ratatui_core::style::{Color, Modifier};

/// A terminal behind a stream.
#[derive(Debug)]
pub struct Ansi<W> {
    out: W,
    /// The cells that the screen shows.
    shown: Buffer,
}

/// Colours by their number in the palette of 256; everything else is the terminal's own.
fn color(color: Color, base: u8) -> String {
    match color {
        Color::Indexed(n) => format!(";{};5;{n}", base + 8),
        Color::Red => format!(";{}", base + 1),
        Color::Green => format!(";{}", base + 2),
        Color::Yellow => format!(";{}", base + 3),
        Color::DarkGray => format!(";{}", base + 60),
        _ => String::new(),
    }
}

impl<W: Write> Ansi<W> {
    /// A screen of unknown size.
    pub fn new(out: W) -> Self {
        Self {
            out,
            shown: Buffer::default(),
        }
    }

    /// Shows a picture: cells of it go out that are not on the screen. A picture of another size begins on a clear one.
    ///
    /// # Errors
    /// The stream's error.
    pub fn show(&mut self, picture: Buffer) -> io::Result<()> {
        if self.shown.area != picture.area {
            self.out.write_all(b"\x1b[2J")?;
            self.shown = Buffer::empty(picture.area);
        }
        self.draw(&self.shown.diff(&picture))?;
        self.shown = picture;
        self.out.flush()
    }

    fn draw(&mut self, cells: &[(u16, u16, &Cell)]) -> io::Result<()> {
        let mut next = None;
        let mut style = String::new();
        for &(x, y, cell) in cells {
            if next != Some((x, y)) {
                write!(self.out, "\x1b[{};{}H", y + 1, x + 1)?;
            }
            next = Some((x + 1, y));
            let mut wanted = String::from("\x1b[0");
            for (modifier, code) in [
                (Modifier::BOLD, ";1"),
                (Modifier::DIM, ";2"),
                (Modifier::REVERSED, ";7"),
            ] {
                if cell.modifier.contains(modifier) {
                    wanted.push_str(code);
                }
            }
            wanted.push_str(&color(cell.fg, 30));
            wanted.push_str(&color(cell.bg, 40));
            wanted.push('m');
            if wanted != style {
                self.out.write_all(wanted.as_bytes())?;
                style = wanted;
            }
            self.out.write_all(cell.symbol().as_bytes())?;
        }
        self.out.write_all(b"\x1b[0m")
    }
}

#[cfg(test)]
#[path = "ansi_tests.rs"]
mod tests;
