//! The interface of every law of an illusion, and why one is refused.

use core::fmt;

use crate::units::{Duration, Point};

/// A law that makes one touch felt between wires.
///
/// Every law gives activations in [0, 1], 1 on a wire and 0 to wires out of its reach, whatever the order
/// of the wires. A place that is no number activates nothing.
pub trait Illusion: fmt::Debug + Send + Sync {
    /// Writes the activation of every wire, by its index, for a contact at `at` (display mm).
    fn activate(&self, at: Point, out: &mut [f32]);

    /// Time for which a wire is on at the next onset; `None` for the duration of every stimulus.
    fn lasts(&self, wire: usize) -> Option<Duration> {
        let _ = wire;
        None
    }
}

/// Reasons for which a law does not fit a display, or its settings a law.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum IllusionError {
    /// A display of one wire, which has no place between wires.
    #[error("two wires or more: with one there is no place between (`nearest` takes one)")]
    OneWire,
    /// Wires in one line for the law of the three nearest.
    #[error("wires that are not in one line: three-nearest needs triangles")]
    InLine,
    /// A shape that is no positive number, or of a model that has none.
    #[error(
        "a shape above 0 for phantom, balanced or gaussian, `flat` for phantom only, and none for the others"
    )]
    Shape,
    /// Distances that the model does not know.
    #[error(
        "`axes` for phantom, energy, linear or square, `plane` for any, `space` for phantom, three-nearest, gaussian or nearest"
    )]
    Distances,
    /// A margin that is no positive number.
    #[error("a margin above 0")]
    Margin,
}
