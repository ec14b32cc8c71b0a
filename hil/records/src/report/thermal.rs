//! Temperatures of an emulated finger over time, against the limits of its skin.

use super::scale::Scale;
use super::series::span;
use super::svg::line_key;
use super::timeplot::TimePlot;
use crate::margin::{Limited, Margin};
use crate::model::{TISSUE_C, WIRE_C, known as within};
use crate::trace::{Ledger, Trace};
use std::fmt::Write;

/// The finger at one instant; each temperature is the highest since the instant before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warmth {
    /// Time, s.
    pub t_s: f64,
    /// Hottest wire, degrees C.
    pub wire_c: f64,
    /// Hottest skin at 0.1 mm, degrees C.
    pub shallow_c: f64,
    /// Hottest skin at 0.4 mm, degrees C.
    pub deep_c: f64,
    /// Mean of the skin at 0.1 mm over ten seconds, degrees C.
    pub mean_c: f64,
}

/// Writes the section: temperatures against their limits; nothing where they were not measured.
pub(super) fn section(page: &mut String, trace: &Trace, samples: &[Warmth]) {
    if samples.len() < 2 {
        return;
    }
    let (skin, wire) = (skin(&trace.ledger, samples), wire(samples));
    let (mut legend, hottest) = (skin.legend.clone(), wire.legend.clone());
    let is_whole = samples
        .iter()
        .all(|s| within(s.wire_c, WIRE_C).is_some() && within(s.shallow_c, TISSUE_C).is_some());
    let ends = match is_whole {
        true => String::new(),
        false => format!(
            " Lines end where the model does, skin at {TISSUE_C:.0} \u{b0}C and wire at {WIRE_C:.0} \u{b0}C."
        ),
    };
    line_key(&mut legend, "bound", "limit");
    let _ = writeln!(
        page,
        "<section><h2>Temperatures against their limits</h2><p class=\"sub\">Each point is the highest since the \
         one before, of all wires; the mean is over ten seconds. A wire has no limit of its own.{ends}</p>\n\
         {}{}<div class=\"legend\">{legend}{hottest}</div></section>",
        skin.finish(2, ""),
        wire.named().finish(2, "")
    );
}

/// A plot that shows at least 33 to 34 degrees C.
fn plot(
    (label, title): (&str, &str),
    height: f64,
    samples: &[Warmth],
    values: impl Iterator<Item = f64>,
    above: f64,
) -> TimePlot {
    let last = samples.last().map_or(1.0, |s| s.t_s);
    let (low, high) = span([33.0, 34.0].into_iter().chain(values));
    let y = Scale::round(low, high + above);
    let mut plot = TimePlot::new(label, "\u{b0}C", height, (0, micros(last)), y);
    plot.y_axis(title);
    plot
}

fn micros(t_s: f64) -> u64 {
    (t_s * 1e6).round() as u64
}

fn skin(ledger: &Ledger, samples: &[Warmth]) -> TimePlot {
    type Of = fn(&Warmth) -> f64;
    let lines: [(Of, &str, &str); 3] = [
        (|s| s.shallow_c, "w1", "skin at 0.1 mm"),
        (|s| s.mean_c, "w4", "its mean over 10 s"),
        (|s| s.deep_c, "w2", "skin at 0.4 mm"),
    ];
    let bounds = [
        (Limited::SkinPeak, "0.1 mm"),
        (Limited::SkinMean, "mean"),
        (Limited::SkinDeep, "0.4 mm"),
    ];
    let bounds = bounds.map(|(of, what)| (ledger.margin(of).map(Margin::limit), what));
    let limits = bounds.iter().filter_map(|b| b.0);
    let all = samples.iter().flat_map(|s| lines.map(|(of, ..)| of(s)));
    let all = all.filter_map(|c| within(c, TISSUE_C));
    let label = "Skin temperatures and their limits against time";
    let values = all.chain(limits);
    let mut plot = plot((label, "skin [\u{b0}C]"), 230.0, samples, values, 0.5);
    let mut bound = |celsius: f64, what: &str| plot.bound(celsius, "bound", what);
    match bounds {
        // Two words in one place would cover each other.
        [peak, (Some(mean), _), (Some(deep), _)] if (mean - deep).abs() < 0.05 => {
            if let (Some(celsius), what) = peak {
                bound(celsius, what);
            }
            bound(mean, "mean, 0.4 mm");
        }
        all => {
            for (celsius, what) in all {
                celsius.into_iter().for_each(|c| bound(c, what));
            }
        }
    }
    for (of, class, name) in lines {
        let points = samples
            .iter()
            .filter_map(|s| Some((micros(s.t_s), within(of(s), TISSUE_C)?)));
        plot.line(name, &format!("series {class}"), points);
    }
    plot
}

fn wire(samples: &[Warmth]) -> TimePlot {
    let values = samples.iter().filter_map(|s| within(s.wire_c, WIRE_C));
    let named = ("Hottest wire against time", "hottest wire [\u{b0}C]");
    let mut plot = plot(named, 130.0, samples, values, 0.0);
    let points = samples
        .iter()
        .filter_map(|s| Some((micros(s.t_s), within(s.wire_c, WIRE_C)?)));
    plot.line("hottest wire", "series w0", points);
    plot
}

#[cfg(test)]
#[path = "thermal_tests.rs"]
mod tests;
