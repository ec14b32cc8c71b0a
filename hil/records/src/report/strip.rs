//! The schedule as a strip chart: a row a wire, a bar a burst, its height the width of the pulses.

use super::scale::Scale;
use super::timeplot::{Pen, SPAN, TimePlot, tenth_ms};
use crate::bursts::{Burst, shown_wires};
use crate::measure::length_us;
use crate::trace::{Event, Trace, event};
use palpate_core::units::Ticks;

/// Height of a row on the page, pixels.
const ROW: f64 = 30.0;
/// Base of a row's bars, and height of the highest, in units of the paths.
const BASE: i64 = 8_700;
const BAR: i64 = 7_300;
/// Most wires with a row.
const ROWS: usize = 32;

fn duty(width: u16) -> f64 {
    f64::from(width) / f64::from(Ticks::PER_PERIOD) * 100.0
}

/// Height of a part of a whole in a row.
fn tall(part: u16, whole: u16) -> i64 {
    let whole = i64::from(whole.max(1));
    (i64::from(part) * BAR + whole / 2) / whole
}

fn base(row: usize) -> i64 {
    i64::try_from(row).unwrap_or(0) * SPAN + BASE
}

/// Bars of a row, of which those too close to be told apart become one as high as the highest.
#[derive(Default)]
struct Bars {
    pen: Pen,
    pending: Option<(i64, i64, i64)>,
}

impl Bars {
    fn add(&mut self, (from, to): (i64, i64), height: i64, base: i64, column: i64) {
        match &mut self.pending {
            Some((first, last, highest)) if from / column == *first / column => {
                (*last, *highest) = ((*last).max(to), (*highest).max(height));
            }
            _ => {
                self.flush(base);
                self.pending = Some((from, to, height));
            }
        }
    }

    fn flush(&mut self, base: i64) {
        if let Some((from, to, height)) = self.pending.take() {
            self.pen.bar((from, base), to - from, height);
        }
    }

    fn finish(mut self, base: i64) -> String {
        self.flush(base);
        self.pen.finish()
    }
}

/// Chart of a stretch of time, microseconds.
pub(super) fn schedule(trace: &Trace, all: &[Burst], span: (u64, u64)) -> String {
    let wires = shown_wires(trace, all, ROWS);
    let rows = wires.len() + 2;
    let label = "Schedule, one row per wire, against time";
    let y = Scale::exact(0.0, 1.0);
    let plot = TimePlot::new(label, "%", rows as f64 * ROW, span, y);
    let mut plot = plot.with_rows(rows).named();
    let widest = all.iter().map(|b| b.width.max(b.requested)).max();
    let widest = widest.unwrap_or(0).max(1);
    let most = names(trace, &mut plot, &wires);
    for (row, wire) in wires.iter().enumerate() {
        let name = format!("{} {wire}", trace.header.actuator());
        wire_row(&mut plot, (all, &name), (row + 2, *wire), span, widest);
    }
    contact_row(trace, &mut plot, most, span);
    event_row(trace, all, &mut plot, span);
    plot.finish(
        2,
        &format!(
            " data-bar=\"{BAR}\" data-duty=\"{}\" data-most=\"{most}\"",
            duty(widest)
        ),
    )
}

/// Writes the names of the rows, and the most taxels in contact.
fn names(trace: &Trace, plot: &mut TimePlot, wires: &[u16]) -> u16 {
    let fixed = ["events".to_owned(), "taxels".to_owned()];
    let actuator = trace.header.actuator();
    let wires = wires.iter().map(|w| format!("{actuator} {w}"));
    for (row, name) in fixed.into_iter().chain(wires).enumerate() {
        plot.row_name(row, &name);
        plot.across(base(row) + 300, "ruling");
    }
    plot.row_note(0, &format!("{}, peak", trace.header.strength()));
    let most = trace.each().map(|frame: &event::Frame| frame.in_contact);
    let most = most.max().unwrap_or(0);
    plot.row_note(1, &format!("\u{2264} {most}"));
    most
}

