//! Plots of measurements: work-precision diagrams, courses over time and places.

use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{self, Plot as Frame, Svg, dot, key};
use std::fmt::Write;

use crate::findings::Figure;

const SIZE: (f64, f64) = (860.0, 430.0);
/// Size of a drawing of a plane, which is about square, pixels.
const PLANE: (f64, f64) = (704.0, 680.0);
/// Place at which rows of a legend begin, pixels.
const LEGEND: f64 = 64.0;
/// Least reach of decades beyond the outermost points.
const MARGIN: f64 = 2.0;
/// Colours of the style sheet.
const COLOURS: usize = 8;

/// Marks that draw the points of a series.
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
    /// Bars from the lower edge, as wide as their distance: how often.
    Bars,
    /// Large dots, not joined: what stands where it is.
    Places,
    /// Red crosses, not joined: places where something is missing.
    Crosses,
}

/// Points of one name.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name of the series in the legend.
    pub name: String,
    /// Mark of its points.
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
    plane: bool,
}

impl<'a> Axis<'a> {
    /// Equal steps.
    pub const fn linear(label: &'a str) -> Self {
        Self {
            label,
            log: false,
            span: None,
            plane: false,
        }
    }

    /// Decades.
    pub const fn decades(label: &'a str) -> Self {
        Self {
            log: true,
            ..Self::linear(label)
        }
    }

    /// A direction of a plane: a millimetre is as long on both axes.
    pub const fn plane(label: &'a str) -> Self {
        Self {
            plane: true,
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

/// Place of a plot in a drawing, pixels.
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
    /// Series that are drawn.
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

    /// Places on a plane, mm.
    pub const fn of_plane(series: Vec<Series>) -> Self {
        Self {
            x: Axis::plane("x [mm]"),
            y: Axis::plane("y [mm]"),
            series,
        }
    }

    /// Courses over time, s.
    pub const fn over_time(y: Axis<'a>, series: Vec<Series>) -> Self {
        Self {
            x: Axis::linear("time [s]"),
            y,
            series,
        }
    }

    /// A figure of its own; `words` say what it shows.
    pub fn figure(&self, name: &str, title: &str, words: &str) -> Figure {
        let (width, height) = match self.x.plane {
            true => PLANE,
            false => SIZE,
        };
        let area = |top: f64| Area {
            at: (64.0, 30.0 + top),
            size: (width - 104.0, height - 80.0),
        };
        let mut svg = Svg::new(width, height, title);
        self.draw(&mut svg, area(0.0));
        // A file stands alone: it has title and legend in the drawing.
        let (rows, title_height) = (self.legend_rows(width), 26.0);
        let below = height + title_height;
        let whole = below + 20.0 * rows.len() as f64 + 6.0;
        let mut alone = Svg::new(width, whole, title);
        alone.text((20.0, 20.0), "label name", title);
        self.draw(&mut alone, area(title_height));
        for (row, entries) in rows.iter().enumerate() {
            let y = below + 20.0 * row as f64;
            for (x, index) in entries {
                self.legend_entry(&mut alone, (*x, y), *index);
            }
        }
        Figure {
            name: name.into(),
            title: title.into(),
            words: words.into(),
            svg: svg.finish(),
            legend: self.legend(),
            alone: Some(alone.finish()),
        }
    }

    /// Entries of a legend in rows: where each begins, and which series it is of.
    fn legend_rows(&self, width: f64) -> Vec<Vec<(f64, usize)>> {
        let (mut rows, mut x) = (vec![Vec::new()], LEGEND);
        for (index, series) in self.series.iter().enumerate() {
            let wide = 44.0 + 7.0 * self.named(index, series).chars().count() as f64;
            if x > LEGEND && x + wide > width - 20.0 {
                rows.push(Vec::new());
                x = LEGEND;
            }
            if let Some(row) = rows.last_mut() {
                row.push((x, index));
            }
            x += wide;
        }
        rows
    }

    fn legend_entry(&self, svg: &mut Svg, (x, y): (f64, f64), index: usize) {
        let series = &self.series[index];
        let mut mark = String::new();
        match series.mark {
            Mark::Bars => {
                svg.path(&format!("M{x:.1} {y:.1}v-9h22v9z"), &bars_class(index));
            }
            Mark::Crosses => {
                let (left, up, down) = (x + 8.0, y - 8.0, y - 2.0);
                let cross = format!("M{left:.1} {up:.1}l6 6M{left:.1} {down:.1}l6 -6");
                svg.path(&cross, "cross");
            }
            _ => {
                if is_joined(series.mark) {
                    let class = format!("series {}", colour(index));
                    svg.line((x, y - 5.0), (x + 22.0, y - 5.0), &class);
                }
                dot(&mut mark, (x + 11.0, y - 5.0));
                if series.mark != Mark::Line {
                    svg.path(&mark, &dots_class(series, index));
                }
            }
        }
        svg.text((x + 28.0, y - 1.0), "tick", &self.named(index, series));
    }

    /// A series as a legend says it: one of a single point has its number, as colours repeat.
    fn named(&self, index: usize, series: &Series) -> String {
        match series.points.len() {
            1 if self.series.len() > 1 => format!("{} {}", index + 1, series.name),
            _ => series.name.clone(),
        }
    }

    /// Draws axes and series. A series of one point carries its number in the legend, as colours repeat.
    pub fn draw(&self, svg: &mut Svg, area: Area) {
        let shown = |p: &&(f64, f64)| self.x.can_show(p.0) && self.y.can_show(p.1);
        let all = || self.series.iter().flat_map(|s| &s.points).filter(shown);
        let mut frame = Frame {
            left: area.at.0,
            top: area.at.1,
            width: area.size.0,
            height: area.size.1,
            x: self.x.scale(all().map(|p| p.0)),
            y: self.y.scale(all().map(|p| p.1)),
        };
        if self.x.plane {
            let ends = |values: &mut dyn Iterator<Item = f64>| {
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                    (low.min(v), high.max(v))
                })
            };
            let (left, right) = ends(&mut all().map(|p| p.0));
            let (lower, upper) = ends(&mut all().map(|p| p.1));
            if left <= right {
                // So much room that no mark is cut.
                let rim = 0.06 * (right - left).max(upper - lower).max(1.0);
                frame.equal((left - rim, lower - rim), (right + rim, upper + rim));
            }
        }
        frame.x_axis(svg, self.x.label);
        frame.y_axis(svg, self.y.label);
        frame.frame(svg);
        for (i, series) in self.series.iter().enumerate() {
            let (mut line, mut dots, mut crosses) = (String::new(), String::new(), String::new());
            let mut bars = String::new();
            let base = frame.top + frame.height;
            let steps = series.points.windows(2);
            let wide = steps.map(|w| frame.px(w[1].0) - frame.px(w[0].0));
            let wide = wide.fold(f64::INFINITY, f64::min).clamp(2.0, 60.0) - 1.0;
            for &point in series.points.iter().filter(shown) {
                let (x, y) = frame.at(point);
                svg::line(&mut line, (x, y));
                let (left, up, down) = (x - 3.0, y - 3.0, y + 3.0);
                let _ = write!(crosses, "M{left:.1} {up:.1}l6 6M{left:.1} {down:.1}l6 -6");
                dot(&mut dots, (x, y));
                let left = x - wide / 2.0;
                let _ = write!(bars, "M{left:.1} {base:.1}V{y:.1}h{wide:.1}V{base:.1}z");
                if series.points.len() == 1 && self.series.len() > 1 {
                    svg.text((x + 7.0, y + 4.0), "label", &(i + 1).to_string());
                }
            }
            if is_joined(series.mark) {
                svg.path(&line, &format!("series {}", colour(i)));
            }
            match series.mark {
                Mark::Line => {}
                Mark::Bars => svg.path(&bars, &bars_class(i)),
                Mark::Crosses => svg.path(&crosses, "cross"),
                _ => svg.path(&dots, &dots_class(series, i)),
            }
        }
    }

