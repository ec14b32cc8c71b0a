//! The drawn hands: the robot's with what its skin found, the wearer's with what the thimbles let feel.

use std::fmt::Write;

use super::skeleton::{Digit, Hand, hands};
use super::{FingerReport, HandReport, link};
use crate::felt::felt_level;
use crate::measure::{length_us, path_error};
use crate::report::figures::{RAMP, break_key, taxel_key};
use crate::report::paths::{Span, TAXELS, felt, mm, pitch, touched};
use crate::report::scale::Scale;
use crate::report::svg::{Plot, Svg, line_key};
use crate::trace::event;

const WIDTH: f64 = 560.0;
/// Room above fingertips for their names, and at the sides, mm.
const RIM: f64 = 24.0;
/// Widths of a drawn finger: the robot's, and one with a thimble, mm.
const ROBOT: f64 = 27.0;
const WORN: f64 = 33.0;
/// Part of a finger that pads or wires may fill, across and along, mm.
const ROOM_PADS: (f64, f64) = (23.0, 140.0);
const ROOM_WIRES: (f64, f64) = (30.0, 46.0);
/// Distance from the edge of pads or wires to the tip of the finger, mm.
const TIP: f64 = 6.0;
/// Distance from a fingertip to its label, mm.
const LABEL: f64 = 7.0;
/// Half the length of a wire's mark, mm.
const BAR: f64 = 2.5;

/// Things drawn on fingers: places of each thing's own plane, which end at the fingertips.
struct Worn {
    spans: Vec<Option<Span>>,
    /// Factor from the thing's millimetres to the hand's, the same for all fingers.
    fit: f64,
    width: f64,
}

impl Worn {
    fn new(spans: Vec<Option<Span>>, room: (f64, f64), width: f64) -> Self {
        let fit = spans.iter().flatten().map(|s| s.fit(room));
        let fit = fit.fold(1.0, f64::min);
        Self { spans, fit, width }
    }

    /// Least length of each finger, mm.
    fn lengths(&self) -> Vec<f64> {
        let long =
            |s: &Option<Span>| s.map_or(0.0, |s| (s.high.1 - s.low.1) * self.fit + 2.0 * TIP);
        self.spans.iter().map(long).collect()
    }

    /// A place on a finger, in the hand's plane.
    fn at(&self, digit: &Digit, (x, y): (f64, f64)) -> (f64, f64) {
        let Some(Some(span)) = self.spans.get(digit.finger) else {
            return digit.at((0.0, digit.length));
        };
        let middle = (span.low.0 + span.high.0) / 2.0;
        let along = digit.length - TIP - (span.high.1 - y) * self.fit;
        digit.at(((x - middle) * self.fit, along))
    }
}

/// A robot finger's modules: where each one's centre is in the finger's own plane, that of its first module.
fn offset(hand: &HandReport<'_>, finger: &FingerReport<'_>, module: usize) -> (f64, f64) {
    let place = |m: usize| hand.pads.get(m).map_or([0.0; 2], |pad| pad.place_mm);
    let first = finger.modules.first().map_or([0.0; 2], |m| place(*m));
    let own = place(module);
    (own[0] - first[0], own[1] - first[1])
}

fn pads(hand: &HandReport<'_>) -> Worn {
    let span = |finger: &FingerReport<'_>| {
        let taxels = finger.modules.iter().flat_map(|m| {
            let (x, y) = offset(hand, finger, *m);
            let taxels = hand
                .pads
                .get(*m)
                .map(|pad| &*pad.taxels_mm)
                .unwrap_or_default();
            taxels.iter().map(move |t| (t[0] + x, t[1] + y))
        });
        Span::around(taxels, 2.35)
    };
    let spans = hand.fingers.iter().map(span).collect();
    Worn::new(spans, ROOM_PADS, ROBOT)
}

fn thimbles(hand: &HandReport<'_>) -> Worn {
    let span = |finger: &FingerReport<'_>| {
        let wires = finger.trace.header.wires.iter().map(|w| mm(w.place));
        Span::around(wires, BAR + 1.0)
    };
    let spans = hand.fingers.iter().map(span).collect();
    Worn::new(spans, ROOM_WIRES, WORN)
}

/// A closed outline with its corners cut round, each by its own radius, pixels.
fn rounded(corners: &[((f64, f64), f64)]) -> String {
    let mut out = String::new();
    let all = corners.len();
    for (n, (at, radius)) in corners.iter().enumerate() {
        let towards = |to: (f64, f64)| {
            let (dx, dy) = (to.0 - at.0, to.1 - at.1);
            let part = (radius / dx.hypot(dy).max(1e-6)).min(0.5);
            (at.0 + dx * part, at.1 + dy * part)
        };
        let from = towards(corners[(n + all - 1) % all].0);
        let to = towards(corners[(n + 1) % all].0);
        let letter = if n == 0 { 'M' } else { 'L' };
        let _ = write!(
            out,
            "{letter}{:.1} {:.1}Q{:.1} {:.1} {:.1} {:.1}",
            from.0, from.1, at.0, at.1, to.0, to.1
        );
    }
    out.push('z');
    out
}

