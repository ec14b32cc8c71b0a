//! One module of a sensor layout: its taxels, its copies, its boards.

use serde::Deserialize;

use super::error::FileError;
use super::settings::bounds;
use super::source::Source;
use super::transducer::Transducer;

/// The most taxels of a skin, as the core has it.
const MOST_TAXELS: usize = 1 << 22;
/// The most taxels one uSkin board reads.
const TAXELS_PER_BOARD: usize = 16;
/// The most taxels one MTB board reads, thermal pads included: 16 triangles of 12.
const TAXELS_PER_MTB: usize = 192;

/// A module: a grid of taxels, or scattered points.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SkinModule {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// A regular grid around the module's centre; or `hex` or `points_mm`.
    pub grid: Option<Grid>,
    /// Hexagonal cells around the module's centre: every other row is half a pitch to the right.
    pub hex: Option<Grid>,
    /// Places of taxels, mm; or `grid` or `hex`.
    pub points_mm: Option<Vec<[f64; 2]>>,
    /// Copies of this module side by side, `-1` to `-n` after its name; left out: itself alone.
    pub repeat: Option<Repeat>,
    /// Taxels (by index) that are there but not read.
    #[serde(default)]
    pub inactive: Vec<usize>,
    /// The image cell of the module's top left read taxel; every grid row is packed to the left.
    pub image: Option<ImageCell>,
    /// Centre of the module in the whole skin's plane, mm.
    #[serde(default)]
    pub place_mm: [f64; 2],
    /// The bus of its boards; with `boards`.
    pub bus: Option<u8>,
    /// Board addresses, 16 read taxels each, in order; one for up to 192 taxels of a capacitive skin. Left out: no
    /// bus carries it.
    #[serde(default)]
    pub boards: Vec<u8>,
}

/// A regular grid; taxel index = columns * row + column.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Number of rows, from top to bottom.
    pub rows: usize,
    /// Number of columns, from left to right.
    pub columns: usize,
    /// Distance between neighbours, both ways, mm.
    pub pitch_mm: f64,
}

/// Copies of a module in rows and columns, their places counted from `place_mm` at the top left.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Repeat {
    /// Number of rows, from top to bottom.
    pub rows: usize,
    /// Number of columns, from left to right.
    pub columns: usize,
    /// Distance from a copy's centre to the next one's, to the right and down, mm.
    pub step_mm: [f64; 2],
}

/// A cell of the skin's image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ImageCell {
    /// Row from the top, counted from zero.
    pub row: usize,
    /// Column from the left, counted from zero.
    pub column: usize,
}

/// One taxel of a module.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Taxel {
    /// Distance to the right of the module's centre, mm.
    pub x_mm: f64,
    /// Distance up from the module's centre, mm.
    pub y_mm: f64,
    /// True if the taxel is read at all.
    pub active: bool,
    /// The taxel's (row, column) in the skin's image.
    pub image: Option<(usize, usize)>,
}

impl SkinModule {
    /// All taxels in index order, those that are not read included.
    #[must_use]
    pub fn taxels(&self) -> Vec<Taxel> {
        let places = self.places();
        let columns = self.grid.map_or(places.len().max(1), |grid| grid.columns);
        let mut packed = 0;
        let mut taxels = Vec::with_capacity(places.len());
        for (index, [x_mm, y_mm]) in places.into_iter().enumerate() {
            let (row, column) = (index / columns, index % columns);
            packed = if column == 0 { 0 } else { packed };
            let active = !self.inactive.contains(&index);
            let image = self.image.filter(|_| active);
            let image = image.map(|cell| (cell.row + row, cell.column + packed));
            packed += usize::from(active);
            taxels.push(Taxel {
                x_mm,
                y_mm,
                active,
                image,
            });
        }
        taxels
    }

    /// Number of taxels that are read.
    #[must_use]
    pub fn readings(&self) -> usize {
        self.places().len().saturating_sub(self.inactive.len())
    }

    /// Distance from a taxel to the nearest other one, mm; `None` for a single taxel.
    #[must_use]
    pub fn pitch_mm(&self) -> Option<f64> {
        if let Some(grid) = self.grid.or(self.hex) {
            return (grid.rows * grid.columns > 1).then_some(grid.pitch_mm);
        }
        let mut places = self.places();
        places.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
        let mut least = f64::INFINITY;
        for (index, [x, y]) in places.iter().enumerate() {
            for other in &places[index + 1..] {
                // Taxels further right than the least distance so far cannot be nearer.
                if other[0] - x >= least {
                    break;
                }
                least = least.min((other[0] - x).hypot(other[1] - y));
            }
        }
        least.is_finite().then_some(least)
    }

    fn places(&self) -> Vec<[f64; 2]> {
        let (grid, hex) = match (self.grid, self.hex) {
            (Some(grid), _) => (grid, false),
            (None, Some(hex)) => (hex, true),
            (None, None) => return self.points_mm.clone().unwrap_or_default(),
        };
        // Rows of hexagons are nearer to each other than their cells.
        let row_pitch = grid.pitch_mm * if hex { 0.75_f64.sqrt() } else { 1.0 };
        let centred = |index: usize, count: usize| index as f64 - (count as f64 - 1.0) / 2.0;
        (0..grid.rows * grid.columns)
            .map(|index| {
                let (row, column) = (index / grid.columns, index % grid.columns);
                let shift = if hex {
                    0.5 * (row % 2) as f64 - 0.25
                } else {
                    0.0
                };
                [
                    (centred(column, grid.columns) + shift) * grid.pitch_mm,
                    -centred(row, grid.rows) * row_pitch,
                ]
            })
            .collect()
    }

