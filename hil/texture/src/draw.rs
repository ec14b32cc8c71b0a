//! The latent map as a drawing: points, an ellipse for each texture, the names beside them.

use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{self, Plot, Svg, dot};

use crate::map::{Placed, View};

/// Share of the points at each end of an axis that may lie outside the drawing.
const OUTERMOST: f64 = 0.01;
/// Width and height of a drawing, pixels.
const SIZE: (f64, f64) = (900.0, 560.0);
/// Width of the names at the right, pixels.
const NAMES: f64 = 160.0;

/// Rules of [`drawing`], beside the style sheet of reports.
pub const RULES: &str = ".faint{opacity:.35}.ring{stroke-width:2.2}.middle-mark{stroke-width:8}.unseen{stroke-dasharray:7 4}";

/// Draws a map: SVG as a file of its own.
pub fn draw(placed: &[Placed<'_>], view: View, title: &str) -> String {
    drawing(placed, view, title).standalone(RULES)
}

/// The drawing of a map. Trained textures have whole ellipses, unseen ones dashed. Ellipses are in
/// view as a whole; of the points, the outermost hundredth at each end is not.
pub fn drawing(placed: &[Placed<'_>], view: View, title: &str) -> Svg {
    let range = |of: fn(&(f64, f64)) -> f64| {
        let points: Vec<f64> = placed.iter().flat_map(|p| &p.points).map(of).collect();
        let outline = placed.iter().flat_map(|p| p.spot.outline());
        inner(points, outline.map(|p| of(&p)))
    };
    let mut svg = Svg::new(SIZE.0, SIZE.1, title);
    let plot = Plot {
        left: 64.0,
        top: 34.0,
        width: SIZE.0 - 64.0 - NAMES,
        height: SIZE.1 - 90.0,
        x: range(|p| p.0),
        y: range(|p| p.1),
    };
    plot.x_axis(&mut svg, &view.x.label());
    plot.y_axis(&mut svg, &view.y.label());
    plot.frame(&mut svg);
    let inside = |p: &&(f64, f64)| [plot.x.at(p.0), plot.y.at(p.1)].iter().all(within);
    for (i, texture) in placed.iter().enumerate() {
        let mut dots = String::new();
        let shown = texture.points.iter().filter(inside);
        shown.for_each(|p| dot(&mut dots, plot.at(*p)));
        svg.path(&dots, &format!("dots faint w{}", i % 8));
    }
    for (i, texture) in placed.iter().enumerate() {
        let mut line = String::new();
        let outline = texture.spot.outline().into_iter();
        outline.for_each(|p| svg::line(&mut line, plot.at(p)));
        svg.path(&line, &ring(texture, i));
        let mut middle = String::new();
        dot(&mut middle, plot.at(texture.spot.mean));
        svg.path(&middle, &format!("dots middle-mark w{}", i % 8));
    }
    names(&mut svg, &plot, placed);
    svg
}

fn within(share: &f64) -> bool {
    (0.0..=1.0).contains(share)
}

/// The class of a texture's ellipse.
fn ring(texture: &Placed<'_>, i: usize) -> String {
    let dashed = if texture.is_trained { "" } else { " unseen" };
    format!("series ring{dashed} w{}", i % 8)
}

/// A scale that shows an outline as a whole, and all but the outermost points.
fn inner(mut points: Vec<f64>, outline: impl Iterator<Item = f64>) -> Scale {
    points.sort_unstable_by(f64::total_cmp);
    let out = (points.len() as f64 * OUTERMOST) as usize;
    let some = points.get(out..points.len() - out).unwrap_or_default();
    let ends = some.first().into_iter().chain(some.last()).copied();
    let (low, high) = ends
        .chain(outline)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
    Scale::round(low, high)
}

/// The names, at the right of the plot, each with its line: those that were trained on, then the others.
fn names(svg: &mut Svg, plot: &Plot, placed: &[Placed<'_>]) {
    let left = plot.left + plot.width + 18.0;
    let mut y = plot.top + 4.0;
    for (trained, heading) in [(true, "trained on"), (false, "never seen")] {
        let some = placed.iter().enumerate();
        let mut some = some
            .filter(|(_, texture)| texture.is_trained == trained)
            .peekable();
        if some.peek().is_none() {
            continue;
        }
        svg.text((left, y + 4.0), "tick", heading);
        for (i, texture) in some {
            y += 22.0;
            let line = format!("M{left:.1} {y:.1}h30");
            svg.path(&line, &ring(texture, i));
            svg.text((left + 38.0, y + 4.5), "label", &texture.entry.name);
        }
        y += 34.0;
    }
}

#[cfg(test)]
#[path = "draw_tests.rs"]
mod tests;
