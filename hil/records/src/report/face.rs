//! A Peltier module over time: what its face was to be and was, its sink and its current.

use super::scale::Scale;
use super::series::span;
use super::timeplot::TimePlot;
use crate::margin::{Limited, Margin};
use crate::measure::length_us;
use crate::trace::{Trace, event};
use std::fmt::Write;

fn milli(value: i32) -> f64 {
    f64::from(value) / 1e3
}

/// Writes the section; nothing where there is no module.
pub(super) fn section(page: &mut String, trace: &Trace) {
    let samples: Vec<&event::Face> = trace.each().collect();
    if samples.len() < 2 {
        return;
    }
    let whole = (0, length_us(trace));
    let temperatures = samples
        .iter()
        .flat_map(|s| [s.face_mc, s.sink_mc].map(milli));
    let limit = trace.ledger.margin(Limited::FaceWarm).map(Margin::limit);
    let (low, high) = span(temperatures.chain(limit));
    let label = "Temperatures of the Peltier module against time";
    let mut upper = TimePlot::new(
        label,
        "\u{b0}C",
        230.0,
        whole,
        Scale::round(low, high + 0.5),
    );
    upper.y_axis("Peltier module [\u{b0}C]");
    limit
        .into_iter()
        .for_each(|c| upper.bound(c, "bound", "face"));
    type Of = fn(&event::Face) -> f64;
    let lines: [(Of, &str, &str); 3] = [
        (
            |s| s.aim_mc.map_or(f64::NAN, milli),
            "series w1",
            "aimed at",
        ),
        (|s| milli(s.face_mc), "series w0", "face on the skin"),
        (|s| milli(s.sink_mc), "series w2", "sink"),
    ];
    for (of, class, name) in lines {
        upper.line(name, class, samples.iter().map(|s| (s.t_us, of(s))));
    }
    let legend = upper.legend.clone();
    let (low, high) = span(
        samples
            .iter()
            .map(|s| milli(s.milliamps))
            .chain([-0.1, 0.1]),
    );
    let label = "Current of the Peltier module against time";
    let mut lower = TimePlot::new(label, "A", 110.0, whole, Scale::round(low, high));
    lower.y_axis("current [A], positive cools");
    let points = samples.iter().map(|s| (s.t_us, milli(s.milliamps)));
    lower.line("current", "series w0", points);
    let _ = writeln!(
        page,
        "<section><h2>Warmth: the face of the Peltier module</h2><p class=\"sub\">What is touched is warm or cold to \
         the finger by its material. A touch with nothing said of it is at skin temperature.</p>\n{}{}\
         <div class=\"legend\">{legend}</div></section>",
        upper.finish(2, ""),
        lower.named().finish(3, "")
    );
}
