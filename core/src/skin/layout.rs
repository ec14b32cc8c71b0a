//! Where the taxels of a skin are and which board speaks for them.

use alloc::boxed::Box;
use alloc::vec::Vec;
use core::fmt;

use crate::units::Point;
use crate::wire::uskin::Wiring;

/// Most taxels of one module: a megapixel camera skin.
const MOST_TAXELS: usize = 1 << 20;

/// A regular grid: taxel index = columns * row + column, row 0 at the top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Rows, top to bottom.
    pub rows: u16,
    /// Columns, left to right.
    pub columns: u16,
    /// Distance between neighbours, mm.
    pub pitch: f32,
    /// The grid's centre, mm.
    pub centre: Point,
}

/// One sensor module: its taxels in the order of their index.
#[derive(Clone, Debug, PartialEq)]
pub struct Module {
    taxels: Box<[Point]>,
    active: Box<[bool]>,
    grid: Option<Grid>,
    bus: u8,
    board: u8,
}

/// A skin: its modules in the order of their index.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    modules: Box<[Module]>,
}

/// Why something is no layout. Indices are zero-based.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LayoutError {
    /// No module, or a module without an active taxel.
    Empty,
    /// More taxels than a module may have.
    TooMany(usize),
    /// The pitch is not a finite number above zero.
    Pitch(f32),
    /// A coordinate of this taxel is not a finite number.
    NotFinite(usize),
    /// These two taxels lie at the same place.
    Coincident(usize, usize),
    /// There is no taxel of this index to be inactive.
    NoSuchTaxel(usize),
    /// These two modules share a bus and a board.
    SharedBoard(usize, usize),
}

impl fmt::Display for LayoutError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => write!(f, "expected at least one active taxel in every module"),
            Self::TooMany(n) => write!(
                f,
                "expected at most {MOST_TAXELS} taxels a module, found {n}"
            ),
            Self::Pitch(p) => write!(f, "expected a pitch above 0 mm, found {p}"),
            Self::NotFinite(i) => write!(f, "taxel {i}: expected finite coordinates in mm"),
            Self::Coincident(i, j) => write!(f, "taxels {i} and {j} lie at the same place"),
            Self::NoSuchTaxel(i) => write!(f, "there is no taxel {i} to be inactive"),
            Self::SharedBoard(i, j) => write!(f, "modules {i} and {j} share one bus and board"),
        }
    }
}

impl core::error::Error for LayoutError {}

impl Module {
    /// A regular grid of taxels around `grid.centre`.
    ///
    /// # Errors
    /// When it has no taxel, too many, or no pitch.
    pub fn grid(grid: Grid) -> Result<Self, LayoutError> {
        if !(grid.pitch.is_finite() && grid.pitch > 0.0) {
            return Err(LayoutError::Pitch(grid.pitch));
        }
        let (rows, columns) = (usize::from(grid.rows), usize::from(grid.columns));
        if rows * columns > MOST_TAXELS {
            return Err(LayoutError::TooMany(rows * columns));
        }
        let half = |n: usize| (n as f32 - 1.0) / 2.0;
        let place = |i: usize| {
            let (row, column) = (i / columns, i % columns);
            Point::new(
                grid.centre.x + (column as f32 - half(columns)) * grid.pitch,
                grid.centre.y + (half(rows) - row as f32) * grid.pitch,
            )
        };
        let taxels: Vec<Point> = (0..rows * columns).map(place).collect();
        Self::new(taxels, Some(grid))
    }

