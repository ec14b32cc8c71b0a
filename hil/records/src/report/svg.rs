//! A small SVG writer: shapes by style class, and a frame with labelled axes.
//!
//! Our own, because a page that follows the reader's light or dark setting needs classes where chart
//! libraries write colours.

use super::scale::Scale;
use std::fmt::Write;

/// The style sheet of pages and drawings, light and dark.
pub(super) const STYLE: &str = include_str!("style.css");

/// Text with everything replaced that means something to HTML, or that XML forbids.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c if c.is_control() => out.push(' '),
            '\u{FFFE}' | '\u{FFFF}' => out.push(char::REPLACEMENT_CHARACTER),
            c => out.push(c),
        }
    }
    out
}

/// A drawing under construction.
pub struct Svg {
    body: String,
}

impl Svg {
    /// An empty drawing of this size in pixels; the label is for those who hear it.
    pub fn new(width: f64, height: f64, label: &str) -> Self {
        let label = escape(label);
        let body = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             role=\"img\" aria-label=\"{label}\">\n"
        );
        Self { body }
    }

    /// A straight line.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64), class: &str) {
        let _ = writeln!(
            self.body,
            "<line class=\"{class}\" x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\"/>",
            from.0, from.1, to.0, to.1
        );
    }

    /// A rectangle by its upper left corner and its size.
    pub fn rect(&mut self, at: (f64, f64), size: (f64, f64), class: &str) {
        let _ = writeln!(
            self.body,
            "<rect class=\"{class}\" x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>",
            at.0,
            at.1,
            size.0.max(0.0),
            size.1.max(0.0)
        );
    }

    /// A circle about a point.
    pub fn circle(&mut self, at: (f64, f64), radius: f64, class: &str) {
        let _ = writeln!(
            self.body,
            "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius:.1}\"/>",
            at.0, at.1
        );
    }

    /// A path in SVG's own notation; nothing for an empty one.
    pub fn path(&mut self, data: &str, class: &str) {
        if !data.is_empty() {
            let _ = writeln!(self.body, "<path class=\"{class}\" d=\"{data}\"/>");
        }
    }

    /// Text anchored by its class: `end`, `middle` or, without either, its start.
    pub fn text(&mut self, at: (f64, f64), class: &str, text: &str) {
        let _ = writeln!(
            self.body,
            "<text class=\"{class}\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            at.0,
            at.1,
            escape(text)
        );
    }

    /// Makes a link of all that is drawn from here on, until [`Svg::close_link`].
    pub fn open_link(&mut self, to: &str) {
        let _ = writeln!(self.body, "<a href=\"{}\">", escape(to));
    }

    /// Ends the link.
    pub fn close_link(&mut self) {
        self.body.push_str("</a>\n");
    }

    /// Gives these words to all that is drawn until [`Svg::close_words`]: they show where the pointer is.
    pub fn open_words(&mut self, words: &str) {
        let _ = writeln!(self.body, "<g><title>{}</title>", escape(words));
    }

    /// Ends what [`Svg::open_words`] began.
    pub fn close_words(&mut self) {
        self.body.push_str("</g>\n");
    }

    /// The drawing as text, for a page that has the style sheet.
    pub fn finish(mut self) -> String {
        self.body.push_str("</svg>\n");
        self.body
    }

    /// The drawing as a file of its own: with the style sheet and further rules.
    pub fn standalone(self, rules: &str) -> String {
        standalone(&self.finish(), rules)
    }
}

/// Makes a file of its own of a drawing that is text, as [`Svg::standalone`] does of one that is not.
pub fn standalone(drawing: &str, rules: &str) -> String {
    let card = "svg{background:var(--card);font-family:system-ui,sans-serif}";
    let style = format!("\n<style>{STYLE}{card}{rules}</style>\n");
    drawing.replacen('\n', &style, 1)
}

