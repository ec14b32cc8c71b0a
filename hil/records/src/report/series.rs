//! Figures over time: taxels in contact, time per frame, wire temperatures.

use super::scale::Scale;
use super::timeplot::{Pen, TimePlot};
use crate::frame_time::FrameTime;
use crate::measure::{length_us, wire_tallies};
use crate::model;
use crate::trace::{Event, Trace, event};
use palpate_core::statistics::quantile;
use std::collections::BTreeSet;

/// Most wires with a line of their own.
const WIRES: usize = 8;
/// Most dots of a plot.
const DOTS: usize = 12_000;

/// The lowest and the highest of all values.
pub(super) fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    })
}

/// Times per frame that can be drawn.
pub(super) fn times(frame_us: &[f32]) -> impl Iterator<Item = f64> {
    let all = frame_us.iter().map(|t| f64::from(*t));
    all.filter(|t| t.is_finite() && *t > 0.0)
}

/// Middle distance of two scans, microseconds.
pub(super) fn scan_us(trace: &Trace) -> Option<f64> {
    let ends: Vec<u64> = trace
        .each()
        .map(|frame: &event::Frame| frame.t_us)
        .collect();
    let mut gaps: Vec<f64> = ends
        .windows(2)
        .filter_map(|w| match w {
            [a, b] if b > a => Some((b - a) as f64),
            _ => None,
        })
        .collect();
    gaps.sort_unstable_by(f64::total_cmp);
    quantile(&gaps, 0.5).map(|middle| middle.above)
}

/// Taxels in contact and compression time, frame by frame.
pub(super) fn frames(trace: &Trace, frame_us: &[f32]) -> String {
    let count = |frame: &event::Frame| (frame.t_us, f64::from(frame.in_contact));
    let counts: Vec<_> = trace.each().map(count).collect();
    let most = counts.iter().map(|c| c.1).fold(0.0, f64::max);
    let whole = (0, length_us(trace));
    let y = Scale::round(0.0, most.max(4.0));
    let mut upper = TimePlot::new("Taxels in contact against time", "", 140.0, whole, y);
    upper.y_axis("taxels in contact N_C");
    // A count holds until the next frame.
    let held = counts
        .iter()
        .zip(counts.iter().skip(1).chain(counts.last()));
    let steps = held.flat_map(|((t, n), (next, _))| [(*t, *n), (*next, *n)]);
    upper.line("taxels in contact", "series", steps);
    let (low, high) = span(times(frame_us));
    if low > high {
        return upper.named().finish(0, "");
    }
    upper.finish(0, "") + &times_panel(trace, &counts, frame_us, (low, high))
}

fn times_panel(
    trace: &Trace,
    counts: &[(u64, f64)],
    frame_us: &[f32],
    (low, high): (f64, f64),
) -> String {
    let scan = scan_us(trace);
    let y = Scale::decades(low, high.max(scan.unwrap_or(0.0)));
    let whole = (0, length_us(trace));
    let mut plot = TimePlot::new("Time per frame against time", "us", 150.0, whole, y);
    plot.y_axis("time per frame [us]");
    let times = frame_us.iter().map(|t| f64::from(*t)).zip(counts);
    let times = times.filter(|(us, _)| *us > 0.0);
    let dots = dots(&plot, times.map(|(us, (t_us, _))| (*t_us, us)));
    plot.path("dots", "time per frame", "dots series-dots", &dots);
    if let Some(scan) = scan {
        plot.bound(scan, "bound", &format!("scan {:.1} ms", scan / 1000.0));
    }
    let time = FrameTime::summarise(frame_us.iter().copied());
    if let Some(median) = time.map(|t| t.median).filter(|us| *us > 0.0) {
        plot.bound(median, "median", &format!("median {median:.2} us"));
    }
    plot.named().finish(2, "")
}

/// A dot per value against microseconds. What an eye cannot tell apart is drawn once: a long run costs no more than its
/// columns.
pub(super) fn dots(plot: &TimePlot, values: impl Iterator<Item = (u64, f64)>) -> String {
    let (column, row) = (plot.column(), 150);
    let mut seen = BTreeSet::new();
    let mut pen = Pen::default();
    for at in values.filter_map(|(t_us, value)| plot.at(t_us, value)) {
        if seen.insert((at.0 / column, at.1 / row)) && seen.len() <= DOTS {
            pen.dot(at);
        }
    }
    pen.finish()
}

/// The wires with a line: all of a small display, of a larger one the hottest.
pub(super) fn warm_wires(trace: &Trace) -> Vec<usize> {
    let mut wires: Vec<(Option<i32>, usize)> = wire_tallies(trace)
        .iter()
        .enumerate()
        .map(|(i, t)| (t.hottest_milli_c, i))
        .filter(|(c, _)| c.is_some())
        .collect();
    wires.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    wires.truncate(WIRES);
    let mut chosen: Vec<usize> = wires.into_iter().map(|w| w.1).collect();
    chosen.sort_unstable();
    chosen
}

/// Wire temperatures against time.
pub(super) fn temperatures(trace: &Trace, wires: &[usize]) -> TimePlot {
    let mut lines: Vec<Vec<(u64, f64)>> = vec![Vec::new(); wires.len()];
    for event in &trace.events {
        if let Event::Wire(now) = event
            && let Some(slot) = wires.iter().position(|w| *w == usize::from(now.wire))
            && let Some(line) = lines.get_mut(slot)
        {
            // Beyond the model there is nothing to draw.
            let celsius = model::known(f64::from(now.milli_c) / 1000.0, model::WIRE_C);
            line.extend(celsius.map(|celsius| (now.t_us, celsius)));
        }
    }
    let (low, high) = span(lines.iter().flatten().map(|p| p.1));
    let whole = (0, length_us(trace));
    let y = Scale::round(low, high);
    let label = "Wire temperatures against time";
    let mut plot = TimePlot::new(label, "\u{b0}C", 230.0, whole, y);
    plot.y_axis("temperature [\u{b0}C]");
    for (slot, (line, wire)) in lines.into_iter().zip(wires).enumerate() {
        let class = format!("series w{slot}");
        plot.line(&format!("wire {wire}"), &class, line.into_iter());
    }
    plot.named()
}
