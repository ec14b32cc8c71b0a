//! Plots of measurements: work-precision diagrams, courses over time and places.

use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{Plot as Frame, Svg, dot, escape};
use std::fmt::Write;

use crate::findings::Figure;

const SIZE: (f64, f64) = (860.0, 430.0);
/// What decades reach beyond the outermost points at least.
const MARGIN: f64 = 2.0;
/// Colours of the style sheet.
const COLOURS: usize = 8;

/// How the points of a series are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Large dots, joined: what the program uses.
    Ours,
    /// Dots, joined: settings of one method.
    Swept,
    /// A line alone: a quantity over time.
    Line,
    /// Small dots, not joined: places.
    Scatter,
    /// Large dots, not joined: what stands where it is.
    Places,
    /// Red crosses, not joined: places where something is missing.
    Crosses,
}

/// Points of one name.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// As the legend says it.
    pub name: String,
    /// How they are drawn.
    pub mark: Mark,
    /// Points in the axes' units; those that are no numbers are left out.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// Points of one name.
    pub fn new(name: impl Into<String>, mark: Mark, points: Vec<(f64, f64)>) -> Self {
        Self {
            name: name.into(),
            mark,
            points,
        }
    }
}

/// An axis: quantity and unit, and how it is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis<'a> {
    label: &'a str,
    log: bool,
    span: Option<(f64, f64)>,
}

impl<'a> Axis<'a> {
    /// Equal steps.
    pub const fn linear(label: &'a str) -> Self {
        Self {
            label,
            log: false,
            span: None,
        }
    }

    /// Decades.
    pub const fn decades(label: &'a str) -> Self {
        Self {
            log: true,
            ..Self::linear(label)
        }
    }

    /// From `low` to `high`, whatever the points are.
    pub const fn span(self, low: f64, high: f64) -> Self {
        Self {
            span: Some((low, high)),
            ..self
        }
    }

    fn can_show(&self, value: f64) -> bool {
        value.is_finite() && (!self.log || value > 0.0)
    }

    fn scale(&self, values: impl Iterator<Item = f64>) -> Scale {
        let ends = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), ends);
        match (self.span, low <= high, self.log) {
            (Some((low, high)), _, true) => Scale::decades(low, high),
            (Some((low, high)), _, false) => Scale::exact(low, high),
            (None, true, true) => Scale::decades(low / MARGIN, high * MARGIN),
            (None, true, false) => Scale::round(low, high),
            (None, false, _) => Scale::exact(0.0, 1.0),
        }
    }
}

/// Where a plot stands in a drawing, pixels.
#[derive(Clone, Copy, Debug)]
pub struct Area {
    /// Upper left corner of its frame.
    pub at: (f64, f64),
    /// Width and height of its frame.
    pub size: (f64, f64),
}

/// Series over two axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot<'a> {
    /// To the right.
    pub x: Axis<'a>,
    /// Upwards.
    pub y: Axis<'a>,
    /// What is drawn.
    pub series: Vec<Series>,
}

impl<'a> Plot<'a> {
    /// Error against median run time, both in decades.
    pub const fn work_precision(error: &'a str, series: Vec<Series>) -> Self {
        Self {
            x: Axis::decades("median run time [\u{b5}s]"),
            y: Axis::decades(error),
            series,
        }
    }

    /// A figure of its own; `words` say what it shows.
    pub fn figure(&self, name: &str, title: &str, words: &str) -> Figure {
        let (width, height) = SIZE;
        let mut svg = Svg::new(width, height, title);
        self.draw(
            &mut svg,
            Area {
                at: (64.0, 30.0),
                size: (width - 104.0, height - 80.0),
            },
        );
        Figure {
            name: name.into(),
            title: title.into(),
            words: words.into(),
            svg: svg.finish(),
            legend: self.legend(),
        }
    }

    /// Draws axes and series. A series of one point carries its number in the legend, as colours repeat.
    pub fn draw(&self, svg: &mut Svg, area: Area) {
        let shown = |p: &&(f64, f64)| self.x.can_show(p.0) && self.y.can_show(p.1);
        let all = || self.series.iter().flat_map(|s| &s.points).filter(shown);
        let frame = Frame {
            left: area.at.0,
            top: area.at.1,
            width: area.size.0,
            height: area.size.1,
            x: self.x.scale(all().map(|p| p.0)),
            y: self.y.scale(all().map(|p| p.1)),
        };
        frame.x_axis(svg, self.x.label);
        frame.y_axis(svg, self.y.label);
        frame.frame(svg);
        for (i, series) in self.series.iter().enumerate() {
            let (mut line, mut dots, mut crosses) = (String::new(), String::new(), String::new());
            for &point in series.points.iter().filter(shown) {
                let (x, y) = frame.at(point);
                let step = if line.is_empty() { 'M' } else { 'L' };
                let _ = write!(line, "{step}{x:.1} {y:.1}");
                let (left, up, down) = (x - 3.0, y - 3.0, y + 3.0);
                let _ = write!(crosses, "M{left:.1} {up:.1}l6 6M{left:.1} {down:.1}l6 -6");
                dot(&mut dots, (x, y));
                if series.points.len() == 1 {
                    svg.text((x + 7.0, y + 4.0), "label", &(i + 1).to_string());
                }
            }
            if matches!(series.mark, Mark::Ours | Mark::Swept | Mark::Line) {
                svg.path(&line, &format!("series {}", colour(i)));
            }
            match series.mark {
                Mark::Line => {}
                Mark::Crosses => svg.path(&crosses, "cross"),
                _ => svg.path(&dots, &dots_class(series, i)),
            }
        }
    }

    /// What the colours mean, as HTML.
    pub fn legend(&self) -> String {
        let mut out = String::from("<div class=\"legend\">");
        for (i, series) in self.series.iter().enumerate() {
            let dots = match series.mark {
                Mark::Line => String::new(),
                _ => format!("<path class=\"{}\" d=\"M13 6h0\"/>", dots_class(series, i)),
            };
            let number = match series.points.len() {
                1 => format!("{} ", i + 1),
                _ => String::new(),
            };
            let _ = write!(
                out,
                "<span><svg viewBox=\"0 0 26 12\"><line class=\"series {}\" x1=\"1\" y1=\"6\" x2=\"25\" \
                 y2=\"6\"/>{dots}</svg>{number}{}</span>",
                colour(i),
                escape(&series.name)
            );
        }
        out.push_str("</div>");
        out
    }
}

/// The colour of series `i`; from the ninth on they repeat.
fn colour(i: usize) -> String {
    format!("w{}", i % COLOURS)
}

/// What the program uses, and what would be lost as a single small dot, stand out.
fn dots_class(series: &Series, i: usize) -> String {
    let size = match series.mark {
        Mark::Ours | Mark::Places => "dots big",
        _ if series.points.len() == 1 => "dots big",
        _ => "dots",
    };
    format!("{size} {}", colour(i))
}
