//! The texture of a run: its path through the latent space, and how rough that is.

use super::scale::Scale;
use super::series::{WIDTH, panel, seconds, span};
use super::svg::{Plot, Svg, envelope};
use crate::measure::length_us;
use crate::trace::{Event, Trace};
use std::fmt::Write;

/// Most latent coordinates with a line.
const LINES: usize = 8;
/// Windows further apart are of different touches: no line joins them, microseconds.
const APART_US: u64 = 500_000;

/// One window: its end, its latent vector and how rough that is.
type Window<'a> = (u64, &'a [i32], u16);

fn windows(trace: &Trace) -> Vec<Window<'_>> {
    let events = trace.events.iter();
    events
        .filter_map(|event| match event {
            Event::Latent {
                t_us,
                z_milli,
                rough_permille,
                ..
            } => Some((*t_us, z_milli.as_slice(), *rough_permille)),
            _ => None,
        })
        .collect()
}

/// One value of every window against time, a line for each touch.
fn draw(svg: &mut Svg, plot: &Plot, points: &[(u64, f64)], class: &str) {
    for touch in points.chunk_by(|a, b| b.0.saturating_sub(a.0) < APART_US) {
        let places = touch.iter().map(|(t, v)| plot.at((seconds(*t), *v)));
        svg.path(&envelope(places), class);
    }
}

/// Latent path and roughness; nothing where no texture was felt.
pub(super) fn section(page: &mut String, trace: &Trace) {
    let windows = windows(trace);
    if windows.is_empty() {
        return;
    }
    let count = windows
        .iter()
        .map(|w| w.1.len())
        .max()
        .unwrap_or(0)
        .min(LINES);
    let line = |i: usize| -> Vec<(u64, f64)> {
        let value = |w: &Window<'_>| Some((w.0, f64::from(*w.1.get(i)?) / 1e3));
        windows.iter().filter_map(value).collect()
    };
    let lines: Vec<_> = (0..count).map(line).collect();
    let (low, high) = span(lines.iter().flatten().map(|p| p.1));
    let x = Scale::exact(0.0, seconds(length_us(trace)));
    let mut svg = Svg::new(
        WIDTH,
        364.0,
        "Latent coordinates and roughness against time",
    );
    let upper = panel(30.0, 150.0, x, Scale::round(low, high));
    upper.y_axis(&mut svg, "latent coordinate");
    upper.x_axis(&mut svg, "");
    let mut legend = String::new();
    for (i, points) in lines.iter().enumerate() {
        let class = format!("series w{i}");
        draw(&mut svg, &upper, points, &class);
        super::figures::line_key(&mut legend, &class, &format!("z{}", i + 1));
    }
    upper.frame(&mut svg);
    let lower = panel(236.0, 80.0, x, Scale::exact(0.0, 1.0));
    lower.y_axis(&mut svg, "roughness, 0 to 1");
    lower.x_axis(&mut svg, "time [s]");
    let rough: Vec<_> = windows
        .iter()
        .map(|w| (w.0, f64::from(w.2) / 1e3))
        .collect();
    draw(&mut svg, &lower, &rough, "series");
    lower.frame(&mut svg);
    let _ = writeln!(
        page,
        "<section><h2>Texture: latent path</h2><p class=\"sub\">{} windows of a second each, one an onset, \
         every sample of them touched. Roughness is the driving coordinate in its range, clamped; its \
         pulses are in the schedule below.</p>\n<div class=\"wide\">{}</div>\
         <div class=\"legend\">{legend}</div></section>",
        windows.len(),
        svg.finish()
    );
}
