//! One page with the figures of a study: per participant and over all. Self-contained, for a browser or a printer.

use std::fmt::Write as _;

use palpate_study::{Analysis, Comparison, OfWire, OneDrawing, Participant, Rated, Within, fitted};

const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#1a1d21;--soft:#5b6570;--line:#c9d0d8;--card:#fff;--page:#f4f6f8;--a:#0b6bcb;--b:#c2410c}\
@media(prefers-color-scheme:dark){:root{--ink:#e8ecf0;--soft:#9aa5b1;--line:#3a424b;--card:#1b2026;--page:#111418;--a:#6cb4ff;--b:#ff9d66}}\
body{margin:0;background:var(--page);color:var(--ink);font:16px/1.5 system-ui,sans-serif}\
main{max-width:70rem;margin:0 auto;padding:1.5rem}h1{margin:0 0 .2rem}h2{margin:2rem 0 .5rem}h3{margin:1.2rem 0 .3rem}\
section{background:var(--card);border:1px solid var(--line);border-radius:10px;padding:1rem 1.2rem;margin:1rem 0}\
table{border-collapse:collapse}th,td{padding:.25rem .7rem;text-align:right;border-bottom:1px solid var(--line)}td{white-space:nowrap}th:first-child,td:first-child{text-align:left;white-space:normal}\
.scroll{overflow-x:auto}.row{display:flex;flex-wrap:wrap;gap:1rem}figure{margin:0}figcaption{color:var(--soft);font-size:.85rem}\
.soft{color:var(--soft)}svg text{fill:var(--soft);font:11px system-ui,sans-serif}.flag{border-left:5px solid var(--b);padding:.3rem .8rem}";

/// A text in HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

fn within(of: Option<&Within>, digits: usize, unit: &str) -> String {
    of.map_or_else(
        || "–".into(),
        |w| {
            format!(
                "{:.digits$} [{:.digits$}, {:.digits$}]{unit}",
                w.value, w.low, w.high
            )
        },
    )
}

/// From numbers to places in a picture.
struct Frame {
    x: (f64, f64),
    y: (f64, f64),
    width: f64,
    height: f64,
}

impl Frame {
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let part = |v: f64, (low, high): (f64, f64)| (v - low) / (high - low).max(1e-9);
        let (x, y) = (part(x, self.x), part(y, self.y));
        (
            36.0 + x * (self.width - 46.0),
            8.0 + (1.0 - y) * (self.height - 34.0),
        )
    }

    fn line(&self, points: impl Iterator<Item = (f64, f64)>, style: &str) -> String {
        let places: Vec<String> = points
            .map(|(x, y)| self.at(x, y))
            .map(|(x, y)| format!("{x:.1},{y:.1}"))
            .collect();
        format!(
            "<polyline points=\"{}\" fill=\"none\" {style}/>",
            places.join(" ")
        )
    }

    /// The picture with its axes' ends and title.
    fn svg(&self, title: &str, unit: &str, inside: &str) -> String {
        let (w, h) = (self.width, self.height);
        let (left, bottom) = self.at(self.x.0, self.y.0);
        let (right, top) = self.at(self.x.1, self.y.1);
        let title = escaped(title);
        format!(
            "<svg viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" role=\"img\" aria-label=\"{title}\">\
             <path d=\"M{left:.1} {top:.1}V{bottom:.1}H{right:.1}\" fill=\"none\" stroke=\"var(--line)\"/>{inside}\
             <text x=\"{left:.1}\" y=\"{ty:.1}\">{:.0}</text><text x=\"{right:.1}\" y=\"{ty:.1}\" text-anchor=\"end\">{:.0} {unit}</text>\
             <text x=\"2\" y=\"{bottom:.1}\">{:.1}</text><text x=\"2\" y=\"{yt:.1}\">{:.1}</text></svg>",
            self.x.0,
            self.x.1,
            self.y.0,
            self.y.1,
            ty = bottom + 16.0,
            yt = top + 9.0,
        )
    }
}

/// Answers by level, the function through them, and the threshold with its interval.
fn psychometric(of: &OfWire, guess: f64, unit: &str) -> String {
    let levels = of.levels.iter().map(|(level, ..)| *level);
    let low = levels.clone().fold(f64::INFINITY, f64::min) - 2.0;
    let high = levels.fold(f64::NEG_INFINITY, f64::max) + 2.0;
    let frame = Frame {
        x: (low, high),
        y: (0.0, 1.0),
        width: 260.0,
        height: 170.0,
    };
    let function = fitted(of, guess);
    let steps = (0..=60).map(|n| low + (high - low) * f64::from(n) / 60.0);
    let mut inside = frame.line(
        steps.map(|x| (x, function.correct(x))),
        "stroke=\"var(--a)\" stroke-width=\"2\"",
    );
    let e = of.estimate;
    let (l, y) = frame.at(e.low.max(low), 0.03);
    let (r, _) = frame.at(e.high.min(high), 0.03);
    let (m, _) = frame.at(e.value, 0.03);
    // Writing to a text does not fail.
    let _ = write!(
        inside,
        "<path d=\"M{l:.1} {y:.1}H{r:.1}\" stroke=\"var(--b)\" stroke-width=\"3\"/><circle cx=\"{m:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"var(--b)\"/>"
    );
    for (level, yes, all) in &of.levels {
        let (x, y) = frame.at(*level, f64::from(*yes) / f64::from((*all).max(1)));
        let r = 1.5 + 1.2 * f64::from(*all).sqrt();
        let _ = write!(
            inside,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r:.1}\" fill=\"var(--ink)\" fill-opacity=\".55\"><title>{level} dB: {yes} of {all}</title></circle>"
        );
    }
    let words = format!(
        "wire {}: {:.1} dB [{:.1}, {:.1}]",
        of.wire, e.value, e.low, e.high
    );
    format!(
        "<figure>{}<figcaption>{words}</figcaption></figure>",
        frame.svg(&words, unit, &inside)
    )
}