fn wire_row(
    plot: &mut TimePlot,
    (all, name): (&[Burst], &str),
    (row, wire): (usize, u16),
    span: (u64, u64),
    widest: u16,
) {
    let (mut whole, mut cut, mut asked) = (Bars::default(), Bars::default(), Bars::default());
    let (base, column) = (base(row), plot.column());
    let mut peak = 0;
    let clip = |us: u64| tenth_ms(us.clamp(span.0, span.1));
    let inside = |b: &&Burst| b.from_us <= span.1 && b.to_us >= span.0;
    let own = all.iter().filter(|b| b.wire() == Some(wire));
    for b in own.filter(inside) {
        peak = peak.max(b.width);
        let (of, height) = ((clip(b.from_us), clip(b.to_us)), tall(b.width, widest));
        if b.reason.is_none() {
            whole.add(of, height, base, column);
            continue;
        }
        asked.add(of, tall(b.requested, widest).max(1_000), base, column);
        if b.width > 0 {
            cut.add(of, height, base, column);
        }
    }
    plot.path("bars", name, "burst", &whole.finish(base));
    plot.path("bars", name, "burst cut", &cut.finish(base));
    let name = format!("{name}, requested");
    plot.path("bars", &name, "asked", &asked.finish(base));
    let text = if peak > 0 {
        format!("\u{2264} {:.2} %", duty(peak))
    } else {
        "off".to_owned()
    };
    plot.row_note(row, &text);
}

/// Taxels in contact as bars, each as long as the count stays.
fn contact_row(trace: &Trace, plot: &mut TimePlot, most: u16, span: (u64, u64)) {
    let count = |frame: &event::Frame| (frame.t_us, frame.in_contact);
    let frames = trace.each().map(count);
    let inside: Vec<_> = frames.filter(|f| f.0 >= span.0 && f.0 <= span.1).collect();
    let mut bars = Bars::default();
    let end = span.1.min(length_us(trace));
    let mut from = inside.first().map_or(0, |f| f.0);
    for (n, (_, count)) in inside.iter().enumerate() {
        let next = inside.get(n + 1);
        if next.is_some_and(|next| next.1 == *count) {
            continue;
        }
        let to = next.map_or(end, |next| next.0);
        if *count > 0 {
            let of = (tenth_ms(from), tenth_ms(to));
            bars.add(of, tall(*count, most), base(1), plot.column());
        }
        from = to;
    }
    plot.path("bars", "taxels", "touched", &bars.finish(base(1)));
}

fn event_row(trace: &Trace, all: &[Burst], plot: &mut TimePlot, span: (u64, u64)) {
    let column = plot.column();
    let [mut breaks, mut off, mut notes, mut limits] = [(); 4].map(|()| Bars::default());
    let mark = |bars: &mut Bars, t: u64, (up, height): (i64, i64)| {
        if t >= span.0 && t <= span.1 {
            bars.add((tenth_ms(t), tenth_ms(t)), height, base(0) - up, column);
        }
    };
    for event in &trace.events {
        match event {
            Event::Felt(e) if e.is_break() => mark(&mut breaks, e.t_us, (0, BAR / 2)),
            Event::AllOff(e) => mark(&mut off, e.t_us, (0, BAR)),
            Event::Note(e) => mark(&mut notes, e.t_us, (0, BAR)),
            _ => {}
        }
    }
    for burst in all.iter().filter(|b| b.reason.is_some()) {
        mark(&mut limits, burst.from_us, (BAR / 2, BAR / 2));
    }
    for (bars, up, name) in [
        (notes, 0, "note"),
        (breaks, 0, "break"),
        (limits, BAR / 2, "limit"),
        (off, 0, "off"),
    ] {
        let class = format!("mark {name}-mark");
        plot.path("marks", name, &class, &bars.finish(base(0) - up));
    }
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