    /// Meanings of the colours, as HTML.
    pub fn legend(&self) -> String {
        let mut out = String::from("<div class=\"legend\">");
        for (i, series) in self.series.iter().enumerate() {
            let line = format!(
                "<line class=\"series {}\" x1=\"1\" y1=\"6\" x2=\"25\" y2=\"6\"/>",
                colour(i)
            );
            let dots = format!("<path class=\"{}\" d=\"M13 6h0\"/>", dots_class(series, i));
            let drawn = match series.mark {
                Mark::Line => line,
                Mark::Ours | Mark::Swept => line + &dots,
                Mark::Scatter | Mark::Places => dots,
                Mark::Bars => format!("<path class=\"{}\" d=\"M3 11v-9h20v9z\"/>", bars_class(i)),
                Mark::Crosses => "<path class=\"cross\" d=\"M9 2l8 8M9 10l8 -8\"/>".to_owned(),
            };
            key(&mut out, &drawn, &self.named(i, series));
        }
        out.push_str("</div>");
        out
    }
}

/// Returns true if a mark's points are joined.
const fn is_joined(mark: Mark) -> bool {
    matches!(mark, Mark::Ours | Mark::Swept | Mark::Line)
}

/// Bars in the colour of series `i`, hollow: those of two series may stand in one place.
fn bars_class(i: usize) -> String {
    format!("series {}", colour(i))
}

/// The colour of series `i`; from the ninth on they repeat.
fn colour(i: usize) -> String {
    format!("w{}", i % COLOURS)
}

/// Class of a series' dots: the program's own points stand out, and so does one that would be lost as a single small
/// dot.
fn dots_class(series: &Series, i: usize) -> String {
    let size = match series.mark {
        Mark::Ours | Mark::Places => "dots big",
        _ if series.points.len() == 1 => "dots big",
        _ => "dots",
    };
    format!("{size} {}", colour(i))
}
