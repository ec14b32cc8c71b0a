//! The latent map: where a model puts textures, and how that goes with what the surfaces are like (figure 3.5).

use std::f64::consts::TAU;
use std::fmt::Write;

use palpate_records::report::STYLE;
use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{Plot, Svg, dot};
use serde_json::{Value, json};

use super::TextureModel;
use super::explore::{Encoded, surface};
use palpate_files::TextureEntry;

/// Two coordinates of the latent space to look along, each with its direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// To the right: roughness and friction.
    pub x: (usize, i8),
    /// Upwards: hardness.
    pub y: (usize, i8),
}

impl View {
    /// The coordinates that the model's file names for roughness and hardness; z1 and z2 where it names none. If both
    /// are the same, hardness gets the next one.
    pub fn of(model: &TextureModel) -> Self {
        let width = model.latents().max(1);
        let latent: Value = model
            .metadata()
            .get("latent")
            .and_then(|text| serde_json::from_str(text).ok())
            .unwrap_or_default();
        let named = |what: &str| {
            let coordinate = usize::try_from(latent[what]["coordinate"].as_u64()?)
                .ok()
                .filter(|c| *c < width)?;
            Some((coordinate, if latent[what]["sign"] == -1 { -1 } else { 1 }))
        };
        let x = named("roughness").unwrap_or((0, 1));
        let y = named("hardness").unwrap_or((1 % width, 1));
        let y = if y.0 == x.0 {
            ((x.0 + 1) % width, 1)
        } else {
            y
        };
        Self { x, y }
    }

    fn point(self, z: &[f32]) -> (f64, f64) {
        let at = |(c, sign): (usize, i8)| f64::from(sign) * z.get(c).map_or(0.0, |z| f64::from(*z));
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

    fn outline(&self) -> Vec<(f64, f64)> {
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
fn by_texture<'a>(encoded: &[Encoded<'a>], view: View) -> Vec<(&'a TextureEntry, Vec<(f64, f64)>)> {
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

/// A map drawn: SVG as a file of its own. Trained textures have whole ellipses, unseen ones dashed.
pub fn draw(encoded: &[Encoded<'_>], view: View, title: &str) -> String {
    let all = by_texture(encoded, view);
    let places = || all.iter().flat_map(|(_, points)| points);
    let range = |of: fn(&(f64, f64)) -> f64| {
        let low = places().map(of).fold(f64::INFINITY, f64::min);
        Scale::round(low, places().map(of).fold(f64::NEG_INFINITY, f64::max))
    };
    let (width, height) = (860.0, 560.0);
    let mut svg = Svg::new(width, height, title);
    let plot = Plot {
        left: 64.0,
        top: 30.0,
        width: width - 104.0,
        height: height - 80.0,
        x: range(|p| p.0),
        y: range(|p| p.1),
    };
    let name = |(c, sign): (usize, i8)| format!("{}z{}", if sign < 0 { "-" } else { "" }, c + 1);
    plot.x_axis(
        &mut svg,
        &format!("{} (roughness and friction)", name(view.x)),
    );
    plot.y_axis(&mut svg, &format!("{} (hardness)", name(view.y)));
    plot.frame(&mut svg);
    for (i, (_, points)) in all.iter().enumerate() {
        let mut dots = String::new();
        points.iter().for_each(|p| dot(&mut dots, plot.at(*p)));
        svg.path(&dots, &format!("dots faint w{}", i % 8));
    }
    for (i, (entry, points)) in all.iter().enumerate() {
        let Some(spot) = Spot::of(points) else {
            continue;
        };
        let mut line = String::new();
        let outline = spot.outline();
        // each name at another place of its ring: the middles may all be one
        let (x, y) = plot.at(outline[6 * (i % 8)]);
        for (x, y) in outline.into_iter().map(|p| plot.at(p)) {
            let _ = write!(
                line,
                "{}{x:.1} {y:.1}",
                if line.is_empty() { 'M' } else { 'L' }
            );
        }
        let dashed = if entry.trained { "" } else { " unseen" };
        svg.path(&line, &format!("series ring{dashed} w{}", i % 8));
        svg.text((x, y + 4.0), "label middle", &entry.name);
    }
    let style = format!(
        "<style>{STYLE}svg{{background:var(--card)}}.faint{{opacity:.3}}.ring{{stroke-width:2.4}}\
         .unseen{{stroke-dasharray:7 4}}</style>\n<"
    );
    svg.finish().replacen("\n<", &format!("\n{style}"), 1)
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
    let axis = |(c, sign): (usize, i8)| json!({"coordinate": c + 1, "sign": sign});
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

/// Spearman's rank correlation; equal values share their mean rank; 0 where one side does not vary.
pub fn spearman(a: &[f64], b: &[f64]) -> f64 {
    let ranks = |values: &[f64]| -> Vec<f64> {
        let below = |v: f64| values.iter().filter(|o| **o < v).count() as f64;
        let same = |v: f64| values.iter().filter(|o| o.total_cmp(&v).is_eq()).count() as f64;
        let middle = (values.len() as f64 - 1.0) / 2.0;
        values
            .iter()
            .map(|&v| below(v) + (same(v) - 1.0) / 2.0 - middle)
            .collect()
    };
    let (a, b) = (ranks(a), ranks(b));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let product = (dot(&a, &a) * dot(&b, &b)).sqrt();
    if product > 0.0 {
        dot(&a, &b) / product
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_correlate_as_by_hand() {
        assert!((spearman(&[1.0, 2.0, 3.0, 4.0], &[10.0, 20.0, 25.0, 90.0]) - 1.0).abs() < 1e-12);
        assert!((spearman(&[1.0, 2.0, 3.0], &[3.0, 2.0, 1.0]) + 1.0).abs() < 1e-12);
        let tied = spearman(&[1.0, 2.0, 2.0, 3.0], &[1.0, 2.0, 3.0, 4.0]);
        assert!((tied - 4.5 / (4.5f64 * 5.0).sqrt()).abs() < 1e-12);
        assert!(spearman(&[1.0, 1.0], &[1.0, 2.0]).abs() < 1e-12);
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
