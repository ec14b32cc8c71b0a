//! Phantom sensation: which wire vibrates how strongly so that one touch is felt between them.

use crate::units::{Point, Ticks};

use super::display::Display;

/// Shape factors (s_x, s_y) of (5.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Along x.
    pub x: f32,
    /// Along y.
    pub y: f32,
}

/// The logarithmic activation of the thesis, (5.2):
///
/// `a_n = max(1 - (log2(|dx| + 1) / log2(D_x + 1))^s_x, 0) * (the same in y)`
///
/// Distances are in millimetres; the `+ 1` makes the law depend on that unit. On a wire a = 1 and its
/// neighbours are 0. Between two wires with s = 1 both get 0.23 .. 0.28: the gap that the thesis's
/// users felt, and this model keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogPhantom {
    shape: Shape,
    /// log2(D + 1) per axis; infinite on an axis without spacing, which then does not attenuate.
    reach: (f32, f32),
}

impl LogPhantom {
    /// The law for a display's spacings. Shape factors that are not finite and positive are refused.
    pub fn new(display: &Display, shape: Shape) -> Option<Self> {
        let good = |s: f32| s.is_finite() && s > 0.0;
        let (dx, dy) = display.spacing();
        let reach = (libm::log2f(dx + 1.0), libm::log2f(dy + 1.0));
        (good(shape.x) && good(shape.y)).then_some(Self { shape, reach })
    }

    /// Activation in [0, 1] of the wire at `wire` for a contact at `at` (both display mm).
    pub fn activation(&self, wire: Point, at: Point) -> f32 {
        let axis = |d: f32, reach: f32, s: f32| {
            // A quotient, not a product with a reciprocal: on a neighbour it is exactly one.
            let ratio = libm::log2f(libm::fabsf(d) + 1.0) / reach;
            // Most wires are out of reach: they need no power. NaN compares false and ends as 0.
            let inside = ratio < 1.0;
            if !inside {
                return 0.0;
            }
            // s = 1, the thesis's value, needs no power either; the result is the same to the bit.
            1.0 - if (s - 1.0).abs() < f32::EPSILON {
                ratio
            } else {
                libm::powf(ratio, s)
            }
        };
        let ax = axis(at.x - wire.x, self.reach.0, self.shape.x);
        if ax <= 0.0 {
            return 0.0;
        }
        ax * axis(at.y - wire.y, self.reach.1, self.shape.y)
    }
}

/// From activation to duty, (5.1) with intensity: `A = alpha + beta g a` for a > 0, else off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Duty offset, a fraction of a period; raises only wires that are active.
    pub alpha: f32,
    /// Duty range, a fraction of a period (thesis: 100 / 4096).
    pub beta: f32,
    /// Weight g of the weakest intensity level, in (0, 1]; 1 is the thesis's constant beta. Levels
    /// between are spaced evenly up to g = 1 at the top.
    pub floor: f32,
}

impl Drive {
    /// g(level): monotone, 1 at the top level.
    pub fn weight(&self, level: u16, levels: u16) -> f32 {
        if levels <= 1 {
            return 1.0;
        }
        let part = f32::from(level.clamp(1, levels) - 1) / f32::from(levels - 1);
        self.floor + (1.0 - self.floor) * part
    }

    /// Pulse width for an activation already weighted by g.
    pub fn width(&self, activation: f32) -> Ticks {
        if activation > 0.0 {
            Ticks::from_duty(self.alpha + self.beta * activation)
        } else {
            Ticks::ZERO
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::display::tests::thimble;
    use super::*;

    const ONE: Shape = Shape { x: 1.0, y: 1.0 };

    #[test]
    fn a_wire_under_the_contact_is_alone() {
        let display = thimble();
        let law = LogPhantom::new(&display, ONE).unwrap();
        for (n, wire) in display.wires().iter().enumerate() {
            for (m, other) in display.wires().iter().enumerate() {
                let a = law.activation(other.place, wire.place);
                assert_eq!(
                    a,
                    if n == m { 1.0 } else { 0.0 },
                    "contact on {n}, wire {m}"
                );
            }
        }
    }

    #[test]
    fn midpoints_have_the_dip_of_the_thesis() {
        // 1 - log2(d/2 + 1) / log2(d + 1) by hand: log2 4.25 / log2 7.5 and 3 / log2 15.
        for (spacing, expected) in [(6.5f32, 0.281_9f64), (14.0, 0.232_1)] {
            let exact =
                1.0 - (f64::from(spacing) / 2.0 + 1.0).log2() / (f64::from(spacing) + 1.0).log2();
            let wire = |x: f32, c| super::super::Wire {
                place: Point::new(x, 0.0),
                board: crate::units::Board(0),
                channel: crate::units::Channel(c),
            };
            let display = Display::new(&[wire(0.0, 0), wire(spacing, 1)]).unwrap();
            let law = LogPhantom::new(&display, ONE).unwrap();
            let a = f64::from(law.activation(Point::new(0.0, 0.0), Point::new(spacing / 2.0, 0.0)));
            assert!((a - exact).abs() < 1e-6);
            assert!((a - expected).abs() < 1e-3, "{spacing}: {a}");
        }
    }

    #[test]
    fn shape_one_is_the_power_law_at_one() {
        let display = thimble();
        let one = LogPhantom::new(&display, ONE).unwrap();
        let near = LogPhantom::new(
            &display,
            Shape {
                x: 1.0 + 1e-5,
                y: 1.0 + 1e-5,
            },
        )
        .unwrap();
        for i in 0..200 {
            let at = Point::new(-11.0 + 0.11 * i as f32, 14.0 - 0.14 * i as f32);
            for wire in display.wires() {
                let d = one.activation(wire.place, at) - near.activation(wire.place, at);
                assert!(d.abs() < 1e-4);
            }
        }
    }

    #[test]
    fn nothing_active_means_off_even_with_an_offset() {
        let drive = Drive {
            alpha: 0.01,
            beta: 0.0244,
            floor: 0.5,
        };
        assert_eq!(drive.width(0.0), Ticks::ZERO);
        assert_eq!(drive.width(1.0), Ticks::from_duty(0.0344));
        assert_eq!(drive.width(f32::NAN), Ticks::ZERO);
        assert_eq!(drive.weight(1, 10), 0.5);
        assert_eq!(drive.weight(10, 10), 1.0);
        assert_eq!(drive.weight(1, 1), 1.0);
    }

    #[test]
    fn bad_shapes_and_places_do_not_spread() {
        let display = thimble();
        for s in [0.0, -1.0, f32::NAN, f32::INFINITY] {
            assert!(LogPhantom::new(&display, Shape { x: s, y: 1.0 }).is_none());
        }
        let law = LogPhantom::new(&display, ONE).unwrap();
        for bad in [f32::NAN, f32::INFINITY, f32::MAX] {
            let a = law.activation(Point::new(0.0, 4.75), Point::new(bad, 0.0));
            assert_eq!(a, 0.0);
        }
    }
}
