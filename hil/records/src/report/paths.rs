//! Figures over a plane: the contact path on the pad, the felt path on the display. Millimetres.

use super::scale::Scale;
use super::svg::{Plot, Svg, dot};
use crate::measure::length_us;
use crate::trace::{FeltAt, PlaceUm, Trace, event};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Steps of colour from the start of the run to its end.
const HUES: usize = 10;
/// Most taxels that are drawn, and that are played; of more, every so many is drawn.
pub(super) const TAXELS: usize = 4_096;
const WIDTH: f64 = 540.0;
const HEIGHT: f64 = 520.0;

pub(super) fn mm(p: PlaceUm) -> (f64, f64) {
    (f64::from(p.x) / 1000.0, f64::from(p.y) / 1000.0)
}

fn plane() -> Plot {
    Plot {
        left: 58.0,
        top: 28.0,
        width: WIDTH - 70.0,
        height: HEIGHT - 72.0,
        x: Scale::exact(0.0, 1.0),
        y: Scale::exact(0.0, 1.0),
    }
}

/// Least and most of both axes.
#[derive(Clone, Copy)]
pub(super) struct Span {
    pub(super) low: (f64, f64),
    pub(super) high: (f64, f64),
}

impl Span {
    pub(super) fn around(places: impl Iterator<Item = (f64, f64)>, rim: f64) -> Option<Self> {
        let wide = |all: Option<Self>, (x, y): (f64, f64)| {
            let all = all.unwrap_or(Self {
                low: (x, y),
                high: (x, y),
            });
            Some(Self {
                low: (all.low.0.min(x), all.low.1.min(y)),
                high: (all.high.0.max(x), all.high.1.max(y)),
            })
        };
        let all = places.fold(None, wide)?;
        Some(Self {
            low: (all.low.0 - rim, all.low.1 - rim),
            high: (all.high.0 + rim, all.high.1 + rim),
        })
    }

    /// Factor by which these millimetres fit into a room; 1 at most.
    pub(super) fn fit(&self, room: (f64, f64)) -> f64 {
        let part = |size: f64, room: f64| room / size.max(1e-6);
        let (w, h) = (self.high.0 - self.low.0, self.high.1 - self.low.1);
        part(w, room.0).min(part(h, room.1)).min(1.0)
    }
}

fn axes(plot: &mut Plot, svg: &mut Svg, places: &[(f64, f64)], rim: f64, what: &str) {
    let (low, high) = Span::around(places.iter().copied(), rim)
        .map_or(((-10.0, -10.0), (10.0, 10.0)), |all| (all.low, all.high));
    plot.equal(low, high);
    plot.x_axis(svg, &format!("{what} x [mm]"));
    plot.y_axis(svg, &format!("{what} y [mm]"));
    plot.frame(svg);
}

/// Smallest distance of two of the places, or a fallback.
pub(super) fn pitch(places: &[(f64, f64)]) -> f64 {
    let mut best = f64::INFINITY;
    for (i, a) in places.iter().enumerate().take(400) {
        for b in places.iter().skip(i + 1).take(400) {
            let d = (a.0 - b.0).hypot(a.1 - b.1);
            if d > 1e-3 {
                best = best.min(d);
            }
        }
    }
    if best.is_finite() { best } else { 4.7 }
}

/// A way that is gone again and again is drawn once: steps between cells of two pixels.
#[derive(Default)]
struct Trodden(BTreeSet<[i32; 4]>);

impl Trodden {
    /// Most steps of one colour.
    const MOST: usize = 4_000;

    /// Tells whether this step is new, and there is room for it.
    fn is_new(&mut self, from: (f64, f64), to: (f64, f64)) -> bool {
        let cell = |v: f64| (v / 2.0).round() as i32;
        let step = [from.0, from.1, to.0, to.1].map(cell);
        self.0.len() < Self::MOST && self.0.insert(step)
    }
}

/// A stroke in the colours of its time: thin line, and dots not closer than two pixels.
#[derive(Default)]
pub(super) struct Stroke {
    lines: [String; HUES],
    dots: [String; HUES],
    last: Option<(f64, f64)>,
    last_dot: Option<(f64, f64)>,
    trodden: [Trodden; HUES],
    dotted: [Trodden; HUES],
}

