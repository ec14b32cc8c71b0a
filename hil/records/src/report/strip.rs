//! The schedule as a strip chart: a row a wire, a bar a burst, its height the width of the pulses.

use super::scale::Scale;
use super::series::{WIDTH, panel, seconds};
use super::svg::{Plot, Svg};
use crate::bursts::{Burst, shown_wires};
use crate::measure::length_us;
use crate::trace::{Event, Trace};
use palpate_core::units::Ticks;
use std::fmt::Write;

const ROW: f64 = 30.0;
const BAR: f64 = 22.0;
/// Most wires with a row.
const ROWS: usize = 32;

fn duty(width: u16) -> f64 {
    f64::from(width) / f64::from(Ticks::PER_PERIOD) * 100.0
}

fn bar(out: &mut String, x0: f64, x1: f64, base: f64, height: f64) {
    let w = (x1 - x0).max(0.6);
    let _ = write!(out, "M{x0:.1} {base:.1}v{:.1}h{w:.1}v{height:.1}z", -height);
}

/// Chart of the time from `from_us` to `to_us`.
pub(super) fn schedule(trace: &Trace, all: &[Burst], from_us: u64, to_us: u64) -> String {
    let wires = shown_wires(trace, all, ROWS);
    let rows = wires.len() as f64 + 2.0;
    let mut svg = Svg::new(WIDTH, rows * ROW + 62.0, "Schedule, one row a wire");
    let x = Scale::exact(seconds(from_us), seconds(to_us));
    let plot = panel(22.0, rows * ROW, x, Scale::exact(0.0, 1.0));
    plot.x_axis(&mut svg, "time [s]");
    let base = |row: f64| plot.top + row * ROW + 26.0;
    let clip = |us: u64| plot.px(seconds(us.clamp(from_us, to_us)));
    let inside = |from: u64, to: u64| from <= to_us && to >= from_us;
    rulings(trace, &plot, &mut svg, &wires, &base);
    let widest = all
        .iter()
        .map(|b| b.width.max(b.requested))
        .max()
        .unwrap_or(0)
        .max(1);
    for (row, wire) in wires.iter().enumerate() {
        let (mut whole, mut cut, mut asked) = (String::new(), String::new(), String::new());
        let y = base(row as f64 + 2.0);
        let mut peak = 0;
        for b in all.iter().filter(|b| b.wire() == Some(*wire)) {
            if !inside(b.from_us, b.to_us) {
                continue;
            }
            peak = peak.max(b.width);
            let (x0, x1) = (clip(b.from_us), clip(b.to_us));
            let tall = |w: u16| f64::from(w) / f64::from(widest) * BAR;
            if b.reason.is_some() {
                bar(&mut asked, x0, x1, y, tall(b.requested).max(3.0));
                if b.width > 0 {
                    bar(&mut cut, x0, x1, y, tall(b.width).max(1.0));
                }
            } else {
                bar(&mut whole, x0, x1, y, tall(b.width).max(1.0));
            }
        }
        svg.path(&whole, "burst");
        svg.path(&cut, "burst cut");
        svg.path(&asked, "asked");
        let right = plot.left + plot.width + 8.0;
        let text = if peak > 0 {
            format!("\u{2264} {:.2} %", duty(peak))
        } else {
            "off".to_owned()
        };
        svg.text((right, y - 6.0), "tick", &text);
    }
    contact_row(trace, &plot, &mut svg, base(1.0), (from_us, to_us));
    event_row(trace, all, &plot, &mut svg, base(0.0), (from_us, to_us));
    plot.frame(&mut svg);
    svg.finish()
}

fn rulings(trace: &Trace, plot: &Plot, svg: &mut Svg, wires: &[u16], base: &dyn Fn(f64) -> f64) {
    let names = ["events".to_owned(), "taxels".to_owned()];
    let wires = wires.iter().map(|w| format!("wire {w}"));
    for (row, name) in names.into_iter().chain(wires).enumerate() {
        let y = base(row as f64);
        svg.text((plot.left - 8.0, y - 6.0), "tick end", &name);
        svg.line(
            (plot.left, y + 2.0),
            (plot.left + plot.width, y + 2.0),
            "ruling",
        );
    }
    svg.text(
        (plot.left + plot.width + 8.0, base(0.0) - 6.0),
        "tick",
        "duty, peak",
    );
    let most = trace.events.iter().filter_map(|e| match e {
        Event::Frame { in_contact, .. } => Some(*in_contact),
        _ => None,
    });
    let most = format!("\u{2264} {}", most.max().unwrap_or(0));
    svg.text(
        (plot.left + plot.width + 8.0, base(1.0) - 6.0),
        "tick",
        &most,
    );
}