/// A finger's outline from `from` along its axis to its tip, in the plane of `plot`.
fn finger(plot: &Plot, digit: &Digit, from: f64, width: f64) -> String {
    let half = width / 2.0;
    let round = plot.px(half) - plot.px(0.0);
    let corner =
        |across: f64, along: f64, radius: f64| (plot.at(digit.at((across, along))), radius);
    rounded(&[
        corner(-half, from, round * 0.3),
        corner(-half, digit.length, round * 0.9),
        corner(half, digit.length, round * 0.9),
        corner(half, from, round * 0.3),
    ])
}

/// A sheet with a hand's outline, and its plane.
fn sheet(hand: &Hand, width: f64, label: &str) -> (Svg, Plot) {
    let tips = hand.digits.iter().map(|d| d.at((0.0, d.length)));
    let [left, lower, right, upper] = hand.palm;
    let palm = [(left, lower), (right, upper)];
    let Span { low, high } = Span::around(tips.chain(palm), RIM).unwrap_or(Span {
        low: (-50.0, -50.0),
        high: (50.0, 50.0),
    });
    let low = (low.0, lower - 10.0);
    let scale = WIDTH / (high.0 - low.0);
    let height = (high.1 - low.1) * scale;
    let mut plot = Plot {
        left: 0.0,
        top: 0.0,
        width: WIDTH,
        height,
        x: Scale::exact(0.0, 1.0),
        y: Scale::exact(0.0, 1.0),
    };
    plot.equal(low, high);
    let mut svg = Svg::new(WIDTH, height, label);
    let round = 20.0 * scale;
    let at = |x, y, r| (plot.at((x, y)), r);
    let palm = rounded(&[
        at(left + 6.0, lower, round),
        at(left, upper, round * 0.4),
        at(right, upper, round * 0.4),
        at(right - 6.0, lower, round),
    ]);
    let fingers = hand.digits.iter().map(|d| finger(&plot, d, 0.0, width));
    let outline = fingers.fold(palm, |all, one| all + &one);
    // Twice, so that no edge is seen where a finger and the palm overlap.
    svg.path(&outline, "hand-rim");
    svg.path(&outline, "hand");
    let from = plot.at((low.0 + 6.0, lower));
    let to = plot.at((low.0 + 26.0, lower));
    svg.line(from, to, "median");
    svg.text((from.0, from.1 - 7.0), "tick", "20 mm");
    (svg, plot)
}

/// Two lines at a fingertip: the finger's name, and a figure.
fn label(svg: &mut Svg, plot: &Plot, digit: &Digit, (name, figure): (&str, &str)) {
    let (x, y) = plot.at(digit.at((0.0, digit.length + LABEL)));
    svg.text((x, y - 17.0), "label middle name", name);
    svg.text((x, y), "tick middle", figure);
}

/// A finger's name without its hand.
fn short<'a>(name: &'a str, hand: &Hand) -> &'a str {
    let own = name.strip_prefix(hand.name);
    own.and_then(|n| n.strip_prefix('-')).unwrap_or(name)
}

/// The robot's hand: pads, and the contacts that were found on them.
fn robot(hand: &HandReport<'_>, drawn: &Hand, pads: &Worn) -> String {
    let what = format!(
        "The robot's {} hand with the contacts on its pads",
        drawn.name
    );
    let (mut svg, plot) = sheet(drawn, pads.width, &what);
    let length = length_us(hand.trace);
    for digit in &drawn.digits {
        let finger = &hand.fingers[digit.finger];
        svg.open_link(&link(finger.file));
        for module in finger.modules {
            if let Some(pad) = hand.pads.get(*module) {
                let (x, y) = offset(hand, finger, *module);
                let taxels: Vec<_> = pad.taxels_mm.iter().map(|t| (t[0] + x, t[1] + y)).collect();
                let half = pitch(&taxels) * 0.41;
                let mut squares = String::new();
                let step = taxels.len().div_ceil(TAXELS).max(1);
                for (x, y) in taxels.into_iter().step_by(step) {
                    let corner = |dx, dy| (plot.at(pads.at(digit, (x + dx, y + dy))), 0.0);
                    let [low, high] = [-half, half];
                    let corners = [
                        corner(low, low),
                        corner(low, high),
                        corner(high, high),
                        corner(high, low),
                    ];
                    for (n, ((x, y), _)) in corners.into_iter().enumerate() {
                        let _ = write!(squares, "{}{x:.1} {y:.1}", if n == 0 { 'M' } else { 'L' });
                    }
                    squares.push('z');
                }
                svg.path(&squares, "taxel");
            }
        }
        let (strokes, _) = touched(finger.trace, length, |module, place| {
            let (x, y) = if finger.merged {
                // Places are those of the plane of the whole skin.
                let first = finger.modules.first().and_then(|m| hand.pads.get(*m));
                first.map_or((0.0, 0.0), |pad| (-pad.place_mm[0], -pad.place_mm[1]))
            } else {
                offset(hand, finger, usize::from(module))
            };
            plot.at(pads.at(digit, (place.0 + x, place.1 + y)))
        });
        strokes.iter().for_each(|s| s.draw(&mut svg, "dots"));
        let figure = path_error(finger.trace).map_or_else(
            || format!("{} contacts", contacts(finger)),
            |e| format!("{:.2} mm", e.rmse_um as f64 * 1e-3),
        );
        label(&mut svg, &plot, digit, (short(finger.name, drawn), &figure));
        svg.close_link();
    }
    svg.finish()
}

