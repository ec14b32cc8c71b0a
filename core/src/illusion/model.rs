//! The choice of an illusion: its name and settings to one trait behind which every law stands.

use alloc::boxed::Box;

use crate::listed::listed;

use super::cells::Cells;
use super::display::Display;
use super::inverse::Inverse;
use super::law::{Illusion, IllusionError};
use super::phantom::{LogPhantom, RadialPhantom, Shape};
use super::reach::{Gaussian, Metric, Nearest, ThreeNearest};
use super::shares::{AxisShares, CellShares, Power};
use super::surface::Surface;

listed! {
    /// The laws by name.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
    pub enum IllusionModel: name {
        /// The thesis's (5.2), logarithmic.
        Phantom = "phantom",
        /// Square roots of shares: the energy centroid is the contact (Israr and Poupyrev 2011).
        Energy = "energy",
        /// Shares: the amplitude centroid is the contact.
        Linear = "linear",
        /// Squares of shares: gentle on both sides of a wire, weak between.
        Square = "square",
        /// Shares to a power between those of energy and linear, scaled to one energy everywhere.
        Balanced = "balanced",
        /// Puts both felt centroids at the contact, by amplitudes and numbers of pulses within the limits of heat.
        #[default]
        Inverse = "inverse",
        /// Three nearest wires by inverse distance (Park 2016).
        ThreeNearest = "three-nearest",
        /// A bell around each wire.
        Gaussian = "gaussian",
        /// The nearest wire alone: recognised best, not smooth (Tang and McMahan 2019).
        Nearest = "nearest",
    }
}

impl IllusionModel {
    /// The shape where none is stated: s of (5.2), the balanced law's exponent, the bell's width as a
    /// share of the gap (0.6 makes midpoints flat). The other laws have none.
    pub const fn shape(self) -> Option<f32> {
        match self {
            Self::Phantom => Some(1.0),
            Self::Balanced => Some(BALANCED),
            Self::Gaussian => Some(0.6),
            _ => None,
        }
    }

    /// The distances where none are stated.
    pub const fn distances(self) -> Distances {
        match self {
            Self::Phantom => Distances::Axes,
            _ => Distances::Plane,
        }
    }
}

/// Exponent of the balanced law: where both centroids are off by about as much (`docs/illusion.md` has
/// the curve).
const BALANCED: f32 = 0.65;

/// Measure of the distance from a contact to a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distances {
    /// Distance along each axis on its own.
    Axes,
    /// Distance in the unrolled plane.
    Plane,
    /// Straight distance through space, on the display's surface.
    Space,
}

/// A shape factor, or the wish for flat midpoints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ShapeChoice {
    /// The model's own shape.
    #[default]
    Model,
    /// A stated factor.
    Factor(f32),
    /// The factors s_x and s_y of (5.2), for the phantom law along the axes alone.
    Axes(f32, f32),
    /// The factor of (5.2) that makes midpoints flat, from the spacings.
    Flat,
}

/// Settings from which an illusion is built.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelSettings {
    /// The law.
    pub model: IllusionModel,
    /// Shape of the law.
    pub shape: ShapeChoice,
    /// Measure of distances; `None` for the model's own.
    pub distances: Option<Distances>,
    /// Distance beyond the hull within which laws over shares still render a contact, as a part of the smallest gap
    /// between wires; half a gap if not stated.
    pub margin: Option<f32>,
}