/// A rectangle with two scales.
pub struct Plot {
    /// Left edge, pixels.
    pub left: f64,
    /// Upper edge, pixels.
    pub top: f64,
    /// Width, pixels.
    pub width: f64,
    /// Height, pixels.
    pub height: f64,
    /// Scale to the right.
    pub x: Scale,
    /// Scale upwards.
    pub y: Scale,
}

impl Plot {
    /// Pixel of a value along x.
    pub fn px(&self, x: f64) -> f64 {
        self.left + self.x.at(x) * self.width
    }

    /// Pixel of a value along y.
    pub fn py(&self, y: f64) -> f64 {
        self.top + (1.0 - self.y.at(y)) * self.height
    }

    /// Pixels of a point.
    pub fn at(&self, p: (f64, f64)) -> (f64, f64) {
        (self.px(p.0), self.py(p.1))
    }

    /// Scales as large as possible with the same millimetre both ways and `low`..`high` in view.
    pub fn equal(&mut self, low: (f64, f64), high: (f64, f64)) {
        let per_px = ((high.0 - low.0) / self.width)
            .max((high.1 - low.1) / self.height)
            .max(1e-6);
        let (w, h) = (self.width * per_px / 2.0, self.height * per_px / 2.0);
        let (x, y) = ((low.0 + high.0) / 2.0, (low.1 + high.1) / 2.0);
        self.x = Scale::exact(x - w, x + w);
        self.y = Scale::exact(y - h, y + h);
    }

    /// Horizontal axis: grid lines, numbers, label.
    pub fn x_axis(&self, svg: &mut Svg, label: &str) {
        let bottom = self.top + self.height;
        for (value, text) in self.x.ticks((self.width / 75.0).min(10.0)) {
            let x = self.px(value);
            svg.line((x, self.top), (x, bottom), "grid");
            svg.text((x, bottom + 15.0), "tick middle", &text);
        }
        svg.text(
            (self.left + self.width / 2.0, bottom + 33.0),
            "label middle",
            label,
        );
    }

    /// Vertical axis: grid lines, numbers, label above the upper end.
    pub fn y_axis(&self, svg: &mut Svg, label: &str) {
        for (value, text) in self.y.ticks((self.height / 26.0).min(8.0)) {
            let y = self.py(value);
            svg.line((self.left, y), (self.left + self.width, y), "grid");
            svg.text((self.left - 7.0, y + 4.0), "tick end", &text);
        }
        svg.text((self.left - 44.0, self.top - 13.0), "label", label);
    }

    /// The rectangle around the plot.
    pub fn frame(&self, svg: &mut Svg) {
        svg.rect((self.left, self.top), (self.width, self.height), "frame");
    }
}

/// Adds one dot to a path whose style has round ends.
pub fn dot(out: &mut String, (x, y): (f64, f64)) {
    if x.is_finite() && y.is_finite() {
        let _ = write!(out, "M{x:.1} {y:.1}h0");
    }
}

/// Adds the next point to a path of straight lines.
pub fn line(out: &mut String, (x, y): (f64, f64)) {
    let step = if out.is_empty() { 'M' } else { 'L' };
    let _ = write!(out, "{step}{x:.1} {y:.1}");
}

/// A legend's entry: a swatch drawn with the figure's own classes, and its meaning.
pub fn key(out: &mut String, shape: &str, text: &str) {
    let _ = write!(
        out,
        "<span><svg viewBox=\"0 0 26 12\">{shape}</svg>{}</span>",
        escape(text)
    );
}

/// The entry of a line.
pub fn line_key(out: &mut String, class: &str, text: &str) {
    let line = format!("<line class=\"{class}\" x1=\"1\" y1=\"6\" x2=\"25\" y2=\"6\"/>");
    key(out, &line, text);
}

/// The entry of a path, within 26 pixels by 12.
pub fn path_key(out: &mut String, class: &str, data: &str, text: &str) {
    key(
        out,
        &format!("<path class=\"{class}\" d=\"{data}\"/>"),
        text,
    );
}

#[cfg(test)]
#[path = "svg_tests.rs"]
mod tests;