/// Taxels in contact as a filled outline.
fn contact_row(trace: &Trace, plot: &Plot, svg: &mut Svg, base: f64, span: (u64, u64)) {
    let mut points: Vec<(u64, u16)> = Vec::new();
    for event in &trace.events {
        if let Event::Frame {
            t_us, in_contact, ..
        } = event
        {
            points.push((*t_us, *in_contact));
        }
    }
    let most = points.iter().map(|p| p.1).max().unwrap_or(0).max(1);
    let mut out = String::new();
    let mut last: Option<(u16, f64)> = None;
    for (t_us, n) in points
        .into_iter()
        .filter(|p| p.0 >= span.0 && p.0 <= span.1)
    {
        let x = plot.px(seconds(t_us));
        if let Some((before, _)) = last.filter(|(before, at)| *before != n || x - at > 40.0) {
            let height = f64::from(before) / f64::from(most) * BAR;
            let _ = write!(out, "L{x:.1} {:.1}", base - height);
        }
        let height = f64::from(n) / f64::from(most) * BAR;
        if last.is_none() {
            let _ = write!(out, "M{x:.1} {base:.1}");
        }
        if last.is_none_or(|(before, at)| before != n || x - at > 40.0) {
            let _ = write!(out, "L{x:.1} {:.1}", base - height);
            last = Some((n, x));
        }
    }
    if last.is_some() {
        let end = span.1.min(length_us(trace));
        let x = plot.px(seconds(end));
        let height = last.map_or(0.0, |(n, _)| f64::from(n) / f64::from(most) * BAR);
        let _ = write!(out, "L{x:.1} {:.1}L{x:.1} {base:.1}z", base - height);
    }
    svg.path(&out, "touched");
}

fn event_row(
    trace: &Trace,
    all: &[Burst],
    plot: &Plot,
    svg: &mut Svg,
    base: f64,
    span: (u64, u64),
) {
    let (mut breaks, mut off, mut notes) = (String::new(), String::new(), String::new());
    let mut limits = String::new();
    let within = |t: u64| t >= span.0 && t <= span.1;
    let tick = |out: &mut String, t: u64, up: f64, h: f64| {
        if within(t) {
            let _ = write!(out, "M{:.1} {:.1}v{:.1}", plot.px(seconds(t)), base - up, h);
        }
    };
    for event in &trace.events {
        match event {
            Event::Felt {
                t_us,
                inside: true,
                felt: None,
                ..
            } => tick(&mut breaks, *t_us, 10.0, 10.0),
            Event::AllOff { t_us, .. } => tick(&mut off, *t_us, 22.0, 22.0),
            Event::Note { t_us, .. } => tick(&mut notes, *t_us, 22.0, 22.0),
            _ => {}
        }
    }
    for burst in all.iter().filter(|b| b.reason.is_some()) {
        tick(&mut limits, burst.from_us, 22.0, 10.0);
    }
    svg.path(&notes, "mark note-mark");
    svg.path(&breaks, "mark break-mark");
    svg.path(&limits, "mark limit-mark");
    svg.path(&off, "mark off-mark");
}

/// A window short enough to see single bursts: around the first limiter event, else around the first
/// busy moment. `None` where the whole run is that short or has no burst.
pub(super) fn detail(trace: &Trace, all: &[Burst]) -> Option<(u64, u64)> {
    let soa = trace.header.soa_us.max(1_000);
    let span = soa.saturating_mul(20);
    let length = length_us(trace);
    if length <= span.saturating_mul(3) / 2 {
        return None;
    }
    let limited = all.iter().find(|b| b.reason.is_some());
    let middle = limited.or_else(|| all.get(all.len() / 2))?.from_us;
    let from = (middle.saturating_sub(span / 2) / soa).saturating_mul(soa);
    let from = from.min(length - span);
    Some((from, from + span))
}