impl Stroke {
    fn to(&mut self, at: (f64, f64), hue: usize) {
        let far =
            |p: Option<(f64, f64)>, d: f64| p.is_none_or(|p| (p.0 - at.0).hypot(p.1 - at.1) >= d);
        let hue = hue.min(HUES - 1);
        if let (Some(from), true) = (self.last, far(self.last, 0.7))
            && self.trodden[hue].is_new(from, at)
        {
            let line = &mut self.lines[hue];
            let _ = write!(line, "M{:.1} {:.1}L{:.1} {:.1}", from.0, from.1, at.0, at.1);
        }
        if far(self.last, 0.7) {
            self.last = Some(at);
        }
        if far(self.last_dot, 2.0) && self.dotted[hue].is_new(at, at) {
            dot(&mut self.dots[hue], at);
            self.last_dot = Some(at);
        }
    }

    fn lift(&mut self) {
        self.last = None;
    }

    pub(super) fn draw(&self, svg: &mut Svg, dots: &str) {
        for (hue, line) in self.lines.iter().enumerate() {
            svg.path(line, &format!("trail h{hue}"));
        }
        for (hue, d) in self.dots.iter().enumerate() {
            svg.path(d, &format!("{dots} h{hue}"));
        }
    }
}

fn hue(t_us: u64, length: u64) -> usize {
    let tenth = u128::from(t_us) * HUES as u128 / u128::from(length.max(1));
    usize::try_from(tenth).unwrap_or(HUES - 1).min(HUES - 1)
}

/// The contact path over the pad, with the true path where one is known.
pub(super) fn contact_path(trace: &Trace) -> (String, Plot) {
    let taxels: Vec<_> = trace.header.taxels.iter().map(|p| mm(*p)).collect();
    let pitch = pitch(&taxels);
    let mut places = taxels.clone();
    places.extend(
        trace
            .each()
            .map(|contact: &event::Contact| mm(contact.place)),
    );
    places.extend(trace.each().map(|truth: &event::Truth| mm(truth.place)));
    let mut plot = plane();
    let mut svg = Svg::new(WIDTH, HEIGHT, "Contact path over the taxels of the pad");
    axes(&mut plot, &mut svg, &places, pitch * 0.65, "sensor");
    let half = plot.px(pitch * 0.41) - plot.px(0.0);
    for taxel in taxels.iter().step_by(taxels.len().div_ceil(TAXELS).max(1)) {
        let (x, y) = plot.at(*taxel);
        svg.rect((x - half, y - half), (2.0 * half, 2.0 * half), "taxel");
    }
    // A broad band below the contacts: a path that is followed well hides no thin line.
    truth(trace, &plot, &mut svg);
    let (strokes, first) = touched(trace, length_us(trace), |_, place| plot.at(place));
    for stroke in strokes {
        stroke.draw(&mut svg, "dots");
    }
    if let Some(at) = first {
        svg.circle(at, 6.5, "start");
    } else {
        svg.text(
            (plot.left + plot.width, plot.top - 11.0),
            "note end",
            "no contact in this run",
        );
    }
    (svg.finish(), plot)
}

/// The paths of a run's contacts in the colours of their time, and where the first one is; `at` says where a place on a
/// module is drawn.
pub(super) fn touched(
    trace: &Trace,
    length: u64,
    at: impl Fn(u16, (f64, f64)) -> (f64, f64),
) -> (Vec<Stroke>, Option<(f64, f64)>) {
    let mut strokes: BTreeMap<(u16, u32), (Stroke, u32)> = BTreeMap::new();
    let mut first = None;
    for now in trace.each::<event::Contact>() {
        let at = at(now.module, mm(now.place));
        first.get_or_insert(at);
        let (stroke, before) = strokes.entry((now.module, now.contact)).or_default();
        if now.frame.saturating_sub(*before) > 1 {
            stroke.lift();
        }
        *before = now.frame;
        stroke.to(at, hue(now.t_us, length));
    }
    (strokes.into_values().map(|(s, _)| s).collect(), first)
}

/// Felt and unfelt onsets of a run.
#[derive(Default)]
pub(super) struct Felt {
    /// Path of the contacts.
    target: Stroke,
    /// Path at which they were felt.
    pub(super) path: Stroke,
    /// Contacts inside the display that were not felt.
    pub(super) crosses: String,
    /// Contacts outside the display that were not felt.
    outside: String,
    /// The first felt place.
    first: Option<(f64, f64)>,
}

