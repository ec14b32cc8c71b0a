//! What only an emulated finger tells: how warm it was over time, and what was left of every limit.

use super::scale::Scale;
use super::series::{LEFT, RIGHT, WIDTH};
use super::svg::{Plot, Svg, envelope, escape};
use serde::Serialize;
use std::fmt::Write;

/// A limit, the worst that came, and what was left.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Margin {
    /// What is limited.
    pub name: &'static str,
    /// The worst of the run, in `unit`.
    pub worst: f64,
    /// The limit in force, in `unit`.
    pub limit: f64,
    /// Unit; empty for a plain number.
    pub unit: &'static str,
    /// What was left, in `unit`; negative beyond the limit.
    pub margin: f64,
    /// Part of the limit that was used, counted from rest; above 1 beyond it.
    pub used: f64,
}

impl Margin {
    /// A value and its limit; `rest` is what the value is when nothing happens.
    pub fn new(name: &'static str, worst: f64, limit: f64, unit: &'static str, rest: f64) -> Self {
        Self {
            name,
            worst,
            limit,
            unit,
            margin: limit - worst,
            used: (worst - rest) / (limit - rest),
        }
    }

    /// Whether the limit was passed.
    pub fn over(&self) -> bool {
        self.worst > self.limit
    }
}

/// The finger at one instant; each temperature is the highest since the instant before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Warmth {
    /// When, s.
    pub t_s: f64,
    /// Hottest wire, degrees C.
    pub wire_c: f64,
    /// Hottest skin at 0.1 mm, degrees C.
    pub shallow_c: f64,
    /// Hottest skin at 0.4 mm, degrees C.
    pub deep_c: f64,
    /// Mean of the skin at 0.1 mm over ten seconds, degrees C.
    pub mean_c: f64,
}

/// Limits of the skin's temperature, degrees C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkinLimits {
    /// At 0.1 mm at any time.
    pub peak_c: f64,
    /// At 0.1 mm as a mean over ten seconds.
    pub mean_c: f64,
    /// At 0.4 mm at any time.
    pub deep_c: f64,
}

/// Everything this section shows.
#[derive(Clone, Copy, Debug)]
pub struct Thermal<'a> {
    /// Over time.
    pub samples: &'a [Warmth],
    /// Most used up first.
    pub margins: &'a [Margin],
    /// The skin's limits.
    pub limits: SkinLimits,
}

/// The section: margins beside each other, temperatures against their limits.
pub(super) fn section(page: &mut String, thermal: &Thermal<'_>) {
    page.push_str(
        "<section><h2>Margins</h2><p class=\"sub\">Measured behind the guard: currents that flowed and \
         temperatures that the model of wire and finger reached. The most used up comes first; temperatures \
         count from 33 \u{b0}C.</p><table><tr><th>limit</th><th class=\"num\">worst</th>\
         <th class=\"num\">limit</th><th class=\"num\">left</th><th>used</th></tr>\n",
    );
    for m in thermal.margins {
        let percent = (m.used * 100.0).clamp(0.0, 1e6);
        let unit = if m.unit == "C" { "\u{b0}C" } else { m.unit };
        let _ = writeln!(
            page,
            "<tr{}><td>{}</td><td class=\"num\">{} {unit}</td><td class=\"num\">{} {unit}</td>\
             <td class=\"num\">{} {}</td><td><span class=\"meter\"><i style=\"width:{:.0}%\"></i></span>{percent:.0}\u{a0}%</td></tr>",
            if m.over() { " class=\"over\"" } else { "" },
            escape(m.name),
            number(m.worst),
            number(m.limit),
            number(m.margin),
            if m.unit == "C" { "K" } else { m.unit },
            percent.min(100.0),
        );
    }
    page.push_str("</table></section>\n");
    if thermal.samples.len() > 1 {
        let _ = writeln!(
            page,
            "<section><h2>Temperatures against their limits</h2><p class=\"sub\">Each point is the highest since the \
             one before, of all wires; the mean is over ten seconds. A wire has no limit of its own.</p>\n\
             <div class=\"wide\">{}</div><div class=\"wide\">{}</div>{LEGEND}</section>",
            skin(thermal),
            wire(thermal)
        );
    }
}

const LEGEND: &str = "<div class=\"legend\">\
    <span><svg viewBox=\"0 0 26 12\"><line class=\"series w1\" x1=\"1\" y1=\"6\" x2=\"25\" y2=\"6\"/></svg>skin at 0.1 mm</span>\
    <span><svg viewBox=\"0 0 26 12\"><line class=\"series w4\" x1=\"1\" y1=\"6\" x2=\"25\" y2=\"6\"/></svg>its mean over 10 s</span>\
    <span><svg viewBox=\"0 0 26 12\"><line class=\"series w2\" x1=\"1\" y1=\"6\" x2=\"25\" y2=\"6\"/></svg>skin at 0.4 mm</span>\
    <span><svg viewBox=\"0 0 26 12\"><line class=\"bound\" x1=\"1\" y1=\"6\" x2=\"25\" y2=\"6\"/></svg>limit</span>\
    <span><svg viewBox=\"0 0 26 12\"><line class=\"series w0\" x1=\"1\" y1=\"6\" x2=\"25\" y2=\"6\"/></svg>hottest wire</span></div>";

