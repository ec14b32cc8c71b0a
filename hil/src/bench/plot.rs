//! Plots of measurements: work-precision diagrams and warnings.

use palpate_records::report::STYLE;
use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{Plot as Frame, Svg, dot, escape};
use std::fmt::Write;

const SIZE: (f64, f64) = (860.0, 430.0);
/// Colours of the style sheet.
const COLOURS: usize = 8;

/// How the points of a series are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Large dots, joined: what the program uses.
    Ours,
    /// Dots, joined: tolerances of one method.
    Swept,
    /// A line alone: a quantity over time.
    Line,
    /// Small dots, not joined: places.
    Scatter,
}

/// Points of one name.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// As the legend says it.
    pub name: String,
    /// Points in the axes' units; those that are no numbers are left out.
    pub points: Vec<(f64, f64)>,
    /// How they are drawn.
    pub mark: Mark,
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Decades in place of equal steps.
    pub log: bool,
}

/// A picture with its caption.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Its file's name, after the family's: lower case with hyphens.
    pub name: String,
    /// Its heading.
    pub title: String,
    /// What it shows, in a sentence or two.
    pub words: String,
    /// To the right.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// What is drawn.
    pub series: Vec<Series>,
}

impl Plot {
    /// Error against median run time, both in decades, as work-precision diagrams are drawn.
    pub fn work_precision(name: &str, title: &str, error: &str, series: Vec<Series>) -> Self {
        let axis = |label: &str| Axis {
            label: label.into(),
            log: true,
        };
        Self {
            name: name.into(),
            title: title.into(),
            words: "Further left is faster, further down is more accurate.".into(),
            x: axis("median run time [\u{b5}s]"),
            y: axis(error),
            series,
        }
    }

    /// The drawing as an SVG element that takes its colours from the page.
    pub fn svg(&self) -> String {
        let (width, height) = SIZE;
        let mut svg = Svg::new(width, height, &self.title);
        let frame = Frame {
            left: 64.0,
            top: 30.0,
            width: width - 104.0,
            height: height - 80.0,
            x: self.scale(&self.x, |p| p.0),
            y: self.scale(&self.y, |p| p.1),
        };
        frame.x_axis(&mut svg, &self.x.label);
        frame.y_axis(&mut svg, &self.y.label);
        frame.frame(&mut svg);
        let mut names = Names::default();
        for (i, series) in self.series.iter().enumerate() {
            let (mut line, mut dots) = (String::new(), String::new());
            for &point in series.points.iter().filter(|p| self.can_show(**p)) {
                let (x, y) = frame.at(point);
                let _ = write!(
                    line,
                    "{}{x:.1} {y:.1}",
                    if line.is_empty() { 'M' } else { 'L' }
                );
                dot(&mut dots, (x, y));
            }
            if series.mark != Mark::Scatter {
                svg.path(&line, &format!("series {}", colour(i)));
            }
            if series.mark != Mark::Line {
                svg.path(&dots, &dots_class(series.mark, i));
            }
            // Colours repeat: a method without a course has its name beside it.
            if let [point] = series.points.as_slice()
                && self.can_show(*point)
            {
                let at = names.place(frame.at(*point), &series.name);
                svg.text(at, "label", &series.name);
            }
        }
        svg.finish()
    }

    /// The drawing as a file of its own.
    pub fn file(&self) -> String {
        styled(&self.svg())
    }

    /// What the colours mean, as HTML.
    pub fn legend(&self) -> String {
        let mut out = String::from("<div class=\"legend\">");
        for (i, series) in self.series.iter().enumerate() {
            let dots = match series.mark {
                Mark::Line => String::new(),
                mark => format!("<path class=\"{}\" d=\"M13 6h0\"/>", dots_class(mark, i)),
            };
            let _ = write!(
                out,
                "<span><svg viewBox=\"0 0 26 12\"><line class=\"series {}\" x1=\"1\" y1=\"6\" x2=\"25\" \
                 y2=\"6\"/>{dots}</svg>{}</span>",
                colour(i),
                escape(&series.name)
            );
        }
        out.push_str("</div>");
        out
    }

