//! Cells as escape sequences that every terminal of today understands (ECMA-48).

use std::io::{self, Write};

use super::grid::{Cell, Color, Grid};

/// A terminal behind a stream.
#[derive(Debug)]
pub struct Ansi<W> {
    out: W,
    /// The cells that the screen shows.
    shown: Grid,
}

fn color(color: Color) -> String {
    match color {
        Color::Indexed(n) => format!(";38;5;{n}"),
        Color::Yellow => ";33".into(),
        Color::DarkGray => ";90".into(),
        Color::Plain => String::new(),
    }
}

impl<W: Write> Ansi<W> {
    /// A screen of unknown size.
    pub fn new(out: W) -> Self {
        Self {
            out,
            shown: Grid::default(),
        }
    }

    /// Shows a picture: cells of it go out that are not on the screen. A picture of another size begins on a clear one.
    ///
    /// # Errors
    /// The stream's error.
    pub fn show(&mut self, picture: Grid) -> io::Result<()> {
        let size = (picture.columns, picture.rows);
        if (self.shown.columns, self.shown.rows) != size {
            self.out.write_all(b"\x1b[2J")?;
            self.shown = Grid::new(size);
        }
        let changes: Vec<_> = self.shown.changes(&picture).collect();
        self.draw(&changes)?;
        self.shown = picture;
        self.out.flush()
    }

    fn draw(&mut self, cells: &[(u16, u16, &Cell)]) -> io::Result<()> {
        let mut next = None;
        let mut style = String::new();
        for &(x, y, cell) in cells {
            // The left half of a wide character shows the right one too.
            let Some(symbol) = cell.symbol else { continue };
            if next != Some((x, y)) {
                write!(self.out, "\x1b[{};{}H", y + 1, x + 1)?;
            }
            next = Some((x + 1, y));
            let mut wanted = String::from("\x1b[0");
            let look = cell.style;
            for (wears, code) in [(look.bold, ";1"), (look.dim, ";2"), (look.reversed, ";7")] {
                if wears {
                    wanted.push_str(code);
                }
            }
            wanted.push_str(&color(look.color));
            wanted.push('m');
            if wanted != style {
                self.out.write_all(wanted.as_bytes())?;
                style = wanted;
            }
            write!(self.out, "{symbol}")?;
        }
        self.out.write_all(b"\x1b[0m")
    }
}

#[cfg(test)]
#[path = "ansi_tests.rs"]
mod tests;
