//! The latent map: places of textures in a model, and their correlation with the surfaces' properties (figure 3.5).

use std::f64::consts::TAU;

use palpate_emulators::sensor::surface::spearman;
use palpate_files::{TextureEntry, TextureModel};
use palpate_run::plan::surface;
use serde_json::Value;

use crate::explore::Encoded;
use crate::round;

/// A coordinate of the latent space to look along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Index of the coordinate, from 0.
    pub coordinate: usize,
    /// Direction: -1 turns the axis round.
    pub sign: i8,
    /// Property that the coordinate stands for by the model's file; empty where the file names none.
    pub stands_for: &'static str,
}

impl Axis {
    /// Label of the axis, such as `-z2 (hardness)`.
    pub fn label(&self) -> String {
        let sign = if self.sign < 0 { "-" } else { "" };
        let name = format!("{sign}z{}", self.coordinate + 1);
        match self.stands_for {
            "" => name,
            what => format!("{name} ({what})"),
        }
    }
}

/// Two coordinates of the latent space to look along, each with its direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// Axis to the right: roughness, and friction with it where that has no coordinate of its own.
    pub x: Axis,
    /// Axis upwards: hardness.
    pub y: Axis,
}

impl View {
    /// The coordinates that the model's file names for roughness and for hardness. Where it names none, or the same
    /// for both, an axis is another coordinate and stands for nothing.
    pub fn new(model: &TextureModel) -> Self {
        let latent = model.metadata().get("latent").map_or("", String::as_str);
        Self::named_by(latent, model.latents())
    }

    /// View from the file's `latent` entry and the width of the latent vector.
    fn named_by(latent: &str, width: usize) -> Self {
        let latent: Value = serde_json::from_str(latent).unwrap_or_default();
        let named = |what: &str, stands_for| {
            let coordinate = usize::try_from(latent[what]["coordinate"].as_u64()?).ok()?;
            let sign = if latent[what]["sign"] == -1 { -1 } else { 1 };
            (coordinate < width).then_some(Axis {
                coordinate,
                sign,
                stands_for,
            })
        };
        let plain = |coordinate| Axis {
            coordinate,
            sign: 1,
            stands_for: "",
        };
        let beside = |axis: Axis| plain((axis.coordinate + 1) % width.max(1));
        let hard = named("hardness", "hardness");
        // A coordinate of its own for friction leaves roughness to the other.
        let rough = match latent["friction"].is_object() {
            true => "roughness",
            false => "roughness and friction",
        };
        let x = match (named("roughness", rough), hard) {
            (Some(x), Some(hard)) if x.coordinate == hard.coordinate => Axis {
                stands_for: "roughness, friction and hardness",
                ..x
            },
            (Some(x), _) => x,
            (None, Some(hard)) => beside(hard),
            (None, None) => plain(0),
        };
        let y = hard.filter(|y| y.coordinate != x.coordinate);
        Self {
            x,
            y: y.unwrap_or_else(|| beside(x)),
        }
    }

    fn point(self, z: &[f32]) -> (f64, f64) {
        let at = |axis: Axis| {
            f64::from(axis.sign) * z.get(axis.coordinate).map_or(0.0, |z| f64::from(*z))
        };
        (at(self.x), at(self.y))
    }
}

/// A mean, and the ellipse of one standard deviation around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Mean of all points.
    pub mean: (f64, f64),
    /// Half axes.
    pub half: (f64, f64),
    /// Direction of the first half axis, radians.
    pub turn: f64,
}

impl Spot {
    /// Mean and spread of some points; zeros for none.
    pub fn around(points: &[(f64, f64)]) -> Self {
        let n = points.len().max(1) as f64;
        let sum = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
        let (x, y) = (sum(&|p| p.0), sum(&|p| p.1));
        let xx = sum(&|p| (p.0 - x) * (p.0 - x));
        let yy = sum(&|p| (p.1 - y) * (p.1 - y));
        let xy = sum(&|p| (p.0 - x) * (p.1 - y));
        let (middle, reach) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
        let root = |variance: f64| variance.max(0.0).sqrt();
        Self {
            mean: (x, y),
            half: (root(middle + reach), root(middle - reach)),
            turn: 0.5 * (2.0 * xy).atan2(xx - yy),
        }
    }

