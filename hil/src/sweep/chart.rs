//! A small chart: a figure over a number, a line per series, with its spread.

use std::fmt::Write;

use palpate_core::statistics::mean;
use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{self, Plot, Svg, dot, line_key};

/// Most lines that can be told apart; the style sheet has as many colours.
pub const LINES: usize = 8;

/// Values at one place of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Where.
    pub x: f64,
    /// The least of the values.
    pub low: f64,
    /// Their mean.
    pub mean: f64,
    /// The most.
    pub high: f64,
}

impl Spot {
    /// Of all values at `x`; none of nothing.
    pub fn of(x: f64, values: &[f64]) -> Option<Self> {
        let (low, high) = ends(values.iter().copied())?;
        let mean = mean(values.iter().copied())?;
        Some(Self { x, low, mean, high })
    }
}

/// The least and the most; none of nothing.
pub fn ends(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |ends, v| {
        let (low, high) = ends.unwrap_or((v, v));
        Some((low.min(v), high.max(v)))
    })
}

fn is_whole(value: f64) -> bool {
    value.fract() == 0.0
}

/// Ends of an axis: one value alone lies in the middle.
fn around(ends: Option<(f64, f64)>) -> (f64, f64) {
    let (low, high) = ends.unwrap_or((0.0, 1.0));
    match low < high {
        true => (low, high),
        false => (low - 0.5, high + 0.5),
    }
}

/// A series by its name, from left to right.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Its name in the legend.
    pub name: String,
    /// Where it goes through.
    pub spots: Vec<Spot>,
}

/// Text with its unit, as beside an axis.
pub fn with_unit(words: &str, unit: &str) -> String {
    match unit {
        "" => words.to_owned(),
        unit => format!("{words} [{unit}]"),
    }
}

/// The lines over x. Where every place has one value there is no spread to show.
pub fn chart(lines: &[Line], x_label: &str, y_label: &str) -> String {
    let spots = || lines.iter().flat_map(|line| &line.spots);
    let x = || spots().map(|s| s.x);
    let y = || spots().flat_map(|s| [s.low, s.high]);
    let counts = [x().all(is_whole), y().all(is_whole)];
    let (x, y) = (around(ends(x())), around(ends(y())));
    let plot = Plot {
        left: 58.0,
        top: 30.0,
        width: 386.0,
        height: 170.0,
        // Room beside the first and the last place.
        x: Scale::exact(x.0 - (x.1 - x.0) * 0.04, x.1 + (x.1 - x.0) * 0.04).of_counts(counts[0]),
        y: Scale::round(y.0, y.1).of_counts(counts[1]),
    };
    let mut svg = Svg::new(460.0, 246.0, &format!("{y_label} against {x_label}"));
    plot.x_axis(&mut svg, x_label);
    plot.y_axis(&mut svg, y_label);
    for (n, line) in lines.iter().enumerate() {
        let (mut mean, mut spread, mut dots) = (String::new(), String::new(), String::new());
        for spot in &line.spots {
            let (px, py) = plot.at((spot.x, spot.mean));
            svg::line(&mut mean, (px, py));
            dot(&mut dots, (px, py));
            if spot.low < spot.high {
                let _ = write!(
                    spread,
                    "M{px:.1} {:.1}V{:.1}",
                    plot.py(spot.low),
                    plot.py(spot.high)
                );
            }
        }
        let colour = n % LINES;
        svg.path(&spread, &format!("spread w{colour}"));
        svg.path(&mean, &format!("series w{colour}"));
        svg.path(&dots, &format!("dots big w{colour}"));
    }
    plot.frame(&mut svg);
    svg.finish()
}

/// The names of lines beside their colours; nothing for one alone without a name.
pub fn legend(lines: &[Line]) -> String {
    if lines.len() == 1 && lines.iter().all(|line| line.name.is_empty()) {
        return String::new();
    }
    let mut keys = String::new();
    for (n, line) in lines.iter().enumerate() {
        line_key(&mut keys, &format!("series w{}", n % LINES), &line.name);
    }
    format!("<div class=\"legend\">{keys}</div>")
}
