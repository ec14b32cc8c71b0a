//! Panels of the thesis's figures on the page of `hil reproduce`.

use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{Plot, Svg, dot, line};

/// Width and height of a panel, pixels.
const SIZE: (f64, f64) = (430.0, 300.0);
/// Room beside the plot for the axes' numbers, and at its right for names.
const MARGINS: (f64, f64) = (64.0, 90.0);

/// Values with the names of their axes.
pub(super) struct Panel<'a> {
    /// Words for those who hear the drawing.
    pub title: &'a str,
    /// Labels to the right and upwards.
    pub axes: [&'a str; 2],
    /// Ends of both scales; without, they follow the values.
    pub up: Option<(f64, f64)>,
}

impl Panel<'_> {
    fn plot(&self, svg: &mut Svg, points: &[(f64, f64)]) -> Plot {
        let ends = |of: fn(&(f64, f64)) -> f64| {
            let each = points.iter().map(of);
            each.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            })
        };
        let scale = |(low, high)| Scale::round(low, high);
        let plot = Plot {
            left: MARGINS.0,
            top: 34.0,
            width: SIZE.0 - MARGINS.0 - MARGINS.1,
            height: SIZE.1 - 90.0,
            x: scale(ends(|p| p.0)),
            y: scale(self.up.unwrap_or_else(|| ends(|p| p.1))),
        };
        plot.x_axis(svg, self.axes[0]);
        plot.y_axis(svg, self.axes[1]);
        plot.frame(svg);
        plot
    }

    /// Places with their names.
    pub fn places(&self, named: &[(&str, f64, f64)]) -> String {
        let mut svg = Svg::new(SIZE.0, SIZE.1, self.title);
        let points: Vec<(f64, f64)> = named.iter().map(|(_, x, y)| (*x, *y)).collect();
        let plot = self.plot(&mut svg, &points);
        for (i, (name, x, y)) in named.iter().enumerate() {
            let at = plot.at((*x, *y));
            let mut mark = String::new();
            dot(&mut mark, at);
            svg.path(&mark, &format!("dots big w{}", i % 8));
            svg.text((at.0 + 7.0, at.1 + 4.0), "tick", name);
        }
        svg.finish()
    }

    /// A line through points.
    pub fn line(&self, points: &[(f64, f64)]) -> String {
        let mut svg = Svg::new(SIZE.0, SIZE.1, self.title);
        let plot = self.plot(&mut svg, points);
        let mut path = String::new();
        points.iter().for_each(|p| line(&mut path, plot.at(*p)));
        svg.path(&path, "series w0");
        svg.finish()
    }
}