/// The felt path of a run; `at` says where a place on the display is drawn.
pub(super) fn felt(trace: &Trace, length: u64, at: impl Fn((f64, f64)) -> (f64, f64)) -> Felt {
    let mut all = Felt::default();
    let mut crossed = Trodden::default();
    let gap = trace.header.soa_us.saturating_mul(2).max(1);
    let mut before = None;
    for onset in trace.each::<event::Felt>() {
        let t_us = onset.t_us;
        if before.is_some_and(|b: u64| t_us.saturating_sub(b) > gap) {
            all.target.lift();
            all.path.lift();
        }
        before = Some(t_us);
        let aim = at(mm(onset.target));
        all.target.to(aim, 0);
        match onset.met.filter(FeltAt::is_felt) {
            Some(felt) => {
                let at = at(mm(felt.energy));
                all.first.get_or_insert(at);
                all.path.to(at, hue(t_us, length));
            }
            None => {
                all.path.lift();
                if crossed.is_new(aim, aim) {
                    let into = if onset.inside {
                        &mut all.crosses
                    } else {
                        &mut all.outside
                    };
                    cross(into, aim);
                }
            }
        }
    }
    all
}

fn truth(trace: &Trace, plot: &Plot, svg: &mut Svg) {
    let point = |truth: &event::Truth| (truth.t_us, plot.at(mm(truth.place)));
    let points: Vec<(u64, (f64, f64))> = trace.each().map(point).collect();
    // Several touches at one time have no order to join them in: dots then.
    let several = points.windows(2).any(|w| matches!(w, [a, b] if a.0 == b.0));
    let mut line = String::new();
    let mut last: Option<(u64, (f64, f64))> = None;
    let (mut trodden, mut lifted) = (Trodden::default(), false);
    for (t_us, at) in points {
        if several {
            if trodden.is_new(at, at) {
                dot(&mut line, at);
            }
            continue;
        }
        let joined = last.filter(|(t, _)| t_us - t <= 100_000);
        match joined {
            Some((_, p)) if (p.0 - at.0).hypot(p.1 - at.1) < 0.7 => {
                last = Some((t_us, p));
                continue;
            }
            Some((_, from)) if trodden.is_new(from, at) => {
                if std::mem::take(&mut lifted) {
                    let _ = write!(line, "M{:.1} {:.1}", from.0, from.1);
                }
                let _ = write!(line, "L{:.1} {:.1}", at.0, at.1);
            }
            Some(_) => lifted = true,
            // A touch that rests is a dot.
            None => {
                lifted = !trodden.is_new(at, at);
                if !lifted {
                    let _ = write!(line, "M{:.1} {:.1}h0", at.0, at.1);
                }
            }
        }
        last = Some((t_us, at));
    }
    svg.path(&line, if several { "truth-dots" } else { "truth" });
}

fn cross(out: &mut String, (x, y): (f64, f64)) {
    let (left, top, bottom) = (x - 4.5, y - 4.5, y + 4.5);
    let _ = write!(out, "M{left:.1} {top:.1}l9 9M{left:.1} {bottom:.1}l9 -9");
}

/// Room around the places of a display, mm: as wide as half a wire, and as the name of one beside it.
fn rim(wires: &[(f64, f64)]) -> f64 {
    let along = wires.iter().map(|wire| wire.0);
    let (low, high) = (along.clone().fold(0.0, f64::min), along.fold(0.0, f64::max));
    (0.08 * (high - low)).max(2.6)
}

/// The felt path on the display: wires, where the contact was, where it is felt, where it breaks.
pub(super) fn felt_path(trace: &Trace) -> (String, Plot) {
    let wires: Vec<_> = trace.header.wires.iter().map(|w| mm(w.place)).collect();
    let mut places = wires.clone();
    for onset in trace.each::<event::Felt>() {
        places.push(mm(onset.target));
        let felt = onset.met.filter(FeltAt::is_felt);
        places.extend(felt.map(|f| mm(f.energy)));
    }
    let mut plot = plane();
    let mut svg = Svg::new(WIDTH, HEIGHT, "Felt path on the display");
    axes(&mut plot, &mut svg, &places, rim(&wires), "display");
    let Felt {
        target: target_path,
        path: felt_path,
        crosses,
        outside,
        first,
    } = felt(trace, length_us(trace), |place| plot.at(place));
    svg.path(&target_path.lines.concat(), "aim");
    let bar = plot.px(2.5) - plot.px(0.0);
    for (index, wire) in wires.iter().enumerate() {
        let (x, y) = plot.at(*wire);
        svg.line((x - bar, y), (x + bar, y), "wire");
        svg.text((x + bar + 4.0, y + 4.0), "wire-name", &index.to_string());
    }
    felt_path.draw(&mut svg, "dots big");
    svg.path(&outside, "cross dim");
    svg.path(&crosses, "cross");
    if let Some(at) = first {
        svg.circle(at, 7.5, "start");
    } else {
        svg.text(
            (plot.left + plot.width, plot.top - 11.0),
            "note end",
            if trace.each::<event::Felt>().next().is_some() {
                "nothing was felt in this run"
            } else {
                "no onset with one contact"
            },
        );
    }
    (svg.finish(), plot)
}
