//! Places of the taxels: modules, grids, scattered points, and the boards that send them.
//!
//! A layout is built from plain data and checked once, so that no later stage meets a duplicate, a NaN or an empty
//! module. Files and their syntax belong to `hil`.

use alloc::string::String;
use alloc::vec::Vec;
use core::ops::Range;

pub use super::layout_error::LayoutError;
use super::layout_error::{MOST_MODULES, MOST_TAXELS};
use super::seams::{Seam, Seams};
use crate::codec::mtb;
use crate::codec::uskin::Wiring;
use crate::statistics::quantile;
use crate::units::Point;

/// A regular grid: index = row * cols + col, row 0 on top, centred on the module's origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Rows, 1 or more.
    pub rows: u16,
    /// Columns, 1 or more.
    pub cols: u16,
    /// Distance of two columns, mm.
    pub pitch_x: f32,
    /// Distance of two rows, mm.
    pub pitch_y: f32,
}

impl Grid {
    /// The place of a taxel in the module's coordinates, mm.
    pub fn place(&self, row: u16, col: u16) -> Point {
        let half = |n: u16| 0.5 * (f32::from(n) - 1.0);
        Point::new(
            (f32::from(col) - half(self.cols)) * self.pitch_x,
            (half(self.rows) - f32::from(row)) * self.pitch_y,
        )
    }
}

/// The board that sends a module's readings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Address {
    /// The sensor bus, zero-based.
    pub bus: u8,
    /// The board on that bus (the controller number c of its CAN ids), 0 ..= 15.
    pub board: u8,
}

/// Protocols by which a module's board puts its readings on the bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Protocol {
    /// Frames of [`crate::codec::uskin`]: one per taxel, by its [`Wiring`]; the board waits for a command.
    #[default]
    Uskin,
    /// Frames of [`crate::codec::mtb`]: two per triangle of twelve taxels, triangles by index; the board sends by
    /// itself.
    Mtb,
}

/// One sensor module: its taxels in its own plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Module {
    name: String,
    points: Vec<Point>,
    active: Vec<bool>,
    axes: u8,
    grid: Option<Grid>,
    origin: Point,
    address: Option<Address>,
    protocol: Protocol,
    spacing: f32,
}

impl Module {
    /// A grid of `rows` x `cols` taxels, `pitch` mm apart, three axes, all active, at the skin's origin.
    pub fn grid(name: &str, rows: u16, cols: u16, pitch: f32) -> Result<Self, LayoutError> {
        Self::grid_xy(name, rows, cols, pitch, pitch)
    }

    /// Lays out a [`Module::grid`] with its own pitch per direction, mm: a curved module unrolled, for example.
    pub(crate) fn grid_xy(
        name: &str,
        rows: u16,
        cols: u16,
        pitch_x: f32,
        pitch_y: f32,
    ) -> Result<Self, LayoutError> {
        for pitch in [pitch_x, pitch_y] {
            if !(pitch > 0.0 && pitch <= LARGEST_MM) {
                return Err(LayoutError::BadPitch { pitch });
            }
        }
        let count = usize::from(rows) * usize::from(cols);
        if count > MOST_TAXELS {
            return Err(LayoutError::TooManyTaxels { count });
        }
        let grid = Grid {
            rows,
            cols,
            pitch_x,
            pitch_y,
        };
        let points = (0..rows)
            .flat_map(|r| (0..cols).map(move |c| grid.place(r, c)))
            .collect();
        Self::checked(name, points, Some(grid))
    }

    /// Taxels at any places, mm, three axes, all active, at the skin's origin.
    pub fn scattered(name: &str, points: &[Point]) -> Result<Self, LayoutError> {
        if points.len() > MOST_TAXELS {
            return Err(LayoutError::TooManyTaxels {
                count: points.len(),
            });
        }
        Self::checked(name, points.to_vec(), None)
    }

    fn checked(name: &str, points: Vec<Point>, grid: Option<Grid>) -> Result<Self, LayoutError> {
        if points.is_empty() {
            return Err(LayoutError::NoTaxels);
        }
        let wild = |v: f32| !(v.is_finite() && libm::fabsf(v) <= LARGEST_MM);
        if let Some(taxel) = points.iter().position(|p| wild(p.x) || wild(p.y)) {
            return Err(LayoutError::NotFinite { taxel });
        }
        let spacing = spacing(&points)?;
        Ok(Self {
            name: String::from(name),
            active: alloc::vec![true; points.len()],
            points,
            axes: 3,
            grid,
            origin: Point::default(),
            address: None,
            protocol: Protocol::Uskin,
            spacing,
        })
    }

