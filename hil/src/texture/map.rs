//! The latent map: where a model puts textures, and how that goes with what the surfaces are like (figure 3.5).

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::TextureModel;
use super::explore::{Encoded, surface};
use palpate_emulators::surface::spearman;
use palpate_files::TextureEntry;

/// A coordinate of the latent space to look along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Which, from 0.
    pub coordinate: usize,
    /// -1 turns it round.
    pub sign: i8,
    /// What the model's file says it stands for; empty where the file says nothing of it.
    pub stands_for: &'static str,
}

impl Axis {
    /// A coordinate of which nothing is known.
    const fn plain(coordinate: usize) -> Self {
        Self {
            coordinate,
            sign: 1,
            stands_for: "",
        }
    }

    /// As an axis is labelled, such as `-z2 (hardness)`.
    pub fn label(&self) -> String {
        let name = format!(
            "{}z{}",
            if self.sign < 0 { "-" } else { "" },
            self.coordinate + 1
        );
        match self.stands_for {
            "" => name,
            what => format!("{name} ({what})"),
        }
    }
}

/// Two coordinates of the latent space to look along, each with its direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// To the right: roughness and friction.
    pub x: Axis,
    /// Upwards: hardness.
    pub y: Axis,
}

impl View {
    /// The coordinates that the model's file names for roughness and for hardness. Where it names none, or the same
    /// for both, an axis is another coordinate and stands for nothing.
    pub fn of(model: &TextureModel) -> Self {
        let latent = model.metadata().get("latent").map_or("", String::as_str);
        Self::named_by(latent, model.latents())
    }

    /// The same from the file's `latent` entry and the width of the latent vector.
    fn named_by(latent: &str, width: usize) -> Self {
        let latent: Value = serde_json::from_str(latent).unwrap_or_default();
        let named = |what: &str, stands_for| {
            let coordinate = usize::try_from(latent[what]["coordinate"].as_u64()?)
                .ok()
                .filter(|c| *c < width)?;
            let sign = if latent[what]["sign"] == -1 { -1 } else { 1 };
            Some(Axis {
                coordinate,
                sign,
                stands_for,
            })
        };
        let rough = named("roughness", "roughness and friction");
        let hard = named("hardness", "hardness");
        let beside = |axis: Axis| Axis::plain((axis.coordinate + 1) % width.max(1));
        match (rough, hard) {
            (Some(rough), Some(hard)) if rough.coordinate == hard.coordinate => {
                let stands_for = "roughness, friction and hardness";
                let x = Axis {
                    stands_for,
                    ..rough
                };
                Self { x, y: beside(x) }
            }
            (Some(x), Some(y)) => Self { x, y },
            (Some(x), None) => Self { x, y: beside(x) },
            (None, Some(y)) => Self { x: beside(y), y },
            (None, None) => {
                let x = Axis::plain(0);
                Self { x, y: beside(x) }
            }
        }
    }

    fn point(self, z: &[f32]) -> (f64, f64) {
        let at = |axis: Axis| {
            f64::from(axis.sign) * z.get(axis.coordinate).map_or(0.0, |z| f64::from(*z))
        };
        (at(self.x), at(self.y))
    }
}

/// One texture on the map: mean, and the ellipse of one standard deviation around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Mean of all windows.
    pub mean: (f64, f64),
    /// Half axes.
    pub half: (f64, f64),
    /// Direction of the first half axis, radians.
    pub turn: f64,
}

impl Spot {
    /// Of some points; `None` of none.
    pub fn of(points: &[(f64, f64)]) -> Option<Self> {
        let n = points.len() as f64;
        if points.is_empty() {
            return None;
        }
        let sum = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
        let (x, y) = (sum(&|p| p.0), sum(&|p| p.1));
        let (xx, yy) = (
            sum(&|p| (p.0 - x) * (p.0 - x)),
            sum(&|p| (p.1 - y) * (p.1 - y)),
        );
        let xy = sum(&|p| (p.0 - x) * (p.1 - y));
        let (middle, reach) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(xy));
        Some(Self {
            mean: (x, y),
            half: (
                (middle + reach).max(0.0).sqrt(),
                (middle - reach).max(0.0).sqrt(),
            ),
            turn: 0.5 * (2.0 * xy).atan2(xx - yy),
        })
    }

    /// The ellipse, point by point and closed.
    pub(super) fn outline(&self) -> Vec<(f64, f64)> {
        let (c, s) = (self.turn.cos(), self.turn.sin());
        let at = |step: u32| {
            let angle = TAU * f64::from(step) / 48.0;
            let (a, b) = (self.half.0 * angle.cos(), self.half.1 * angle.sin());
            (self.mean.0 + c * a - s * b, self.mean.1 + s * a + c * b)
        };
        (0..=48).map(at).collect()
    }
}

