//! Plots of measurements: work-precision diagrams and warnings.

use palpate_records::report::STYLE;
use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{Plot as Frame, Svg, dot, escape};
use std::fmt::Write;

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
        let shown = self.series.iter().flat_map(|s| &s.points);
        let shown = shown.filter(|p| self.can_show(**p)).map(|p| frame.at(*p));
        let mut names = Names::new(&frame, shown.collect());
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
                svg.path(&dots, &dots_class(series, i));
            }
            // Colours repeat: a method without a course has its name beside it, where there is room.
            if let [point] = series.points.as_slice()
                && self.can_show(*point)
                && let Some(at) = names.place(frame.at(*point), &series.name)
            {
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
                _ => format!("<path class=\"{}\" d=\"M13 6h0\"/>", dots_class(series, i)),
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
            // Room for names above and below.
            (true, true) => Scale::decades(low / MARGIN, high * MARGIN),
            (true, false) => Scale::round(low, high),
            (false, _) => Scale::exact(0.0, 1.0),
        }
    }
}

/// Names beside their dots. All in pixels.
struct Names {
    /// Left, right, top and bottom of the frame.
    frame: [f64; 4],
    dots: Vec<(f64, f64)>,
    /// Left, right, top and bottom of the names that stand.
    taken: Vec<[f64; 4]>,
}

impl Names {
    fn new(frame: &Frame, dots: Vec<(f64, f64)>) -> Self {
        let (left, top) = (frame.left, frame.top);
        Self {
            frame: [left, left + frame.width, top, top + frame.height],
            dots,
            taken: Vec::new(),
        }
    }

    /// Left end and baseline of the name of a dot: right or left of it, or a line or two above or below, where it covers no
    /// name, no dot and no side of the frame; nothing where there is no such place.
    fn place(&mut self, (x, y): (f64, f64), name: &str) -> Option<(f64, f64)> {
        const LINE: f64 = 14.0;
        const ASCENT: f64 = 11.0;
        const DESCENT: f64 = 3.0;
        const ASIDE: f64 = 7.0;
        let width = 7.5 * name.chars().count() as f64;
        let (right, left) = (x + ASIDE, x - ASIDE - width);
        let middle = x - width / 2.0;
        let nearby = [
            (right, 0.0),
            (left, 0.0),
            (middle, -LINE),
            (middle, LINE),
            (right, -LINE),
            (right, LINE),
            (left, -LINE),
            (left, LINE),
            (middle, -2.0 * LINE),
            (middle, 2.0 * LINE),
            (right, -2.0 * LINE),
            (right, 2.0 * LINE),
            (left, -2.0 * LINE),
            (left, 2.0 * LINE),
        ];
        let corners = |(from, down): (f64, f64)| {
            let base = y + 4.0 + down;
            ([from, from + width, base - ASCENT, base + DESCENT], base)
        };
        let (found, base) = nearby
            .map(corners)
            .into_iter()
            .find(|(c, _)| self.free(c))?;
        self.taken.push(found);
        Some((found[0], base))
    }

    fn free(&self, &[left, right, top, bottom]: &[f64; 4]) -> bool {
        const DOT: f64 = 4.0;
        let [l, r, t, b] = self.frame;
        let inside = left > l && right < r && top > t && bottom < b;
        let apart = |&[l, r, t, b]: &[f64; 4]| left > r || l > right || top > b || t > bottom;
        let clear = |&(x, y): &(f64, f64)| apart(&[x - DOT, x + DOT, y - DOT, y + DOT]);
        inside && self.taken.iter().all(apart) && self.dots.iter().all(clear)
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

/// What the program uses, and what would be lost as a single small dot, stand out.
fn dots_class(series: &Series, i: usize) -> String {
    let size = if series.mark == Mark::Ours || series.points.len() == 1 {
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
    fn names_cover_neither_each_other_nor_dots_nor_the_frame() {
        let dots = vec![(100.0, 50.0), (120.0, 52.0), (380.0, 50.0), (200.0, 195.0)];
        let mut names = Names {
            frame: [0.0, 400.0, 0.0, 200.0],
            dots: dots.clone(),
            taken: Vec::new(),
        };
        // A dot to the right: its name goes to the left; the frame's side to the right: the same.
        assert_eq!(names.place(dots[0], "first"), Some((55.5, 54.0)));
        assert_eq!(names.place(dots[1], "second"), Some((127.0, 56.0)));
        assert_eq!(names.place(dots[2], "third"), Some((335.5, 54.0)));
        // At the bottom, above.
        let (_, base) = names.place(dots[3], "bottom").unwrap();
        assert!(base < 195.0);
        // A name longer than the frame has no place.
        assert_eq!(names.place(dots[0], &"x".repeat(60)), None);
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
