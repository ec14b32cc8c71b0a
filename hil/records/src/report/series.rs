//! Figures over frames and time: taxels in contact, time per frame, wire temperatures.

use super::scale::Scale;
use super::svg::{Plot, Svg, dot, envelope};
use crate::measure::{length_us, wire_tallies};
use crate::trace::{Event, Trace};
use std::collections::BTreeSet;

/// Width of a figure that spans the page; every one shares left and right, so that times line up.
pub(super) const WIDTH: f64 = 1120.0;
const LEFT: f64 = 64.0;
const RIGHT: f64 = 96.0;
/// Most wires with a line of their own.
const WIRES: usize = 8;

pub(super) fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

/// A plot across the page.
pub(super) fn panel(top: f64, height: f64, x: Scale, y: Scale) -> Plot {
    Plot {
        left: LEFT,
        top,
        width: WIDTH - LEFT - RIGHT,
        height,
        x,
        y,
    }
}

/// The lowest and the highest of all values.
pub(super) fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    })
}

/// Time per frame, sorted, without what is no number.
pub(super) fn sorted_times(frame_us: &[f32]) -> Vec<f64> {
    let mut times: Vec<f64> = frame_us
        .iter()
        .map(|t| f64::from(*t))
        .filter(|t| t.is_finite() && *t > 0.0)
        .collect();
    times.sort_by(f64::total_cmp);
    times
}

/// The value below which the part `q` of sorted values lies.
pub(super) fn quantile(sorted: &[f64], q: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    sorted.get((last as f64 * q).round() as usize).copied()
}

/// Middle distance of two scans, microseconds.
pub(super) fn scan_us(trace: &Trace) -> Option<f64> {
    let ends: Vec<u64> = trace
        .events
        .iter()
        .filter_map(|e| match e {
            Event::Frame { t_us, .. } => Some(*t_us),
            _ => None,
        })
        .collect();
    let mut gaps: Vec<f64> = ends
        .windows(2)
        .filter_map(|w| match w {
            [a, b] if b > a => Some((b - a) as f64),
            _ => None,
        })
        .collect();
    gaps.sort_by(f64::total_cmp);
    quantile(&gaps, 0.5)
}

/// Taxels in contact and compression time against frames.
pub(super) fn frames(trace: &Trace, frame_us: &[f32]) -> String {
    let mut counts: Vec<(f64, f64)> = Vec::new();
    for event in &trace.events {
        if let Event::Frame {
            frame, in_contact, ..
        } = event
        {
            counts.push((f64::from(*frame), f64::from(*in_contact)));
        }
    }
    let last = counts.last().map_or(10.0, |c| c.0 + 1.0);
    let x = Scale::exact(0.0, last.max(1.0));
    let most = counts.iter().map(|c| c.1).fold(0.0, f64::max);
    let times = sorted_times(frame_us);
    let timed = !times.is_empty();
    let mut svg = Svg::new(
        WIDTH,
        if timed { 420.0 } else { 220.0 },
        "Taxels in contact and time per frame against frames",
    );
    let upper = panel(30.0, 140.0, x, Scale::round(0.0, most.max(4.0)));
    upper.y_axis(&mut svg, "taxels in contact N_C");
    upper.x_axis(&mut svg, if timed { "" } else { "frame" });
    let steps = counts.iter().flat_map(|(f, n)| {
        let y = upper.py(*n);
        [(upper.px(*f), y), (upper.px(f + 1.0), y)]
    });
    svg.path(&envelope(steps), "series");
    upper.frame(&mut svg);
    if timed {
        times_panel(trace, &counts, frame_us, &times, x, &mut svg);
    } else {
        let at = (WIDTH - RIGHT, 20.0);
        svg.text(
            at,
            "note end",
            "time per frame was not measured in this run",
        );
    }
    svg.finish()
}

fn times_panel(
    trace: &Trace,
    counts: &[(f64, f64)],
    frame_us: &[f32],
    times: &[f64],
    x: Scale,
    svg: &mut Svg,
) {
    let scan = scan_us(trace);
    let low = times.first().copied().unwrap_or(1.0);
    let high = times
        .last()
        .copied()
        .unwrap_or(1.0)
        .max(scan.unwrap_or(0.0));
    let lower = panel(222.0, 150.0, x, Scale::decades(low, high));
    lower.y_axis(svg, "time per frame [us]");
    lower.x_axis(svg, "frame");
    lower.frame(svg);
    // Half a pixel is all an eye sees: a long run costs no more than its pixels.
    let mut seen = BTreeSet::new();
    let mut dots = String::new();
    for (index, time) in frame_us.iter().enumerate() {
        let time = f64::from(*time);
        if !(time.is_finite() && time > 0.0) {
            continue;
        }
        let frame = counts.get(index).map_or(index as f64, |c| c.0);
        let at = (lower.px(frame + 0.5), lower.py(time));
        if at.0 <= lower.left + lower.width
            && seen.insert(((at.0 * 2.0) as i64, (at.1 * 2.0) as i64))
        {
            dot(&mut dots, at);
        }
    }
    svg.path(&dots, "dots series-dots");
    let right = lower.left + lower.width;
    if let Some(scan) = scan {
        let y = lower.py(scan);
        svg.line((lower.left, y), (right, y), "bound");
        svg.text(
            (right + 6.0, y + 4.0),
            "tick",
            &format!("scan {:.1} ms", scan / 1000.0),
        );
    }
    if let Some(median) = quantile(times, 0.5) {
        let y = lower.py(median);
        svg.line((lower.left, y), (right, y), "median");
        svg.text(
            (right + 6.0, y + 4.0),
            "tick",
            &format!("median {median:.2} us"),
        );
    }
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
pub(super) fn temperatures(trace: &Trace, wires: &[usize]) -> String {
    let mut lines: Vec<Vec<(f64, f64)>> = vec![Vec::new(); wires.len()];
    for event in &trace.events {
        if let Event::Wire {
            t_us,
            wire,
            milli_c,
        } = event
            && let Some(slot) = wires.iter().position(|w| *w == usize::from(*wire))
            && let Some(line) = lines.get_mut(slot)
        {
            let celsius = f64::from(*milli_c) / 1000.0;
            line.push((seconds(*t_us), celsius));
        }
    }
    let x = Scale::exact(0.0, seconds(length_us(trace)));
    let (low, high) = span(lines.iter().flatten().map(|p| p.1));
    let plot = panel(30.0, 230.0, x, Scale::round(low, high));
    let mut svg = Svg::new(WIDTH, 306.0, "Wire temperatures against time");
    plot.y_axis(&mut svg, "temperature [\u{b0}C]");
    plot.x_axis(&mut svg, "time [s]");
    for (slot, line) in lines.iter().enumerate() {
        let points = line.iter().map(|p| plot.at(*p));
        svg.path(&envelope(points), &format!("series w{slot}"));
    }
    plot.frame(&mut svg);
    svg.finish()
}