fn drawing(of: &OneDrawing) -> String {
    let all = of.path.iter().map(|[_, x, y]| [*x, *y]);
    let all = all.chain(of.strokes.iter().flatten().copied());
    let most = all
        .flat_map(|[x, y]| [x.abs(), y.abs()])
        .fold(5.0, f64::max)
        + 1.0;
    let frame = Frame {
        x: (-most, most),
        y: (-most, most),
        width: 190.0,
        height: 178.0,
    };
    let path = of.path.iter().map(|[_, x, y]| (*x, *y));
    let mut inside = frame.line(path, "stroke=\"var(--a)\" stroke-width=\"2\"");
    for stroke in &of.strokes {
        let points = stroke.iter().map(|[x, y]| (*x, *y));
        inside += &frame.line(points, "stroke=\"var(--b)\" stroke-width=\"1.5\"");
    }
    let e = &of.error;
    let words = format!(
        "{}: RMSE {:.1} mm, Fréchet {:.1} mm, {} breaks",
        of.condition, e.rmse_mm, e.frechet_mm, e.breaks
    );
    format!(
        "<figure>{}<figcaption>{}</figcaption></figure>",
        frame.svg(&words, "mm", &inside),
        escaped(&words)
    )
}

fn ratings(rated: &[Rated], scale: &str) -> String {
    let ours: Vec<&Rated> = rated.iter().filter(|r| r.scale == scale).collect();
    let count = ours.len() as f64;
    let frame = Frame {
        x: (0.0, count.max(1.0)),
        y: (1.0, 6.0),
        width: (90.0 * count + 50.0).max(200.0),
        height: 220.0,
    };
    let mut inside = String::new();
    for (index, of) in ours.iter().enumerate() {
        let middle = index as f64 + 0.5;
        for (number, value) in of.values.iter().enumerate() {
            let off = (number % 7) as f64 * 0.04 - 0.12;
            let (x, y) = frame.at(middle + off, *value);
            let _ = write!(
                inside,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"var(--a)\" fill-opacity=\".5\"/>"
            );
        }
        if let Some(median) = &of.median {
            let (x, y) = frame.at(middle, median.value);
            let ((_, low), (_, high)) =
                (frame.at(middle, median.low), frame.at(middle, median.high));
            let _ = write!(
                inside,
                "<path d=\"M{:.1} {y:.1}H{:.1}M{x:.1} {low:.1}V{high:.1}\" stroke=\"var(--b)\" stroke-width=\"3\"/>",
                x - 16.0,
                x + 16.0
            );
        }
        let (x, y) = frame.at(middle, 1.0);
        let _ = write!(
            inside,
            "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            y + 16.0,
            escaped(&of.condition)
        );
    }
    // Its axis has names in place of numbers.
    let (w, h) = (frame.width, frame.height);
    let (left, bottom) = frame.at(0.0, 1.0);
    let (_, top) = frame.at(0.0, 6.0);
    format!(
        "<figure><svg viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\" role=\"img\" aria-label=\"{}\"><path d=\"M{left:.1} {top:.1}V{bottom:.1}H{:.1}\" fill=\"none\" stroke=\"var(--line)\"/>{inside}<text x=\"8\" y=\"{bottom:.1}\">1</text><text x=\"8\" y=\"{:.1}\">6</text></svg><figcaption>{}: each person's mean, medians with 95 % intervals</figcaption></figure>",
        escaped(scale),
        w - 10.0,
        top + 9.0,
        escaped(scale)
    )
}