    /// Places of a module that is no plain grid.
    #[must_use]
    pub fn scattered(&self) -> Option<Vec<[f64; 2]>> {
        self.grid.is_none().then(|| self.places())
    }

    /// The module and its copies.
    pub(super) fn copies(self) -> Vec<Self> {
        let Some(repeat) = self.repeat else {
            return vec![self];
        };
        let copy = |index: usize| {
            let (row, column) = (index / repeat.columns, index % repeat.columns);
            let [x, y] = self.place_mm;
            Self {
                name: format!("{}-{}", self.name, index + 1),
                place_mm: [
                    x + column as f64 * repeat.step_mm[0],
                    y - row as f64 * repeat.step_mm[1],
                ],
                repeat: None,
                ..self.clone()
            }
        };
        (0..repeat.rows * repeat.columns).map(copy).collect()
    }

    pub(super) fn check(
        &self,
        source: &Source,
        key: &str,
        transducer: Transducer,
    ) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        self.check_shape(source, key)?;
        if let Some(repeat) = self.repeat {
            bounds!(source, &at("repeat"), repeat;
                rows: 1..=256;
                columns: 1..=256;
                step_mm: 0.01..=1e4, "mm")?;
            if self.bus.is_some() || self.image.is_some() {
                return Err(source.bad(&at("repeat"), "no bus and no image: copies share neither"));
            }
        }
        let count = self.places().len();
        for (position, index) in self.inactive.iter().enumerate() {
            let here = at(&format!("inactive[{position}]"));
            source.range(&here, index, 0..=count - 1, "")?;
            if self.inactive[..position].contains(index) {
                return Err(source.bad(&here, "every taxel once"));
            }
        }
        if self.readings() == 0 {
            return Err(source.bad(&at("inactive"), "at least one taxel that is read"));
        }
        bounds!(source, key, self; place_mm: -1e5..=1e5, "mm")?;
        self.check_boards(source, key, transducer)
    }

    fn check_shape(&self, source: &Source, key: &str) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        let shapes = [
            ("grid", self.grid.is_some()),
            ("hex", self.hex.is_some()),
            ("points_mm", self.points_mm.is_some()),
        ];
        let mut given = shapes.iter().filter(|(_, given)| *given);
        match (given.next(), given.next()) {
            (None, _) => return Err(source.bad(&at("grid"), "grid, hex or points_mm")),
            (_, Some((name, _))) => {
                return Err(source.bad(&at(name), "one of grid, hex and points_mm"));
            }
            _ => {}
        }
        for (name, grid) in [("grid", &self.grid), ("hex", &self.hex)] {
            if let Some(grid) = grid {
                grid.check(source, &at(name))?;
            }
        }
        match &self.points_mm {
            Some(points) => places(source, &at("points_mm"), points, 1..=20_000),
            None => Ok(()),
        }
    }

    fn check_boards(
        &self,
        source: &Source,
        key: &str,
        transducer: Transducer,
    ) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        if self.bus.is_some() == self.boards.is_empty() {
            let missing = if self.bus.is_some() { "boards" } else { "bus" };
            return Err(source.bad(&at(missing), "bus and boards together, or neither"));
        }
        let (taxels, readings) = (self.places().len(), self.readings());
        let needed = match transducer {
            Transducer::Magnetic => readings.div_ceil(TAXELS_PER_BOARD),
            Transducer::Capacitive => 1,
            Transducer::Camera | Transducer::Cells => 0,
        };
        if self.bus.is_some() && needed == 0 {
            return Err(source.bad(&at("bus"), "no bus: no board known here sends such taxels"));
        }
        if self.bus.is_some() && transducer == Transducer::Capacitive && taxels > TAXELS_PER_MTB {
            let expected = format!(
                "at most {TAXELS_PER_MTB} taxels on a board (16 triangles of 12), here {taxels}"
            );
            return Err(source.bad(&at("boards"), expected));
        }
        if self.bus.is_some() && self.boards.len() != needed {
            let expected = match transducer {
                Transducer::Capacitive => "1 board for all of the module's triangles".to_owned(),
                _ => format!("{needed} boards ({readings} taxels, 16 a board)"),
            };
            return Err(source.bad(&at("boards"), expected));
        }
        bounds!(source, key, self; boards: 0..=15)
    }
}

impl Grid {
    fn check(&self, source: &Source, key: &str) -> Result<(), FileError> {
        bounds!(source, key, self;
            rows: 1..=4096;
            columns: 1..=4096;
            pitch_mm: 0.01..=1e3, "mm")?;
        if self.rows * self.columns > MOST_TAXELS {
            return Err(source.bad(key, format!("at most {MOST_TAXELS} taxels")));
        }
        Ok(())
    }
}

/// Checks a list of places: a sensible number of them, in range, no two the same.
pub(super) fn places(
    source: &Source,
    key: &str,
    points: &[[f64; 2]],
    count: std::ops::RangeInclusive<usize>,
) -> Result<(), FileError> {
    if !count.contains(&points.len()) {
        let expected = format!("{} to {} places", count.start(), count.end());
        return Err(source.bad(key, expected));
    }
    let mut seen = std::collections::BTreeMap::new();
    for (index, point) in points.iter().enumerate() {
        source.range(&format!("{key}[{index}]"), point, -1e4..=1e4, "mm")?;
        // Adding zero turns -0.0 into 0.0.
        if let Some(first) = seen.insert(point.map(|value| (value + 0.0).to_bits()), index) {
            let expected = format!("a place of its own, not that of number {first}");
            return Err(source.bad(&format!("{key}[{index}]"), expected));
        }
    }
    Ok(())
}
