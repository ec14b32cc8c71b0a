//! The skin as a raster of characters: the taxels of a cell, and its shade.

use palpate_records::trace::PlaceUm;

use super::grid::Color;

/// Shades from nothing to the strongest; a terminal without colours shows them too.
const SHADES: [char; 10] = ['.', ',', ':', '-', '=', '+', '*', '#', '%', '@'];
/// Their colours in the palette of 256, blue to red.
const COLORS: [u8; 10] = [236, 24, 31, 37, 36, 70, 142, 178, 208, 196];
/// Taxels up to which a cell shows the nearest one; beyond, every taxel has its cell and the largest counts.
const FEW: usize = 5000;
/// The scale never ends below this many counts: noise is not drawn as touch.
const LEAST: f32 = 200.0;

/// Taxels that each cell shows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Raster {
    /// Cells across and down.
    pub columns: u16,
    /// Cells down.
    pub rows: u16,
    cells: Vec<Vec<u32>>,
    low: PlaceUm,
    /// Micrometres of a cell.
    pitch: i64,
}

impl Raster {
    /// Lays taxels out on cells, square on the skin, as large as fits.
    pub fn new(taxels: &[PlaceUm], columns: u16, rows: u16) -> Self {
        let bounds = |of: fn(&PlaceUm) -> i32| {
            let (low, high) = (taxels.iter().map(of).min(), taxels.iter().map(of).max());
            (i64::from(low.unwrap_or(0)), i64::from(high.unwrap_or(0)))
        };
        let ((x0, x1), (y0, y1)) = (bounds(|p| p.x), bounds(|p| p.y));
        // Half the side of a taxel's own area is added around all of them.
        let area = ((x1 - x0).max(1) * (y1 - y0).max(1)) as f64;
        let own = ((area / taxels.len().max(1) as f64).sqrt() as i64).max(1000);
        let (width, height) = (x1 - x0 + own, y1 - y0 + own);
        let fits =
            |length: i64, cells: u16| (length + i64::from(cells) - 1) / i64::from(cells.max(1));
        let pitch = fits(width, columns).max(fits(height, rows)).max(1);
        let cells_of = |length: i64, most: u16| ((length / pitch).max(1) as u16).min(most.max(1));
        let mut raster = Self {
            columns: cells_of(width, columns),
            rows: cells_of(height, rows),
            cells: Vec::new(),
            low: PlaceUm {
                x: (x0 - own / 2) as i32,
                y: (y0 - own / 2) as i32,
            },
            pitch,
        };
        let count = usize::from(raster.columns) * usize::from(raster.rows);
        raster.cells = vec![Vec::new(); count];
        if taxels.len() > FEW {
            for (taxel, place) in taxels.iter().enumerate() {
                let (column, row) = raster.cell(*place);
                let cell = usize::from(row) * usize::from(raster.columns) + usize::from(column);
                raster.cells[cell].push(taxel as u32);
            }
            return raster;
        }
        let reach = own * own;
        for row in 0..raster.rows {
            for column in 0..raster.columns {
                let x = i64::from(raster.low.x) + pitch * i64::from(column) + pitch / 2;
                let up = i64::from(raster.rows - 1 - row);
                let y = i64::from(raster.low.y) + pitch * up + pitch / 2;
                let square =
                    |p: &PlaceUm| (i64::from(p.x) - x).pow(2) + (i64::from(p.y) - y).pow(2);
                let nearest = taxels.iter().enumerate().min_by_key(|(_, p)| square(p));
                if let Some((taxel, _)) = nearest.filter(|(_, p)| square(p) <= reach) {
                    let cell = usize::from(row) * usize::from(raster.columns) + usize::from(column);
                    raster.cells[cell].push(taxel as u32);
                }
            }
        }
        raster
    }

    /// The cell of a place, from the left and from the top.
    pub fn cell(&self, place: PlaceUm) -> (u16, u16) {
        let steps = |v: i32, low: i32, most: u16| {
            let n = (i64::from(v) - i64::from(low)).div_euclid(self.pitch);
            n.clamp(0, i64::from(most) - 1) as u16
        };
        let column = steps(place.x, self.low.x, self.columns);
        (
            column,
            self.rows - 1 - steps(place.y, self.low.y, self.rows),
        )
    }

    /// The largest reading of a cell; `None` where there is no skin, NaN where its taxels are left out.
    pub fn counts(&self, column: u16, row: u16, counts: &[f32]) -> Option<f32> {
        let cell = usize::from(row) * usize::from(self.columns) + usize::from(column);
        let taxels = self.cells.get(cell)?;
        let values = taxels
            .iter()
            .filter_map(|t| counts.get(*t as usize).copied());
        values.reduce(f32::max)
    }
}

/// Shade and colour of a reading where the largest is `peak`.
pub fn look(counts: f32, peak: f32) -> (char, Color) {
    if counts.is_nan() {
        return ('x', Color::DarkGray);
    }
    let share = libm::logf(1.0 + counts.max(0.0)) / libm::logf(1.0 + peak.max(LEAST));
    // The lowest third of a logarithmic scale is noise.
    let level = ((share - 0.34) / 0.66 * 10.0).clamp(0.0, 9.0) as usize;
    (SHADES[level], Color::Indexed(COLORS[level]))
}
