//! A grid of character cells: texts are put on it, and a screen needs only the cells that differ from the last one's.

use unicode_width::UnicodeWidthChar;

/// Colours of a text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Color {
    /// The terminal's own.
    #[default]
    Plain,
    /// Yellow.
    Yellow,
    /// Dark grey.
    DarkGray,
    /// One of the palette of 256.
    Indexed(u8),
}

/// Look of a text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Style {
    pub bold: bool,
    pub dim: bool,
    pub reversed: bool,
    pub color: Color,
}

impl Style {
    /// Plain text of a colour.
    pub fn of_color(color: Color) -> Self {
        Self {
            color,
            ..Self::default()
        }
    }
}

/// A character and its look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// None in the right half of a wide character.
    pub symbol: Option<char>,
    pub style: Style,
}

impl Cell {
    pub const EMPTY: Self = Self {
        symbol: Some(' '),
        style: Style {
            bold: false,
            dim: false,
            reversed: false,
            color: Color::Plain,
        },
    };
}

/// Rows of cells.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Grid {
    pub columns: u16,
    pub rows: u16,
    pub cells: Vec<Cell>,
}

impl Grid {
    /// Empty cells.
    pub fn new((columns, rows): (u16, u16)) -> Self {
        Self {
            columns,
            rows,
            cells: vec![Cell::EMPTY; usize::from(columns) * usize::from(rows)],
        }
    }

    /// Puts a text on a row, up to the right edge. Characters without a width, such as controls, are left out.
    pub fn put(&mut self, x: u16, y: u16, text: &str, style: Style) {
        if y >= self.rows || x >= self.columns {
            return;
        }
        let begin = usize::from(y) * usize::from(self.columns);
        let row = &mut self.cells[begin..begin + usize::from(self.columns)];
        let mut left = row.iter_mut().skip(x.into());
        for symbol in text.chars() {
            let width = symbol.width().unwrap_or(0);
            if width > left.len() {
                return;
            }
            let halves = [Some(symbol)].into_iter().chain(std::iter::repeat(None));
            for (cell, symbol) in left.by_ref().take(width).zip(halves) {
                *cell = Cell { symbol, style };
            }
        }
    }

    /// Cells of `next`, a grid of this size, that differ from those here: column, row and cell.
    pub fn changes<'n>(&self, next: &'n Self) -> impl Iterator<Item = (u16, u16, &'n Cell)> {
        let places = (0..next.rows).flat_map(|y| (0..next.columns).map(move |x| (x, y)));
        let cells = places.zip(&next.cells).zip(&self.cells);
        cells.filter_map(|(((x, y), cell), shown)| (cell != shown).then_some((x, y, cell)))
    }
}

#[cfg(test)]
#[path = "grid_tests.rs"]
mod tests;