    /// Taxels anywhere.
    ///
    /// # Errors
    /// When there is none, too many, or two lie at the same place or nowhere.
    pub fn scattered(places: &[Point]) -> Result<Self, LayoutError> {
        // Sorted, coincident taxels are neighbours: no quadratic search over a large skin.
        let mut order: Vec<usize> = (0..places.len()).collect();
        order.sort_by(|&i, &j| {
            let (a, b) = (places[i], places[j]);
            a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y))
        });
        for pair in order.windows(2) {
            if places[pair[0]].distance2(places[pair[1]]) <= 0.0 {
                return Err(LayoutError::Coincident(
                    pair[0].min(pair[1]),
                    pair[0].max(pair[1]),
                ));
            }
        }
        Self::new(places.to_vec(), None)
    }

    fn new(taxels: Vec<Point>, grid: Option<Grid>) -> Result<Self, LayoutError> {
        if taxels.is_empty() {
            return Err(LayoutError::Empty);
        }
        if taxels.len() > MOST_TAXELS {
            return Err(LayoutError::TooMany(taxels.len()));
        }
        if let Some(i) = taxels
            .iter()
            .position(|p| !(p.x.is_finite() && p.y.is_finite()))
        {
            return Err(LayoutError::NotFinite(i));
        }
        let active = alloc::vec![true; taxels.len()].into();
        Ok(Self {
            taxels: taxels.into(),
            active,
            grid,
            bus: 0,
            board: 0,
        })
    }

    /// The same module without some taxels: never read, never in contact.
    ///
    /// # Errors
    /// When there is no such taxel, or none is left.
    pub fn without(mut self, inactive: &[usize]) -> Result<Self, LayoutError> {
        for &i in inactive {
            *self.active.get_mut(i).ok_or(LayoutError::NoSuchTaxel(i))? = false;
        }
        if self.active.contains(&true) {
            Ok(self)
        } else {
            Err(LayoutError::Empty)
        }
    }

    /// The same module behind another board.
    #[must_use]
    pub const fn at(mut self, bus: u8, board: u8) -> Self {
        (self.bus, self.board) = (bus, board);
        self
    }

    /// Places of the taxels, mm.
    pub const fn taxels(&self) -> &[Point] {
        &self.taxels
    }

    /// Which taxels exist; the others are treated like faulty ones.
    pub const fn active(&self) -> &[bool] {
        &self.active
    }

    /// The grid, if the taxels lie on one.
    pub const fn as_grid(&self) -> Option<Grid> {
        self.grid
    }

    /// How the taxels hang on their board: a grid row by row, scattered ones as lines of four chips.
    /// Skins too large for one board (cameras, whole bodies) have no such wiring; theirs is the flat
    /// module's and carries their first 16 taxels only.
    pub fn wiring(&self) -> Wiring {
        let (rows, columns) = match self.grid {
            Some(grid) => (u8::try_from(grid.rows), u8::try_from(grid.columns)),
            None => (u8::try_from(self.taxels.len().div_ceil(4)), Ok(4)),
        };
        let wiring = rows
            .ok()
            .zip(columns.ok())
            .and_then(|(r, c)| Wiring::new(r, c, 1));
        wiring.unwrap_or(Wiring::FLAT)
    }

    /// Sensor bus and board address.
    pub const fn address(&self) -> (u8, u8) {
        (self.bus, self.board)
    }
}

impl Layout {
    /// A skin of modules.
    ///
    /// # Errors
    /// When there is none, or two share a board.
    pub fn new(modules: Vec<Module>) -> Result<Self, LayoutError> {
        if modules.is_empty() {
            return Err(LayoutError::Empty);
        }
        for (j, module) in modules.iter().enumerate() {
            if let Some(i) = modules[..j]
                .iter()
                .position(|m| m.address() == module.address())
            {
                return Err(LayoutError::SharedBoard(i, j));
            }
        }
        Ok(Self {
            modules: modules.into(),
        })
    }

    /// The modules.
    pub const fn modules(&self) -> &[Module] {
        &self.modules
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat() -> Grid {
        Grid {
            rows: 4,
            columns: 4,
            pitch: 4.7,
            centre: Point::default(),
        }
    }

    #[test]
    fn a_flat_module_spans_7_05_mm_with_row_0_on_top() {
        let module = Module::grid(flat()).unwrap();
        assert_eq!(module.taxels().len(), 16);
        for (i, x, y) in [
            (0, -7.05, 7.05),
            (3, 7.05, 7.05),
            (12, -7.05, -7.05),
            (5, -2.35, 2.35),
        ] {
            assert!(
                module.taxels()[i].distance(Point::new(x, y)) < 1e-5,
                "taxel {i}"
            );
        }
    }

    #[test]
    fn what_is_no_layout_is_refused_by_name() {
        for pitch in [0.0, -4.7, f32::INFINITY] {
            assert_eq!(
                Module::grid(Grid { pitch, ..flat() }),
                Err(LayoutError::Pitch(pitch))
            );
        }
        assert_eq!(
            Module::grid(Grid { rows: 0, ..flat() }),
            Err(LayoutError::Empty)
        );
        let huge = Module::grid(Grid {
            rows: 2000,
            columns: 2000,
            ..flat()
        });
        assert_eq!(huge, Err(LayoutError::TooMany(4_000_000)));
        let p = |x, y| Point::new(x, y);
        let twice = Module::scattered(&[p(0.0, 1.0), p(2.0, 2.0), p(0.0, 1.0)]);
        assert_eq!(twice, Err(LayoutError::Coincident(0, 2)));
        assert_eq!(
            Module::scattered(&[p(f32::NAN, 0.0)]),
            Err(LayoutError::NotFinite(0))
        );
        assert_eq!(Module::scattered(&[]), Err(LayoutError::Empty));
        let one = Module::scattered(&[p(0.0, 0.0)]).unwrap();
        assert_eq!(one.clone().without(&[1]), Err(LayoutError::NoSuchTaxel(1)));
        assert_eq!(one.clone().without(&[0]), Err(LayoutError::Empty));
        assert_eq!(
            Layout::new(alloc::vec![one.clone(), one]),
            Err(LayoutError::SharedBoard(0, 1))
        );
        assert_eq!(Layout::new(Vec::new()), Err(LayoutError::Empty));
    }
}
