//! The wires of a display: positions on its unrolled surface, spacings, hull.

use alloc::boxed::Box;
use alloc::vec::Vec;

use crate::units::{Board, Channel, Point};

use super::geometry::{foot, left_of};
use super::map::Rect;
use super::surface::Surface;

/// One wire: where it lies and which output drives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayWire {
    /// Place on the unrolled display, mm.
    pub place: Point,
    /// Board whose output feeds its amplifier.
    pub board: Board,
    /// Channel of that board.
    pub channel: Channel,
}

/// A display: its wires in the order of their indices, and what follows from their places.
#[derive(Clone, Debug, PartialEq)]
pub struct Display {
    wires: Box<[DisplayWire]>,
    hull: Box<[Point]>,
    spacing: (f32, f32),
    surface: Surface,
}

/// Reasons for which an arrangement of wires is no display.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DisplayError {
    /// No wire at all.
    #[error("a display needs at least one wire")]
    Empty,
    /// More wires than 16 boards of 16 channels can drive.
    #[error("a display has at most 256 wires, found {0}")]
    TooMany(usize),
    /// A coordinate of this wire is not a finite number.
    #[error("wire {0}: expected finite coordinates in mm")]
    NotFinite(usize),
    /// These two wires lie at the same place.
    #[error("wires {0} and {1} lie at the same place")]
    Coincident(usize, usize),
    /// These two wires are driven by the same output.
    #[error("wires {0} and {1} share one board and channel")]
    SharedOutput(usize, usize),
    /// A wire whose channel is not 0 ..= 15, or its board not 0 ..= 15.
    #[error("wire {0}: expected board 0..15 and channel 0..15")]
    NoSuchOutput(usize),
}

impl Display {
    /// A display from its wires; the spacings of (5.2) are the smallest gaps between distinct columns
    /// and rows.
    ///
    /// # Errors
    /// [`DisplayError`] for a wire at no place, on another wire, or on an output that does not exist or is taken.
    pub fn new(wires: &[DisplayWire]) -> Result<Self, DisplayError> {
        if wires.is_empty() {
            return Err(DisplayError::Empty);
        }
        if wires.len() > 256 {
            return Err(DisplayError::TooMany(wires.len()));
        }
        for (i, wire) in wires.iter().enumerate() {
            if !(wire.place.x.is_finite() && wire.place.y.is_finite()) {
                return Err(DisplayError::NotFinite(i));
            }
            if wire.board.0 > 15 || wire.channel.0 > 15 {
                return Err(DisplayError::NoSuchOutput(i));
            }
            for (j, other) in wires[..i].iter().enumerate() {
                if wire.place.distance2(other.place) < 1e-6 {
                    return Err(DisplayError::Coincident(j, i));
                }
                if (wire.board, wire.channel) == (other.board, other.channel) {
                    return Err(DisplayError::SharedOutput(j, i));
                }
            }
        }
        let places: Vec<Point> = wires.iter().map(|w| w.place).collect();
        let spacing = (
            gap(places.iter().map(|p| p.x)),
            gap(places.iter().map(|p| p.y)),
        );
        Ok(Self {
            wires: wires.into(),
            hull: convex_hull(places),
            spacing,
            surface: Surface::Flat,
        })
    }

    /// Sets the spacings (D_x, D_y) of (5.2), mm, where the wires are no regular grid. An axis on which all wires agree
    /// keeps its infinite one.
    #[must_use]
    pub fn with_spacing(mut self, (dx, dy): (f32, f32)) -> Self {
        let (x, y) = self.spacing;
        let stated = |found: f32, stated: f32| if found.is_finite() { stated } else { found };
        self.spacing = (stated(x, dx), stated(y, dy));
        self
    }

    /// Puts the display on this surface in space.
    #[must_use]
    pub const fn with_surface(mut self, surface: Surface) -> Self {
        self.surface = surface;
        self
    }

    /// The surface that was unrolled.
    pub const fn surface(&self) -> Surface {
        self.surface
    }

    /// The smallest distance of two wires, mm; infinite for a single one.
    pub fn gap(&self) -> f32 {
        let places = || self.wires.iter().map(|w| w.place);
        let to_earlier = |(i, p): (usize, Point)| places().take(i).map(move |q| p.distance2(q));
        let least = places().enumerate().flat_map(to_earlier);
        libm::sqrtf(least.fold(f32::INFINITY, f32::min))
    }

    /// The wires by index.
    pub const fn wires(&self) -> &[DisplayWire] {
        &self.wires
    }

    /// Actuator spacings (D_x, D_y) of (5.2), mm; infinite along an axis on which all wires agree, so
    /// that this axis does not attenuate.
    pub const fn spacing(&self) -> (f32, f32) {
        self.spacing
    }

    /// Corners of the convex hull, counter-clockwise.
    pub const fn hull(&self) -> &[Point] {
        &self.hull
    }

    /// The smallest rectangle around all wires.
    pub fn bounds(&self) -> Rect {
        Rect::around(self.wires.iter().map(|w| w.place))
    }

    /// Tells whether a place lies inside the hull or within `margin` mm of it.
    pub fn contains(&self, at: Point, margin: f32) -> bool {
        let n = self.hull.len();
        if n >= 3 && (0..n).all(|i| left_of(self.hull[i], self.hull[(i + 1) % n], at) >= 0.0) {
            return true;
        }
        (0..n).any(|i| at.distance(foot(self.hull[i], self.hull[(i + 1) % n], at)) <= margin)
    }
}

/// Smallest gap between distinct values (1 um apart or more); infinite when there is only one.
fn gap(values: impl Iterator<Item = f32>) -> f32 {
    let mut sorted: Vec<f32> = values.collect();
    sorted.sort_unstable_by(f32::total_cmp);
    let gaps = sorted.windows(2).map(|w| w[1] - w[0]).filter(|&d| d > 1e-3);
    gaps.fold(f32::INFINITY, f32::min)
}

/// Andrew's monotone chain (1979).
fn convex_hull(mut points: Vec<Point>) -> Box<[Point]> {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    if points.len() < 3 {
        return points.into();
    }
    let mut hull: Vec<Point> = Vec::with_capacity(points.len() + 1);
    let mut half = |points: &mut dyn Iterator<Item = Point>| {
        let start = hull.len();
        for p in points {
            while hull.len() >= start + 2
                && left_of(hull[hull.len() - 2], hull[hull.len() - 1], p) <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop(); // the last point starts the other half
    };
    half(&mut points.iter().copied());
    half(&mut points.iter().rev().copied());
    hull.into()
}

#[cfg(test)]
#[path = "display_tests.rs"]
pub(crate) mod tests;