    /// The ellipse, point by point and closed.
    pub(crate) fn outline(&self) -> Vec<(f64, f64)> {
        let (c, s) = (self.turn.cos(), self.turn.sin());
        let at = |step: u32| {
            let angle = TAU * f64::from(step) / 48.0;
            let (a, b) = (self.half.0 * angle.cos(), self.half.1 * angle.sin());
            (self.mean.0 + c * a - s * b, self.mean.1 + s * a + c * b)
        };
        (0..=48).map(at).collect()
    }
}

/// A texture on the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed<'a> {
    /// Texture that was stroked.
    pub entry: &'a TextureEntry,
    /// `true` where the model was trained on the texture: by its file, else by the table of textures.
    pub is_trained: bool,
    /// Latent vectors of every window of its strokes, on the two axes.
    pub points: Vec<(f64, f64)>,
    /// Mean and spread of the points.
    pub spot: Spot,
}

/// The textures of some strokes on a model's map, in their order.
pub fn place<'a>(encoded: &[Encoded<'a>], model: &TextureModel, view: View) -> Vec<Placed<'a>> {
    let of_texture = |strokes: &[Encoded<'a>]| {
        let latents = strokes.iter().flat_map(|stroke| &stroke.latents);
        let points: Vec<_> = latents.map(|z| view.point(z)).collect();
        let entry = strokes[0].entry;
        Placed {
            entry,
            is_trained: model.was_trained_on(&entry.name).unwrap_or(entry.trained),
            spot: Spot::around(&points),
            points,
        }
    };
    let textures = encoded.chunk_by(|a, b| a.entry.name == b.entry.name);
    textures.map(of_texture).collect()
}

/// Rank correlation of a coordinate with a property of surfaces: Spearman's, over the means of textures, three
/// decimals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rank {
    /// Name of the coordinate and of the property.
    pub what: &'static str,
    /// Correlation over all textures.
    pub all: f64,
    /// Correlation over textures that the model was not trained on.
    pub unseen: f64,
}

/// Rank correlations of the two coordinates with the surfaces' properties and, where all of them have ratings, with
/// these.
pub fn ranks(placed: &[Placed<'_>]) -> Vec<Rank> {
    type Coordinate = fn(&Spot) -> f64;
    type Property = fn(&TextureEntry) -> Option<f64>;
    let (x, y): (Coordinate, Coordinate) = (|spot| spot.mean.0, |spot| spot.mean.1);
    let rows: [(&str, Coordinate, Property); 6] = [
        ("x with the surface's roughness", x, |t| {
            Some(surface(t).drag_roughness())
        }),
        ("x with the surface's friction", x, |t| Some(t.friction)),
        ("x with rated roughness and friction", x, |t| {
            t.rated.map(|r| r.roughness + r.friction)
        }),
        ("y with the surface's stiffness", y, |t| {
            Some(t.stiffness_n_per_mm)
        }),
        ("y with rated hardness", y, |t| t.rated.map(|r| r.hardness)),
        ("x with the surface's stiffness", x, |t| {
            Some(t.stiffness_n_per_mm)
        }),
    ];
    let rank = |(what, of, with): (&'static str, Coordinate, Property)| {
        let over = |unseen: bool| {
            let some = placed.iter().filter(|p| !(unseen && p.is_trained));
            let pairs = some.map(|p| Some((of(&p.spot), with(p.entry)?)));
            let (a, b): (Vec<f64>, Vec<f64>) =
                pairs.collect::<Option<Vec<_>>>()?.into_iter().unzip();
            Some(round(spearman(&a, &b)))
        };
        Some(Rank {
            what,
            all: over(false)?,
            unseen: over(true)?,
        })
    };
    rows.into_iter().filter_map(rank).collect()
}

#[cfg(test)]
#[path = "map_tests.rs"]
mod tests;
