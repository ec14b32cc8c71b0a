//! A small chart: a figure over a number, a line per series, with its spread.

use std::fmt::Write;

use palpate_core::statistics::mean;
use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{self, Plot, Svg, dot, escape, line_key};
use palpate_records::runs::short;

/// Most lines that can be told apart; the style sheet has as many colours.
pub const LINES: usize = 8;

/// Most values that a chart has for the pointer: of more the drawing is enough.
const TOLD: usize = 4_000;

/// Words and their unit.
type Named<'a> = (&'a str, &'a str);

/// Values at one place of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Place along the axis.
    pub x: f64,
    /// The least of the values.
    pub low: f64,
    /// Their mean.
    pub mean: f64,
    /// The most.
    pub high: f64,
}

impl Spot {
    /// Spot of all values at `x`; `None` without a value.
    pub fn around(x: f64, values: &[f64]) -> Option<Self> {
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
    /// Name in the legend.
    pub name: String,
    /// Spots that the line goes through.
    pub spots: Vec<Spot>,
}

/// Text with its unit, as beside an axis.
pub fn with_unit(words: &str, unit: &str) -> String {
    match unit {
        "" => words.to_owned(),
        unit => format!("{words} [{unit}]"),
    }
}

/// Ends of an axis of figures in a unit. It spans a tenth of the largest at least, and what can be told of such a figure:
/// closer up, noise would look like an effect. What is never negative has no axis that is.
fn wide_enough(ends: Option<(f64, f64)>, unit: &str) -> (f64, f64) {
    let (low, high) = ends.unwrap_or((0.0, 1.0));
    let told: f64 = match unit {
        "dB" | "\u{b0}C" => 1.0,
        "mm" => 0.1,
        "%" => 5.0,
        _ => 0.0,
    };
    let least = told.max(0.1 * low.abs().max(high.abs()));
    let lacks = (least - (high - low)).max(0.0) / 2.0;
    let (down, up) = (low - lacks, high + lacks);
    match low >= 0.0 && down < 0.0 {
        true => (0.0, up - down),
        false => (down, up),
    }
}

/// Values of lines by place, for the script of the page (`values.js`): the pixel, the place, and colour and words of each
/// line.
fn values(lines: &[Line], plot: &Plot, (x, x_unit): Named<'_>, y_unit: &str) -> String {
    let spots = || lines.iter().flat_map(|line| &line.spots);
    if spots().count() > TOLD {
        return String::new();
    }
    let mut places: Vec<f64> = spots().map(|spot| spot.x).collect();
    places.sort_unstable_by(f64::total_cmp);
    places.dedup();
    let with = |value: f64, unit: &str| format!("{} {unit}", short(value)).trim_end().to_owned();
    let told = |x: f64| {
        let here = lines.iter().enumerate().filter_map(|(n, line)| {
            let spot = line
                .spots
                .iter()
                .find(|spot| spot.x.total_cmp(&x).is_eq())?;
            let mut words = with(spot.mean, y_unit);
            if spot.low < spot.high {
                let _ = write!(words, " ({} to {})", short(spot.low), short(spot.high));
            }
            if !line.name.is_empty() {
                words = format!("{}: {words}", line.name);
            }
            Some((n % LINES, words))
        });
        here.collect::<Vec<_>>()
    };
    let all = places.iter().map(|at| {
        let place = format!("{x} {}", with(*at, x_unit));
        (plot.px(*at).round(), place, told(*at))
    });
    let all: Vec<_> = all.collect();
    let text = serde_json::to_string(&all).unwrap_or_default();
    format!(" data-v=\"{}\" tabindex=\"0\"", escape(&text))
}

/// The lines over x. Where every place has one value there is no spread to show.
pub fn chart(lines: &[Line], x_named: Named<'_>, y_named: Named<'_>) -> String {
    let spots = || lines.iter().flat_map(|line| &line.spots);
    let x = || spots().map(|s| s.x);
    let y = || spots().flat_map(|s| [s.low, s.high]);
    let counts = [x().all(is_whole), y().all(is_whole)];
    let (x, y) = (around(ends(x())), wide_enough(ends(y()), y_named.1));
    let plot = Plot {
        left: 58.0,
        top: 30.0,
        width: 386.0,
        height: 170.0,
        // Room beside the first and the last place.
        x: Scale::exact(x.0 - (x.1 - x.0) * 0.04, x.1 + (x.1 - x.0) * 0.04).of_counts(counts[0]),
        y: Scale::round(y.0, y.1).of_counts(counts[1]),
    };
    let (x_label, y_label) = (
        with_unit(x_named.0, x_named.1),
        with_unit(y_named.0, y_named.1),
    );
    let mut svg = Svg::new(460.0, 246.0, &format!("{y_label} against {x_label}"));
    plot.x_axis(&mut svg, &x_label);
    plot.y_axis(&mut svg, &y_label);
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
    let values = values(lines, &plot, x_named, y_named.1);
    format!(
        "<figure class=\"chart\"{values}>{}</figure>\n",
        svg.finish()
    )
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

#[cfg(test)]
#[path = "chart_tests.rs"]
mod tests;
