//! The texture of a run: its path through the latent space, and how rough that is.

use super::scale::Scale;
use super::series::span;
use super::timeplot::TimePlot;
use crate::measure::length_us;
use crate::trace::{Trace, event};
use std::fmt::Write;

/// Most latent coordinates with a line.
const LINES: usize = 8;
/// Windows further apart are of different touches: no line joins them, microseconds.
const APART_US: u64 = 500_000;

/// One window: its end, its latent vector and its roughness.
type Window<'a> = (u64, &'a [i32], u16);

fn windows(trace: &Trace) -> Vec<Window<'_>> {
    let windows = trace.each::<event::Latent>();
    windows
        .map(|w| (w.t_us, w.z_milli.as_slice(), w.rough_permille))
        .collect()
}

/// Draws one value of every window against time, a line for each touch.
fn draw(plot: &mut TimePlot, points: &[(u64, f64)], name: &str, class: &str) {
    let mut before = None;
    let mut drawn = Vec::with_capacity(points.len());
    for (t, v) in points {
        if before.is_some_and(|b| t.saturating_sub(b) >= APART_US) {
            drawn.push((*t, f64::NAN));
        }
        before = Some(*t);
        drawn.push((*t, *v));
    }
    plot.line(name, class, drawn.into_iter());
}

/// Writes latent path and roughness; nothing where no texture was felt.
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
    let whole = (0, length_us(trace));
    let y = Scale::round(low, high);
    let label = "Latent coordinates against time";
    let mut upper = TimePlot::new(label, "", 150.0, whole, y);
    upper.y_axis("latent coordinate");
    for (i, points) in lines.iter().enumerate() {
        let (class, name) = (format!("series w{i}"), format!("z{}", i + 1));
        draw(&mut upper, points, &name, &class);
    }
    let legend = upper.legend.clone();
    let y = Scale::exact(0.0, 1.0);
    let mut lower = TimePlot::new("Roughness against time", "", 80.0, whole, y);
    lower.y_axis("roughness, 0 to 1");
    let rough: Vec<_> = windows
        .iter()
        .map(|w| (w.0, f64::from(w.2) / 1e3))
        .collect();
    draw(&mut lower, &rough, "roughness", "series");
    let _ = writeln!(
        page,
        "<section><h2>Texture: latent path</h2><p class=\"sub\">{} windows of a second each, one an onset, \
         every sample of them touched. Roughness is the driving coordinate in its range, clamped; its \
         pulses are in the schedule below.</p>\n{}{}\
         <div class=\"legend\">{legend}</div></section>",
        windows.len(),
        upper.finish(3, ""),
        lower.named().finish(3, "")
    );
}