/// The textures of some strokes, in their order, each with its points.
pub(super) fn by_texture<'a>(
    encoded: &[Encoded<'a>],
    view: View,
) -> Vec<(&'a TextureEntry, Vec<(f64, f64)>)> {
    let mut all: Vec<(&TextureEntry, Vec<(f64, f64)>)> = Vec::new();
    for stroke in encoded {
        let points = stroke.latents.iter().map(|z| view.point(z));
        match all
            .iter_mut()
            .find(|(entry, _)| entry.name == stroke.entry.name)
        {
            Some((_, there)) => there.extend(points),
            None => all.push((stroke.entry, points.collect())),
        }
    }
    all
}

/// Where the textures are, and how the two coordinates go with what the surfaces are like and how they are rated:
/// Spearman's rank correlation over the means of the textures, of all and of the unseen ones.
pub fn figures(encoded: &[Encoded<'_>], view: View) -> Value {
    let all = by_texture(encoded, view);
    let spots: Vec<_> = all
        .iter()
        .filter_map(|(entry, points)| Some((*entry, Spot::of(points)?)))
        .collect();
    let textures = spots.iter().map(|(entry, spot)| {
        json!({
            "name": entry.name,
            "trained": entry.trained,
            "x": round(spot.mean.0),
            "y": round(spot.mean.1),
            "half_axes": [round(spot.half.0), round(spot.half.1)],
        })
    });
    let correlation = |of: fn(&Spot) -> f64, with: fn(&TextureEntry) -> f64, unseen: bool| {
        let some = spots.iter().filter(|(entry, _)| !(unseen && entry.trained));
        let (a, b): (Vec<f64>, Vec<f64>) =
            some.map(|(entry, spot)| (of(spot), with(entry))).unzip();
        round(spearman(&a, &b))
    };
    type Row = (&'static str, fn(&Spot) -> f64, fn(&TextureEntry) -> f64);
    let rows: [Row; 6] = [
        (
            "x with the surface's roughness",
            |s| s.mean.0,
            |t| surface(t).drag_roughness(),
        ),
        (
            "x with the surface's friction",
            |s| s.mean.0,
            |t| t.friction,
        ),
        (
            "x with rated roughness and friction",
            |s| s.mean.0,
            |t| t.rated.roughness + t.rated.friction,
        ),
        (
            "y with the surface's stiffness",
            |s| s.mean.1,
            |t| t.stiffness_n_per_mm,
        ),
        ("y with rated hardness", |s| s.mean.1, |t| t.rated.hardness),
        (
            "x with the surface's stiffness",
            |s| s.mean.0,
            |t| t.stiffness_n_per_mm,
        ),
    ];
    let ranks: Vec<Value> = rows
        .iter()
        .map(|(what, of, with)| {
            json!({"what": what, "all": correlation(*of, *with, false), "unseen": correlation(*of, *with, true)})
        })
        .collect();
    let axis = |a: Axis| json!({"coordinate": a.coordinate + 1, "sign": a.sign, "stands_for": a.stands_for});
    json!({
        "x": axis(view.x),
        "y": axis(view.y),
        "textures": textures.collect::<Vec<_>>(),
        "spearman": ranks,
    })
}

/// Three decimals; no minus before a zero.
fn round(value: f64) -> f64 {
    (value * 1e3).round() / 1e3 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_says_only_what_the_file_names() {
        let labels = |latent: &str, width| {
            let view = View::named_by(latent, width);
            (view.x.label(), view.y.label())
        };
        let of = |rough: &str, hard: &str| format!("{{\"roughness\":{rough},\"hardness\":{hard}}}");
        let (first, third) = (
            r#"{"coordinate":0,"sign":1}"#,
            r#"{"coordinate":2,"sign":-1}"#,
        );
        let says = |latent: &str| labels(latent, 3);
        let pair = |x: &str, y: &str| (x.to_owned(), y.to_owned());
        assert_eq!(
            says(&of(first, third)),
            pair("z1 (roughness and friction)", "-z3 (hardness)")
        );
        assert_eq!(
            says(&of(third, third)),
            pair("-z3 (roughness, friction and hardness)", "z1")
        );
        assert_eq!(says(&of("null", first)), pair("z2", "z1 (hardness)"));
        assert_eq!(
            says(&of(first, "null")),
            pair("z1 (roughness and friction)", "z2")
        );
        for nothing in [
            "",
            "{}",
            "[",
            &of("{\"coordinate\":3}", "{\"coordinate\":-1}"),
        ] {
            assert_eq!(says(nothing), pair("z1", "z2"));
        }
        assert_eq!(labels("", 1), pair("z1", "z1"));
    }

    #[test]
    fn an_ellipse_lies_along_its_points() {
        // on a line along (3, 4), two of four at a distance of 5: a variance of 12.5
        let points = [(3.0, 4.0), (-3.0, -4.0), (0.0, 0.0), (0.0, 0.0)];
        let spot = Spot::of(&points).unwrap();
        assert!(spot.mean.0.abs() < 1e-12 && spot.mean.1.abs() < 1e-12);
        assert!((spot.half.0 - 12.5f64.sqrt()).abs() < 1e-9 && spot.half.1.abs() < 1e-6);
        assert!((spot.turn - (4.0f64).atan2(3.0)).abs() < 1e-9);
        assert_eq!(Spot::of(&[]), None);
    }
}
