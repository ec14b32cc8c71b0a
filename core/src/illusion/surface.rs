//! The surface that a display's wires lie on: flat, or a finger whose skin has been unrolled.

use crate::units::Point;

/// Shape in space of the surface that was unrolled into the plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Surface {
    /// The plane is the surface.
    #[default]
    Flat,
    /// A cylinder with a rounded end. The plane's x runs around it, y along it; from `tip_mm` on the
    /// meridians follow a hemisphere of the same radius. Lengths along x and y are kept on the cylinder;
    /// on the tip those along y are.
    Finger {
        /// Radius of cylinder and tip, mm.
        radius_mm: f32,
        /// The y at which the cylinder ends, mm.
        tip_mm: f32,
    },
}

impl Surface {
    /// A place of the plane in space, mm; on a finger the axis is the second coordinate.
    pub fn lift(self, at: Point) -> [f32; 3] {
        match self {
            Self::Flat => [at.x, at.y, 0.0],
            Self::Finger { radius_mm, tip_mm } => {
                let around = at.x / radius_mm;
                // Beyond the pole there is no skin.
                let over = ((at.y - tip_mm) / radius_mm).clamp(0.0, core::f32::consts::FRAC_PI_2);
                let ring = radius_mm * libm::cosf(over);
                let along = at.y.min(tip_mm) + radius_mm * libm::sinf(over);
                [ring * libm::sinf(around), along, ring * libm::cosf(around)]
            }
        }
    }
}

/// Squared straight distance of two places in space, mm2.
pub(super) fn distance2(a: [f32; 3], b: [f32; 3]) -> f32 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}

#[cfg(test)]
#[path = "surface_tests.rs"]
mod tests;
