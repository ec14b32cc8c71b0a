//! Figures 3.4 and 3.6: ratings of every texture as boxes, with the bare finger and on the display side by side.

use palpate_emulators::person::panel::Dimension;
use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{Plot, Svg};

use super::statistics::Box5;
use super::{ON_DISPLAY, Rated, Study};

/// Probability below which a difference counts, as in the thesis.
pub const SIGNIFICANT: f64 = 0.05;

/// Least width, and the width for each texture: a name and two boxes.
const WIDTH: f64 = 960.0;
const EACH: f64 = 92.0;
/// Width beside the boxes, pixels.
const MARGINS: f64 = 84.0;
const HEIGHT: f64 = 190.0;
const TOP: f64 = 96.0;
const GAP: f64 = 74.0;

/// Draws one box around `x`, pixels.
fn draw_box(svg: &mut Svg, plot: &Plot, x: f64, ratings: &[u8], class: &str) {
    let Some(found) = Box5::new(ratings) else {
        return;
    };
    let half = 9.0;
    let y = |value: f64| plot.py(value);
    for (from, to) in [(found.low, found.q1), (found.q3, found.high)] {
        svg.line((x, y(from)), (x, y(to)), &format!("series {class}"));
        let end = if from < found.q1 { from } else { to };
        let cap = ((x - half / 2.0, y(end)), (x + half / 2.0, y(end)));
        svg.line(cap.0, cap.1, &format!("series {class}"));
    }
    let size = (2.0 * half, y(found.q1) - y(found.q3));
    svg.rect(
        (x - half, y(found.q3)),
        size,
        &format!("series box {class}"),
    );
    let middle = y(found.median);
    svg.line(
        (x - half, middle),
        (x + half, middle),
        &format!("bold {class}"),
    );
    for outlier in found.outliers {
        svg.circle((x, y(f64::from(outlier))), 3.0, &format!("series {class}"));
    }
}

/// The ratings of one dimension: bare finger, display.
fn ratings(rated: &Rated, dimension: Dimension) -> (Option<&[u8]>, Option<&[u8]>) {
    let place = Dimension::ALL.iter().position(|d| *d == dimension);
    let bare = place.and_then(|d| Some(rated.bare.as_ref()?[d].as_slice()));
    let shown = ON_DISPLAY.iter().position(|d| *d == dimension);
    let shown = shown.map(|d| rated.display[d].as_slice());
    (bare, shown.filter(|ratings| !ratings.is_empty()))
}

/// Rules of [`drawing`], beside the style sheet of reports.
pub const RULES: &str =
    ".box{fill-opacity:.15}.box.w0{fill:var(--w0)}.box.w1{fill:var(--w1)}.bold{stroke-width:3.2}";

/// Draws a study: SVG as a file of its own.
pub fn draw(study: &Study, title: &str) -> String {
    let touched = study.textures.iter().any(|t| t.bare.is_some());
    let dimensions: Vec<Dimension> = Dimension::ALL
        .into_iter()
        .filter(|d| touched || ON_DISPLAY.contains(d))
        .collect();
    drawing(study, &dimensions, title).standalone(RULES)
}

/// The drawing of some dimensions of a study.
pub fn drawing(study: &Study, dimensions: &[Dimension], title: &str) -> Svg {
    let touched = study.textures.iter().any(|t| t.bare.is_some());
    let shown = study.textures.iter().any(|t| !t.shown.is_empty());
    let height = TOP + dimensions.len() as f64 * (HEIGHT + GAP);
    let width = WIDTH.max(MARGINS + EACH * study.textures.len() as f64);
    let mut svg = Svg::new(width, height, title);
    svg.text((20.0, 26.0), "label", title);
    let words = "SIMULATED panel: no person has rated anything. Box: quartiles, bold: median, circles: outliers.";
    svg.text((20.0, 46.0), "note", words);
    let mut key = |x: f64, class: &str, name: &str| {
        svg.rect((x, 58.0), (14.0, 12.0), &format!("series box {class}"));
        svg.text((x + 20.0, 69.0), "note", name);
    };
    if touched {
        key(20.0, "w0", "bare finger");
    }
    if touched && shown {
        key(130.0, "w1", "display");
        let star = format!("* differ: Mann-Whitney U, p < {SIGNIFICANT}");
        svg.text((220.0, 69.0), "note", &star);
    } else if shown {
        key(20.0, "w1", "display");
    }
    for (row, dimension) in dimensions.iter().copied().enumerate() {
        let plot = Plot {
            left: 64.0,
            top: TOP + 10.0 + row as f64 * (HEIGHT + GAP),
            width: width - MARGINS,
            height: HEIGHT,
            x: Scale::exact(0.0, study.textures.len() as f64),
            y: Scale::exact(0.7, 6.6),
        };
        plot.y_axis(&mut svg, &format!("{} rated, 1 to 6", dimension.name()));
        for (n, rated) in study.textures.iter().enumerate() {
            let x = plot.px(n as f64 + 0.5);
            let (bare, shown) = ratings(rated, dimension);
            let apart = if bare.is_some() && shown.is_some() {
                15.0
            } else {
                0.0
            };
            if let Some(bare) = bare {
                draw_box(&mut svg, &plot, x - apart, bare, "w0");
            }
            if let Some(shown) = shown {
                draw_box(&mut svg, &plot, x + apart, shown, "w1");
            }
            let mut tests = rated.against_bare().into_iter();
            if tests.any(|t| t.dimension == dimension.name() && t.p < SIGNIFICANT) {
                svg.text((x, plot.top + 14.0), "label middle", "*");
            }
            let bottom = plot.top + plot.height + 17.0;
            svg.text((x, bottom), "tick middle", &rated.name);
        }
        plot.frame(&mut svg);
    }
    svg
}