/// Number of contacts in a finger's frames.
pub(super) fn contacts(finger: &FingerReport<'_>) -> usize {
    finger.trace.each::<event::Contact>().count()
}

/// The wearer's hand: thimbles, and where they were felt.
fn wearer(hand: &HandReport<'_>, drawn: &Hand, thimbles: &Worn) -> String {
    let what = format!(
        "The wearer's {} hand with what its thimbles let feel",
        drawn.name
    );
    let (mut svg, plot) = sheet(drawn, thimbles.width - 3.0, &what);
    let length = length_us(hand.trace);
    for digit in &drawn.digits {
        let report = &hand.fingers[digit.finger];
        svg.open_link(&link(report.file));
        let long = thimbles.lengths().get(digit.finger).copied().unwrap_or(0.0);
        let from = (digit.length - long).max(0.0);
        svg.path(&finger(&plot, digit, from, thimbles.width), "thimble");
        let mut wires = String::new();
        for wire in &report.trace.header.wires {
            let (x, y) = mm(wire.place);
            let end = |side: f64| plot.at(thimbles.at(digit, (x + side * BAR, y)));
            let (from, to) = (end(-1.0), end(1.0));
            let _ = write!(
                wires,
                "M{:.1} {:.1}L{:.1} {:.1}",
                from.0, from.1, to.0, to.1
            );
        }
        svg.path(&wires, "wire thin");
        let felt = felt(report.trace, length, |place| {
            plot.at(thimbles.at(digit, place))
        });
        felt.path.draw(&mut svg, "dots");
        svg.path(&felt.crosses, "cross");
        let figure = felt_level(report.trace).map_or_else(
            || "nothing felt".to_owned(),
            |level| format!("{:+.1} dB", f64::from(level.median_mdb) * 1e-3),
        );
        label(&mut svg, &plot, digit, (short(report.name, drawn), &figure));
        svg.close_link();
    }
    svg.finish()
}

/// Writes both hands with their legends.
pub(super) fn section(page: &mut String, hand: &HandReport<'_>) {
    let names: Vec<&str> = hand.fingers.iter().map(|f| f.name).collect();
    let (pads, thimbles) = (pads(hand), thimbles(hand));
    let least = |worn: &Worn| worn.lengths();
    let robots = hands(&names, &least(&pads));
    let wearers = hands(&names, &least(&thimbles));
    page.push_str("<div class=\"pair\">");
    let heading = |whose: &str, name: &str| match name {
        "" => format!("The {whose} hand"),
        name => format!("The {whose} {name} hand"),
    };
    for drawn in &robots {
        let mut legend = String::new();
        let _ = write!(legend, "<span>contact: {RAMP}</span>");
        taxel_key(&mut legend);
        let _ = writeln!(
            page,
            "<section><h2>{}: touched</h2><p class=\"sub\">Pads of the skin, palm up. Beside a name: \
             how far its contacts lie from the truth, RMSE.{}</p>\
             <div class=\"plane\">{}</div><div class=\"legend\">{legend}</div></section>",
            heading("robot's", drawn.name),
            part(&pads, "Pads"),
            robot(hand, drawn, &pads)
        );
    }
    for drawn in &wearers {
        let mut legend = String::new();
        let _ = write!(legend, "<span>felt: {RAMP}</span>");
        break_key(&mut legend);
        line_key(&mut legend, "wire thin", "wire");
        let _ = writeln!(
            page,
            "<section><h2>{}: felt</h2><p class=\"sub\">Thimbles unrolled, palm up. Beside a name: \
             the level over the person's threshold, median.{}</p>\
             <div class=\"plane\">{}</div><div class=\"legend\">{legend}</div></section>",
            heading("wearer's", drawn.name),
            part(&thimbles, "Thimbles"),
            wearer(hand, drawn, &thimbles)
        );
    }
    page.push_str("</div>\n");
}

/// Note on things that are not drawn to the hand's scale.
fn part(worn: &Worn, what: &str) -> String {
    if worn.fit > 0.999 {
        return String::new();
    }
    format!(
        " {what} are drawn at {:.0} % of the hand's scale.",
        worn.fit * 100.0
    )
}