    fn can_show(&self, (x, y): (f64, f64)) -> bool {
        let fits = |axis: &Axis, v: f64| v.is_finite() && (!axis.log || v > 0.0);
        fits(&self.x, x) && fits(&self.y, y)
    }

    fn scale(&self, axis: &Axis, of: impl Fn(&(f64, f64)) -> f64) -> Scale {
        let points = self.series.iter().flat_map(|s| &s.points);
        let values = points.filter(|p| self.can_show(**p)).map(of);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        match (low <= high, axis.log) {
            (true, true) => Scale::decades(low, high),
            (true, false) => Scale::round(low, high),
            (false, _) => Scale::exact(0.0, 1.0),
        }
    }
}

/// Names beside their dots: left ends, widths and baselines, pixels.
#[derive(Default)]
struct Names(Vec<(f64, f64, f64)>);

impl Names {
    /// Where the name of a dot stands: to its right, and as far below or above as it covers no other name.
    fn place(&mut self, (x, y): (f64, f64), name: &str) -> (f64, f64) {
        const LINE: f64 = 14.0;
        let (left, width) = (x + 7.0, 7.0 * name.chars().count() as f64);
        let free = |base: &f64| {
            let covers = |&(l, w, b): &(f64, f64, f64)| {
                l < left + width && left < l + w && (b - base).abs() < LINE
            };
            !self.0.iter().any(covers)
        };
        let nearby = [
            4.0,
            4.0 + LINE,
            4.0 - LINE,
            4.0 + 2.0 * LINE,
            4.0 - 2.0 * LINE,
        ];
        let base = nearby.map(|down| y + down).into_iter().find(free);
        let base = base.unwrap_or(y + 4.0);
        self.0.push((left, width, base));
        (left, base)
    }
}

/// A drawing with the page's colours inside, to stand as a file of its own.
pub fn styled(svg: &str) -> String {
    let style = format!("<style>{STYLE}svg{{background:var(--card)}}</style>\n<");
    svg.replacen("\n<", &format!("\n{style}"), 1)
}

/// The colour of series `i`; from the ninth on they repeat.
fn colour(i: usize) -> String {
    format!("w{}", i % COLOURS)
}

fn dots_class(mark: Mark, i: usize) -> String {
    let size = if mark == Mark::Ours {
        "dots big"
    } else {
        "dots"
    };
    format!("{size} {}", colour(i))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_cover_each_other() {
        let mut names = Names::default();
        assert_eq!(names.place((100.0, 50.0), "last 10"), (107.0, 54.0));
        assert_eq!(names.place((120.0, 52.0), "last 25"), (127.0, 70.0));
        assert_eq!(names.place((125.0, 52.0), "last 50"), (132.0, 84.0));
        assert_eq!(names.place((300.0, 52.0), "exact"), (307.0, 56.0));
    }

    #[test]
    fn whatever_was_measured_can_be_drawn() {
        let odd = vec![
            (1.0, 1e-9),
            (f64::NAN, 1.0),
            (10.0, 0.0),
            (1e6, f64::INFINITY),
            (1e5, 1e-3),
        ];
        let series = |name: &str, points| Series {
            name: name.into(),
            points,
            mark: Mark::Swept,
        };
        let plot = Plot::work_precision("x", "A <title>", "error [K]", vec![series("a&b", odd)]);
        let svg = plot.svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        assert!(svg.contains("A &lt;title&gt;") && plot.legend().contains("a&amp;b"));
        assert!(plot.file().contains("<style>") && plot.file().ends_with("</svg>\n"));
        let empty = Plot::work_precision("x", "t", "e", vec![series("none", Vec::new())]);
        assert!(!empty.svg().contains("NaN"));
    }
}