    /// Keeps only the taxels marked `true` (a fingertip of 24 with 16 read, a missing module).
    /// All of them may be off: such a module is laid out but silent.
    pub fn with_active(mut self, active: &[bool]) -> Result<Self, LayoutError> {
        if active.len() != self.points.len() {
            return Err(LayoutError::MaskLength {
                got: active.len(),
                expected: self.points.len(),
            });
        }
        self.active.copy_from_slice(active);
        Ok(self)
    }

    /// Sets the number of axes: 1 (the normal one, carried as z) or 3.
    pub fn with_axes(mut self, axes: u8) -> Result<Self, LayoutError> {
        if axes != 1 && axes != 3 {
            return Err(LayoutError::BadAxes { axes });
        }
        self.axes = axes;
        Ok(self)
    }

    /// Puts the module's centre at `origin` in the skin's plane, mm (used when clusters span modules).
    pub fn with_origin(mut self, origin: Point) -> Result<Self, LayoutError> {
        let wild = |v: f32| !(v.is_finite() && libm::fabsf(v) <= LARGEST_MM);
        if wild(origin.x) || wild(origin.y) {
            return Err(LayoutError::BadOrigin);
        }
        self.origin = origin;
        Ok(self)
    }

    /// Sets the board that sends this module.
    pub fn with_address(mut self, address: Address) -> Result<Self, LayoutError> {
        if address.board > 15 {
            return Err(LayoutError::BadBoard {
                board: address.board,
            });
        }
        self.address = Some(address);
        Ok(self)
    }

    /// Sets the protocol of its board.
    pub const fn with_protocol(mut self, protocol: Protocol) -> Self {
        self.protocol = protocol;
        self
    }

    /// The module's name.
    pub fn name(&self) -> &str {
        &self.name
    }
    /// Taxel places in the module's coordinates, mm.
    pub fn points(&self) -> &[Point] {
        &self.points
    }
    /// Flags of the taxels that are read.
    pub fn active(&self) -> &[bool] {
        &self.active
    }
    /// Number of axes, 1 or 3.
    pub fn axes(&self) -> u8 {
        self.axes
    }
    /// The grid, or `None` for scattered points.
    pub(crate) fn as_grid(&self) -> Option<&Grid> {
        self.grid.as_ref()
    }
    /// The module's centre in the skin's plane, mm.
    pub fn origin(&self) -> Point {
        self.origin
    }
    /// The lines by which the taxels hang on their uSkin board: a grid row by row, scattered ones in lines of four.
    /// `None` for a skin no such board can carry (triangles, cameras, whole bodies).
    pub fn wiring(&self) -> Option<Wiring> {
        if self.protocol != Protocol::Uskin {
            return None;
        }
        let (rows, columns) = match &self.grid {
            Some(grid) => (usize::from(grid.rows), usize::from(grid.cols)),
            None => (self.points.len().div_ceil(4), 4),
        };
        Wiring::new(u8::try_from(rows).ok()?, u8::try_from(columns).ok()?, 1)
    }

    /// A taxel's place in the order in which its board sends a scan; `None` where no board can send it.
    pub(super) fn sent_as(&self, taxel: usize) -> Option<usize> {
        match self.protocol {
            Protocol::Uskin => {
                let wiring = self.wiring()?;
                wiring.order(wiring.place(0, taxel)?)
            }
            Protocol::Mtb => (taxel < mtb::MOST_TAXELS).then_some(taxel),
        }
    }

    /// Protocol of the module's board, if it has one.
    pub const fn protocol(&self) -> Protocol {
        self.protocol
    }

    /// The board that sends it, if any.
    pub fn address(&self) -> Option<Address> {
        self.address
    }
    /// Median distance of a taxel to its nearest neighbour, mm; 1 for a single taxel.
    pub fn spacing(&self) -> f32 {
        self.spacing
    }
    /// The smallest and largest corner around all active taxels (all taxels if none is active), mm.
    pub fn bounds(&self) -> (Point, Point) {
        let none = !self.active.contains(&true);
        let mut low = Point::new(f32::INFINITY, f32::INFINITY);
        let mut high = Point::new(f32::NEG_INFINITY, f32::NEG_INFINITY);
        for (p, _) in self
            .points
            .iter()
            .zip(&self.active)
            .filter(|t| *t.1 || none)
        {
            low = Point::new(low.x.min(p.x), low.y.min(p.y));
            high = Point::new(high.x.max(p.x), high.y.max(p.y));
        }
        (low, high)
    }
}

/// All modules of a skin. Taxels are numbered through, module after module.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    modules: Vec<Module>,
    starts: Vec<u32>,
    seams: Seams,
}