fn table(head: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let head: String = head.iter().map(|h| format!("<th>{h}</th>")).collect();
    let rows: String = rows
        .map(|row| {
            row.iter()
                .map(|c| format!("<td>{}</td>", escaped(c)))
                .collect::<String>()
        })
        .map(|row| format!("<tr>{row}</tr>"))
        .collect();
    format!("<div class=\"scroll\" tabindex=\"0\"><table><tr>{head}</tr>{rows}</table></div>")
}

fn comparison(of: &Comparison) -> Vec<String> {
    vec![
        format!("{}: {} against {}", of.of, of.second, of.first),
        format!("{} and {}", of.counts[0], of.counts[1]),
        format!("{:.2} and {:.2}", of.medians[0], of.medians[1]),
        within(Some(&of.difference), 2, ""),
        format!("{:.1}", of.u),
        format!("{:.4}", of.p),
        within(Some(&of.effect), 2, ""),
    ]
}

fn over_all(of: &Analysis) -> String {
    let mut out = String::new();
    let mut scales: Vec<&str> = of.ratings.iter().map(|r| r.scale.as_str()).collect();
    scales.dedup();
    if !scales.is_empty() {
        let figures: String = scales
            .iter()
            .map(|scale| ratings(&of.ratings, scale))
            .collect();
        let _ = write!(
            out,
            "<section><h2>Ratings</h2><div class=\"row scroll\" tabindex=\"0\">{figures}</div>"
        );
        if !of.comparisons.is_empty() {
            let head = [
                "comparison",
                "people",
                "medians",
                "difference [95 %]",
                "U",
                "p",
                "effect r [95 %]",
            ];
            out += &table(&head, of.comparisons.iter().map(comparison));
            out += "<p class=\"soft\">Mann and Whitney's U, two-sided, normal approximation; r is the rank-biserial correlation; intervals by bootstrap over people.</p>";
        }
        out += "</section>";
    }
    if !of.drawings.is_empty() {
        out += "<section><h2>Paths that were felt</h2>";
        let rows = of.drawings.iter().map(|d| {
            vec![
                d.condition.clone(),
                d.drawings.to_string(),
                within(d.rmse_mm.as_ref(), 2, ""),
                within(d.frechet_mm.as_ref(), 2, ""),
                format!("{:.2}", d.breaks),
            ]
        });
        out += &table(
            &[
                "condition",
                "drawings",
                "RMSE, mm [95 %]",
                "Fréchet, mm [95 %]",
                "breaks per drawing",
            ],
            rows,
        );
        out += "<p class=\"soft\">Medians of each person's median. RMSE after the drawing's time was stretched to the path's and shifted.</p></section>";
    }
    out += &localisation(of);
    out += &choices(of);
    out
}