/// Three digits or so, whatever the size.
fn number(v: f64) -> String {
    match v.abs() {
        a if !a.is_finite() => "\u{2013}".into(),
        a if a >= 100.0 => format!("{v:.0}"),
        a if a >= 1.0 => format!("{v:.1}"),
        a if a >= 0.001 || a == 0.0 => format!("{v:.3}"),
        _ => format!("{v:.1e}"),
    }
}

fn plot(height: f64, samples: &[Warmth], low: f64, high: f64) -> Plot {
    let last = samples.last().map_or(1.0, |s| s.t_s);
    Plot {
        left: LEFT,
        top: 30.0,
        width: WIDTH - LEFT - RIGHT,
        height,
        x: Scale::exact(0.0, last),
        y: Scale::round(low, high),
    }
}

fn skin(thermal: &Thermal<'_>) -> String {
    type Of = fn(&Warmth) -> f64;
    let lines: [(Of, &str); 3] = [
        (|s| s.shallow_c, "w1"),
        (|s| s.mean_c, "w4"),
        (|s| s.deep_c, "w2"),
    ];
    let (samples, limits) = (thermal.samples, thermal.limits);
    let all = samples.iter().flat_map(|s| lines.map(|(of, _)| of(s)));
    let (low, high) = all.fold((33.0_f64, limits.peak_c), |(l, h), v| (l.min(v), h.max(v)));
    let plot = plot(230.0, samples, low, high + 0.5);
    let mut svg = Svg::new(
        WIDTH,
        300.0,
        "Skin temperatures and their limits against time",
    );
    plot.y_axis(&mut svg, "skin [\u{b0}C]");
    plot.x_axis(&mut svg, "");
    let right = plot.left + plot.width;
    let mut bound = |celsius: f64, what: &str| {
        let y = plot.py(celsius);
        svg.line((plot.left, y), (right, y), "bound");
        svg.text((right + 6.0, y + 4.0), "tick", what);
    };
    bound(limits.peak_c, "0.1 mm");
    if (limits.mean_c - limits.deep_c).abs() < 0.05 {
        bound(limits.mean_c, "mean, 0.4 mm");
    } else {
        bound(limits.mean_c, "mean");
        bound(limits.deep_c, "0.4 mm");
    }
    for (of, class) in lines {
        let points = samples.iter().map(|s| plot.at((s.t_s, of(s))));
        svg.path(&envelope(points), &format!("series {class}"));
    }
    plot.frame(&mut svg);
    svg.finish()
}

fn wire(thermal: &Thermal<'_>) -> String {
    let samples = thermal.samples;
    let all = samples.iter().map(|s| s.wire_c);
    let (low, high) = all.fold((33.0_f64, 34.0_f64), |(l, h), v| (l.min(v), h.max(v)));
    let plot = plot(130.0, samples, low, high);
    let mut svg = Svg::new(WIDTH, 206.0, "Hottest wire against time");
    plot.y_axis(&mut svg, "hottest wire [\u{b0}C]");
    plot.x_axis(&mut svg, "time [s]");
    let points = samples.iter().map(|s| plot.at((s.t_s, s.wire_c)));
    svg.path(&envelope(points), "series w0");
    plot.frame(&mut svg);
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn margins_count_from_rest_and_the_page_takes_anything() {
        let skin = Margin::new("skin", 38.0, 43.0, "C", 33.0);
        assert!((skin.used - 0.5).abs() < 1e-12 && (skin.margin - 5.0).abs() < 1e-12);
        assert!(!skin.over() && Margin::new("x", 2.0, 1.0, "", 0.0).over());
        let odd = Warmth {
            t_s: 1.0,
            wire_c: f64::NAN,
            shallow_c: 1e6,
            deep_c: f64::INFINITY,
            mean_c: -40.0,
        };
        let mut page = String::new();
        let thermal = Thermal {
            samples: &[odd, odd],
            margins: &[skin, Margin::new("<b>", f64::NEG_INFINITY, 1.0, "A", 0.0)],
            limits: SkinLimits {
                peak_c: 43.0,
                mean_c: 41.0,
                deep_c: 41.0,
            },
        };
        section(&mut page, &thermal);
        assert!(page.contains("&lt;b&gt;") && !page.contains("NaN") && !page.contains("inf\""));
        assert_eq!(
            page.matches("<section>").count(),
            page.matches("</section>").count()
        );
    }
}