impl Layout {
    /// Puts modules together.
    ///
    /// # Errors
    /// No module or too many, more than 2^22 taxels, no active taxel at all, two modules with one name or one
    /// address.
    pub fn new(modules: Vec<Module>) -> Result<Self, LayoutError> {
        if modules.is_empty() {
            return Err(LayoutError::NoModules);
        }
        if modules.len() > MOST_MODULES {
            return Err(LayoutError::TooManyModules {
                count: modules.len(),
            });
        }
        let count = modules.iter().map(|m| m.points.len()).sum();
        if count > MOST_TAXELS {
            return Err(LayoutError::TooManyTaxels { count });
        }
        if !modules.iter().any(|m| m.active.contains(&true)) {
            return Err(LayoutError::NothingActive);
        }
        for (second, b) in modules.iter().enumerate() {
            for (first, a) in modules[..second].iter().enumerate() {
                if a.name == b.name {
                    return Err(LayoutError::SameName { first, second });
                }
                if a.address.is_some() && a.address == b.address {
                    return Err(LayoutError::SameAddress { first, second });
                }
            }
        }
        let mut starts = Vec::with_capacity(modules.len() + 1);
        starts.push(0);
        let mut next = 0;
        for module in &modules {
            next += module.points.len() as u32; // at most MOST_TAXELS, checked above
            starts.push(next);
        }
        Ok(Self {
            modules,
            starts,
            seams: Seams::default(),
        })
    }

    /// Joins modules at seams: distances over the whole skin then go along it, and over the plane only between modules that
    /// no seams join.
    ///
    /// # Errors
    /// A seam of other modules, without an edge of one length, or so many rings that there are too many ways.
    pub fn with_seams(mut self, seams: &[Seam]) -> Result<Self, LayoutError> {
        let middle = |module: &Module| {
            let (low, high) = module.bounds();
            Point::new((low.x + high.x) / 2.0, (low.y + high.y) / 2.0)
        };
        let middles: Vec<Point> = self.modules.iter().map(middle).collect();
        self.seams = Seams::new(&middles, seams)?;
        Ok(self)
    }

    /// A skin of one module.
    pub fn single(module: Module) -> Result<Self, LayoutError> {
        Self::new(alloc::vec![module])
    }

    /// The seams at which modules join.
    pub(crate) fn seams(&self) -> &Seams {
        &self.seams
    }
    /// All modules.
    pub fn modules(&self) -> &[Module] {
        &self.modules
    }
    /// Number of taxels of all modules, active or not.
    pub fn taxels(&self) -> usize {
        self.starts.last().map_or(0, |&n| n as usize)
    }
    /// First taxel of each module in the running index; one entry more than modules.
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }
    /// The running indices of one module's taxels; empty for a module that does not exist.
    pub fn range(&self, module: usize) -> Range<usize> {
        match (self.starts.get(module), self.starts.get(module + 1)) {
            (Some(&from), Some(&to)) => from as usize..to as usize,
            _ => 0..0,
        }
    }
    /// Module and taxel of a running index.
    pub fn locate(&self, index: usize) -> Option<(usize, usize)> {
        let module = self.starts.partition_point(|&s| s as usize <= index);
        let module = module.checked_sub(1)?;
        (index < self.taxels()).then(|| (module, index - self.starts[module] as usize))
    }
}

/// Largest distance from an origin, mm: squares stay far from overflow.
const LARGEST_MM: f32 = 1e6;

/// The median distance to the nearest neighbour; refuses duplicates. Sweeps the points sorted by x.
fn spacing(points: &[Point]) -> Result<f32, LayoutError> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_unstable_by(|&a, &b| {
        let (p, q) = (points[a], points[b]);
        // + 0.0 makes -0 and 0 the same place
        (p.x + 0.0)
            .total_cmp(&(q.x + 0.0))
            .then((p.y + 0.0).total_cmp(&(q.y + 0.0)))
            .then(a.cmp(&b))
    });
    for pair in order.windows(2) {
        if points[pair[0]] == points[pair[1]] {
            return Err(LayoutError::Duplicate {
                first: pair[0].min(pair[1]),
                second: pair[0].max(pair[1]),
            });
        }
    }
    // A sample of points is enough for a median; a grid of a million needs no more.
    let step = points.len().div_ceil(1024);
    let mut nearest: Vec<f32> = (0..points.len())
        .step_by(step)
        .map(|at| {
            let p = points[order[at]];
            let near = |rest: &mut dyn Iterator<Item = &usize>, mut best: f32| {
                for &j in rest {
                    let q = points[j];
                    if (q.x - p.x) * (q.x - p.x) >= best {
                        break;
                    }
                    best = best.min(p.distance2(q));
                }
                best
            };
            let best = near(&mut order[at + 1..].iter(), f32::INFINITY);
            libm::sqrtf(near(&mut order[..at].iter().rev(), best))
        })
        .filter(|d| d.is_finite() && *d > 0.0)
        .collect();
    nearest.sort_unstable_by(f32::total_cmp);
    Ok(quantile(&nearest, 0.5).map_or(1.0, |middle| middle.above))
}

#[cfg(test)]
#[path = "layout_tests.rs"]
mod tests;