/// Builds a law for a display; the last time it allocates.
///
/// # Errors
/// [`IllusionError`] for a display that the law cannot be laid over, and for settings it does not know.
pub fn build(
    display: &Display,
    settings: &ModelSettings,
) -> Result<Box<dyn Illusion>, IllusionError> {
    let model = settings.model;
    let distances = settings.distances.unwrap_or(model.distances());
    let surface = match distances {
        Distances::Space => display.surface(),
        Distances::Axes | Distances::Plane => Surface::Flat,
    };
    if display.wires().len() < 2 && model != IllusionModel::Nearest {
        return Err(IllusionError::OneWire);
    }
    let shape = match settings.shape {
        ShapeChoice::Flat if model == IllusionModel::Phantom => None,
        ShapeChoice::Flat => return Err(IllusionError::Shape),
        ShapeChoice::Model => Some(model.shape().unwrap_or(1.0)),
        ShapeChoice::Factor(s) if model.shape().is_some() && s.is_finite() && s > 0.0 => Some(s),
        ShapeChoice::Axes(x, y)
            if model == IllusionModel::Phantom && distances == Distances::Axes =>
        {
            let law = LogPhantom::new(display, Shape { x, y })?;
            return Ok(Box::new(law));
        }
        ShapeChoice::Factor(_) | ShapeChoice::Axes(..) => return Err(IllusionError::Shape),
    };
    let metric = || Metric::new(display, surface);
    let cells = || Cells::new(display).ok_or(IllusionError::OneWire);
    let share = |exponent: f32, level: bool| -> Result<Box<dyn Illusion>, IllusionError> {
        let power = Power { exponent, level };
        match distances {
            Distances::Axes if !level => Ok(Box::new(AxisShares::new(display, power))),
            Distances::Plane => Ok(Box::new(CellShares::new(
                cells()?,
                power,
                margin_mm(display, settings)?,
            ))),
            _ => Err(IllusionError::Distances),
        }
    };
    match (model, distances) {
        (IllusionModel::Phantom, Distances::Axes) => {
            let (dx, dy) = display.spacing();
            let shape = Shape {
                x: shape.unwrap_or(Shape::flat(dx)),
                y: shape.unwrap_or(Shape::flat(dy)),
            };
            Ok(Box::new(LogPhantom::new(display, shape)?))
        }
        (IllusionModel::Phantom, _) => {
            let of_gap = |gap: f32| shape.unwrap_or(Shape::flat(gap));
            Ok(Box::new(RadialPhantom::new(metric(), of_gap)?))
        }
        (IllusionModel::Energy, _) => share(0.5, false),
        (IllusionModel::Linear, _) => share(1.0, false),
        (IllusionModel::Square, _) => share(2.0, false),
        (IllusionModel::Balanced, _) => share(shape.unwrap_or(BALANCED), true),
        (IllusionModel::Inverse, _) => Ok(Box::new(inverse(display, settings)?)),
        (_, Distances::Axes) => Err(IllusionError::Distances),
        (IllusionModel::ThreeNearest, _) => {
            let cells = cells()?;
            if cells.in_line() {
                return Err(IllusionError::InLine);
            }
            Ok(Box::new(ThreeNearest::new(display, metric(), cells)))
        }
        (IllusionModel::Gaussian, _) => Ok(Box::new(Gaussian::new(metric(), shape.unwrap_or(0.6)))),
        (IllusionModel::Nearest, _) => Ok(Box::new(Nearest::new(metric()))),
    }
}

/// Distance beyond the hull at which laws over shares end, mm.
fn margin_mm(display: &Display, settings: &ModelSettings) -> Result<f32, IllusionError> {
    let margin = settings.margin.unwrap_or(0.5);
    match margin.is_finite() && margin > 0.0 {
        true => Ok(margin * display.gap()),
        false => Err(IllusionError::Margin),
    }
}

/// The law that the renderer splits contacts with, whatever model the settings name.
///
/// # Errors
/// [`IllusionError`] for a display that the law cannot be laid over, and for settings it does not know.
pub fn inverse(display: &Display, settings: &ModelSettings) -> Result<Inverse, IllusionError> {
    if settings.distances.is_some_and(|d| d != Distances::Plane) {
        return Err(IllusionError::Distances);
    }
    if settings.shape != ShapeChoice::Model {
        return Err(IllusionError::Shape);
    }
    let cells = Cells::new(display).ok_or(IllusionError::OneWire)?;
    Ok(Inverse::new(cells, margin_mm(display, settings)?))
}