fn localisation(of: &Analysis) -> String {
    let mut out = String::new();
    if let Some(off) = &of.localisation_mm {
        let _ = write!(
            out,
            "<section><h2>Where it was felt</h2><p>Median distance from the wire: {}</p>",
            within(Some(off), 1, " mm")
        );
        let wires: Vec<String> = (0..of.confusion.len())
            .map(|w| format!("taken for {w}"))
            .collect();
        let head: Vec<&str> = ["wire"]
            .into_iter()
            .chain(wires.iter().map(String::as_str))
            .collect();
        let rows = of.confusion.iter().enumerate().map(|(wire, row)| {
            let counts = row.iter().map(u32::to_string);
            [wire.to_string()].into_iter().chain(counts).collect()
        });
        out += &table(&head, rows);
        out += "</section>";
    }
    out
}

fn choices(of: &Analysis) -> String {
    let mut out = String::new();
    if !of.choices.is_empty() {
        out += "<section><h2>Which of two</h2>";
        let rows = of.choices.iter().map(|c| {
            vec![
                format!("{} over {}", c.pair[1], c.pair[0]),
                within(c.part.as_ref(), 2, ""),
                format!("{} to {}", c.people[0], c.people[1]),
                format!("{:.4}", c.p),
            ]
        });
        out += &table(
            &["pair", "part of answers [95 %]", "people", "p, sign test"],
            rows,
        );
        out += "</section>";
    }
    out
}

fn participant(of: &Participant) -> String {
    let mut out = format!(
        "<section><h2>Participant {}</h2><p class=\"soft\">{} trials that count, {} void{}{}</p>",
        of.number,
        of.trials,
        of.void,
        if of.complete { "" } else { "; not over" },
        of.answers
            .iter()
            .map(|(name, answer)| format!("; {}: {}", escaped(name), escaped(answer)))
            .collect::<String>()
    );
    for (title, found, guess, unit) in [
        (
            "Absolute thresholds",
            &of.thresholds,
            0.5,
            "dB of full drive",
        ),
        (
            "Least differences",
            &of.differences,
            0.5,
            "dB of the amplitude",
        ),
        (
            "Levels that feel alike",
            &of.matches,
            0.02,
            "dB of full drive",
        ),
    ] {
        if !found.is_empty() {
            let figures: String = found
                .iter()
                .map(|wire| psychometric(wire, guess, unit))
                .collect();
            let _ = write!(out, "<h3>{title}</h3><div class=\"row\">{figures}</div>");
        }
    }
    if !of.drawings.is_empty() {
        let figures: String = of.drawings.iter().map(drawing).collect();
        let _ = write!(out, "<h3>Drawings</h3><div class=\"row\">{figures}</div>");
    }
    out += "</section>";
    out
}

/// The page of a study.
#[must_use]
pub fn page(of: &Analysis) -> String {
    let flag = match of.simulated {
        true => "<p class=\"flag\">Simulated people answered: no person has felt this.</p>",
        false => "",
    };
    let people: String = of.participants.iter().map(participant).collect();
    let name = escaped(&of.protocol);
    format!(
        "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>Palpate: study {name}</title><style>{STYLE}</style><main><h1>Study {name}</h1><p class=\"soft\">{} participants. Blue is what was played or fitted, orange what was felt, with 95 % intervals.</p>{flag}{}{people}</main></html>\n",
        of.participants.len(),
        over_all(of)
    )
}
