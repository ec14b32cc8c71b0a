//! The direction in which a wire's temperature goes.

/// Direction in which the wire's temperature goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heading {
    /// Heating.
    Up,
    /// Cooling.
    Down,
}
