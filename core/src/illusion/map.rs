//! The linear map from sensor to display millimetres, each axis on its own.

use crate::units::Point;

/// An axis-parallel rectangle, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    /// Lower left corner.
    pub min: Point,
    /// Upper right corner.
    pub max: Point,
}

impl Rect {
    /// The smallest rectangle around some points; an inside-out one if there are none.
    pub fn around(points: impl Iterator<Item = Point>) -> Self {
        let empty = Self {
            min: Point::new(f32::INFINITY, f32::INFINITY),
            max: Point::new(f32::NEG_INFINITY, f32::NEG_INFINITY),
        };
        points.fold(empty, |r, p| Self {
            min: Point::new(r.min.x.min(p.x), r.min.y.min(p.y)),
            max: Point::new(r.max.x.max(p.x), r.max.y.max(p.y)),
        })
    }

    /// Middle of the rectangle.
    pub fn centre(&self) -> Point {
        let middle = |low: f32, high: f32| 0.5 * (low + high);
        Point::new(
            middle(self.min.x, self.max.x),
            middle(self.min.y, self.max.y),
        )
    }

    /// Tells whether `other` lies inside, to a micrometre.
    pub fn covers(&self, other: &Self) -> bool {
        const SLACK: f32 = 1e-3;
        self.min.x <= other.min.x + SLACK
            && self.min.y <= other.min.y + SLACK
            && self.max.x >= other.max.x - SLACK
            && self.max.y >= other.max.y - SLACK
    }
}

/// Sensor space to display space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Map {
    from: Rect,
    scale: (f32, f32),
    offset: (f32, f32),
}

/// Reasons for which there is no map.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The sensor rectangle has no finite, positive extent along an axis the display spans.
    #[error(
        "expected a sensor rectangle of positive width and height wherever the display has one"
    )]
    Degenerate,
    /// The sensor rectangle reaches beyond the taxels, so a part of the display could never be
    /// reached: the display is not contained in the mapped sensor area.
    #[error(
        "the display is not contained in the mapped sensor area: expected a rectangle inside the taxels' hull"
    )]
    NotContained,
}

impl Map {
    /// Maps the rectangle `from` (sensor mm; default: the hull of the taxels) onto `display` (mm).
    /// `sensor` is the hull of the taxels.
    ///
    /// # Errors
    /// [`MapError`] when an axis cannot be mapped or part of the display would be out of reach.
    pub fn new(sensor: Rect, from: Option<Rect>, display: Rect) -> Result<Self, MapError> {
        let from = from.unwrap_or(sensor);
        if !sensor.covers(&from) {
            return Err(MapError::NotContained);
        }
        let axis = |s0: f32, s1: f32, d0: f32, d1: f32| {
            let (reach, span) = (s1 - s0, d1 - d0);
            if span <= 0.0 {
                // All wires agree on this axis: everything maps onto them.
                return Ok((0.0, d0));
            }
            if !(reach.is_finite() && reach > 0.0) {
                return Err(MapError::Degenerate);
            }
            let scale = span / reach;
            Ok((scale, d0 - scale * s0))
        };
        let (sx, ox) = axis(from.min.x, from.max.x, display.min.x, display.max.x)?;
        let (sy, oy) = axis(from.min.y, from.max.y, display.min.y, display.max.y)?;
        Ok(Self {
            from,
            scale: (sx, sy),
            offset: (ox, oy),
        })
    }

    /// Tells whether a sensor place lies in the rectangle that fills the display.
    pub fn shows(&self, s: Point) -> bool {
        self.from.covers(&Rect { min: s, max: s })
    }

    /// A sensor place in display millimetres.
    pub fn apply(&self, s: Point) -> Point {
        Point::new(
            s.x * self.scale.0 + self.offset.0,
            s.y * self.scale.1 + self.offset.1,
        )
    }
}

#[cfg(test)]
#[path = "map_tests.rs"]
mod tests;
