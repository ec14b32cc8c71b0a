//! One page with the figures of a study: per participant and over all. Self-contained, for a browser or a printer.

use std::fmt::Write as _;

use palpate_records::report::page::{self, foot, head, table};
use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{Plot, Svg, dot, escape, line};
use palpate_study::{
    Analysis, Comparison, Estimate, OfWire, OneDrawing, Participant, Rated, fitted,
};

fn within(of: Option<&Estimate>, digits: usize, unit: &str) -> String {
    of.map_or_else(
        || "–".into(),
        |w| match w.low < w.high {
            true => format!(
                "{:.digits$} [{:.digits$}, {:.digits$}]{unit}",
                w.value, w.low, w.high
            ),
            // One person has no interval.
            false => format!("{:.digits$}{unit}", w.value),
        },
    )
}

/// The plot of a small picture: what is left of it beside the numbers of the axes.
fn plot((width, height): (f64, f64), x: Scale, y: Scale) -> Plot {
    Plot {
        left: 50.0,
        top: 28.0,
        width: width - 64.0,
        height: height - 68.0,
        x,
        y,
    }
}

/// A picture as wide as it was drawn, and words below.
fn figure(svg: Svg, width: f64, words: &str) -> String {
    format!(
        "<figure style=\"width:{width:.0}px\">{}<figcaption>{}</figcaption></figure>",
        svg.finish(),
        escape(words)
    )
}

/// A line through places.
fn curve(plot: &Plot, points: impl Iterator<Item = (f64, f64)>) -> String {
    let mut path = String::new();
    points.for_each(|p| line(&mut path, plot.at(p)));
    path
}

/// Answers by level, the function through them, and the threshold with its interval.
fn psychometric(of: &OfWire, guess: f64, unit: &str) -> String {
    const SIZE: (f64, f64) = (270.0, 210.0);
    let levels = of.levels.iter().map(|(level, ..)| *level);
    let low = levels.clone().fold(f64::INFINITY, f64::min) - 2.0;
    let high = levels.fold(f64::NEG_INFINITY, f64::max) + 2.0;
    let e = of.estimate;
    let words = format!(
        "wire {}: {:.1} dB [{:.1}, {:.1}]",
        of.wire, e.value, e.low, e.high
    );
    let plot = plot(SIZE, Scale::exact(low, high), Scale::exact(0.0, 1.0));
    let mut svg = Svg::new(SIZE.0, SIZE.1, &words);
    plot.x_axis(&mut svg, unit);
    plot.y_axis(&mut svg, "part of answers");
    let function = fitted(of, guess);
    let steps = (0..=60).map(|n| low + (high - low) * f64::from(n) / 60.0);
    let fit = curve(&plot, steps.map(|x| (x, function.correct(x))));
    svg.path(&fit, "series w0");
    let ends = [(e.low.max(low), 0.03), (e.high.min(high), 0.03)];
    svg.path(&curve(&plot, ends.into_iter()), "interval w1");
    let mut value = String::new();
    dot(&mut value, plot.at((e.value, 0.03)));
    svg.path(&value, "dots big w1");
    for (level, yes, all) in &of.levels {
        let at = plot.at((*level, f64::from(*yes) / f64::from((*all).max(1))));
        let r = 1.5 + 1.2 * f64::from(*all).sqrt();
        svg.open_words(&format!("{level} dB: {yes} of {all}"));
        svg.circle(at, r, "answers");
        svg.close_words();
    }
    figure(svg, SIZE.0, &words)
}

fn drawing(of: &OneDrawing) -> String {
    const SIZE: (f64, f64) = (210.0, 214.0);
    let all = of.path.iter().map(|[_, x, y]| [*x, *y]);
    let all = all.chain(of.strokes.iter().flatten().copied());
    let most = all
        .flat_map(|[x, y]| [x.abs(), y.abs()])
        .fold(5.0, f64::max)
        + 1.0;
    let e = &of.error;
    let words = format!(
        "{}: RMSE {:.1} mm, Fréchet {:.1} mm, {} breaks",
        of.condition, e.rmse_mm, e.frechet_mm, e.breaks
    );
    let scale = Scale::exact(-most, most);
    let plot = plot(SIZE, scale, scale);
    let mut svg = Svg::new(SIZE.0, SIZE.1, &words);
    plot.x_axis(&mut svg, "x [mm]");
    plot.y_axis(&mut svg, "y [mm]");
    let path = of.path.iter().map(|[_, x, y]| (*x, *y));
    svg.path(&curve(&plot, path), "series w0");
    for stroke in &of.strokes {
        let points = stroke.iter().map(|[x, y]| (*x, *y));
        svg.path(&curve(&plot, points), "series w1");
    }
    figure(svg, SIZE.0, &words)
}

/// Conditions below one another, each with its people's means and their median.
fn ratings(rated: &[Rated], scale: &str) -> String {
    const ROW: f64 = 30.0;
    const WIDTH: f64 = 340.0;
    let ours: Vec<&Rated> = rated.iter().filter(|r| r.scale == scale).collect();
    let count = ours.len() as f64;
    let names = ours.iter().map(|of| of.condition.chars().count());
    let left = (7.0 * names.max().unwrap_or(0) as f64 + 16.0).clamp(40.0, 170.0);
    let plot = Plot {
        left,
        top: 10.0,
        width: WIDTH - left - 12.0,
        height: ROW * count.max(1.0),
        x: Scale::exact(0.8, 6.2),
        y: Scale::exact(0.0, count.max(1.0)),
    };
    let bottom = plot.top + plot.height;
    let mut svg = Svg::new(WIDTH, bottom + 42.0, scale);
    for rating in 1..=6 {
        let x = plot.px(f64::from(rating));
        svg.line((x, plot.top), (x, bottom), "grid");
        svg.text((x, bottom + 15.0), "tick middle", &rating.to_string());
    }
    let middle = (plot.left + plot.width / 2.0, bottom + 33.0);
    svg.text(middle, "label middle", "rating");
    for (index, of) in ours.iter().enumerate() {
        let y = plot.top + ROW * (index as f64 + 0.5);
        for (number, value) in of.values.iter().enumerate() {
            let off = (number % 7) as f64 * 2.0 - 6.0;
            svg.circle((plot.px(*value), y + off), 3.0, "rated");
        }
        if let Some(median) = &of.median {
            let [low, x, high] = [median.low, median.value, median.high].map(|v| plot.px(v));
            let (top, bottom) = (y - 10.0, y + 10.0);
            let cross = format!("M{low:.1} {y:.1}H{high:.1}M{x:.1} {top:.1}V{bottom:.1}");
            svg.path(&cross, "interval w1");
        }
        svg.text((plot.left - 7.0, y + 4.0), "tick end", &of.condition);
    }
    plot.frame(&mut svg);
    let words = format!("{scale}: each person's mean, medians with 95 % intervals");
    figure(svg, WIDTH, &words)
}

/// The first column has words, the others figures.
fn wide(columns: &[&str], rows: impl Iterator<Item = Vec<String>>) -> String {
    let class = |n| if n == 0 { "" } else { "num" };
    let columns: Vec<_> = (0..).map(class).zip(columns.iter().copied()).collect();
    page::wide(&columns, rows.map(|cells| (false, cells)))
}

/// A probability, or why there is none to speak of.
fn certain(nothing: Option<String>, p: f64) -> String {
    nothing.unwrap_or_else(|| format!("{p:.4}"))
}

fn comparison(of: &Comparison) -> Vec<String> {
    vec![
        format!("{}: {} against {}", of.of, of.second, of.first),
        format!("{} and {}", of.counts[0], of.counts[1]),
        format!("{:.2} and {:.2}", of.medians[0], of.medians[1]),
        within(Some(&of.difference), 2, ""),
        format!("{:.1}", of.u),
        certain(of.says_nothing(), of.p),
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
            "<section><h2>Ratings</h2><div class=\"row\">{figures}</div>"
        );
        if !of.comparisons.is_empty() {
            let columns = [
                "comparison",
                "people",
                "medians",
                "difference [95 %]",
                "U",
                "p",
                "effect r [95 %]",
            ];
            out += &wide(&columns, of.comparisons.iter().map(comparison));
            out += "<p class=\"sub\">Mann and Whitney's U, two-sided, normal approximation; r is the rank-biserial correlation; intervals by bootstrap over people.</p>";
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
        out += &wide(
            &[
                "condition",
                "drawings",
                "RMSE, mm [95 %]",
                "Fréchet, mm [95 %]",
                "breaks per drawing",
            ],
            rows,
        );
        out += "<p class=\"sub\">Medians of each person's median. RMSE after the drawing's time was stretched to the path's and shifted.</p></section>";
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
        let wires: Vec<String> = (0..of.confusion.len()).map(|w| w.to_string()).collect();
        let head = [("", "wire")].into_iter();
        let head: Vec<_> = head
            .chain(wires.iter().map(|wire| ("num", wire.as_str())))
            .collect();
        let rows = of.confusion.iter().enumerate().map(|(wire, row)| {
            let counts = row.iter().map(u32::to_string);
            let cells = [wire.to_string()].into_iter().chain(counts).collect();
            (false, cells)
        });
        // Single digits have room on a narrow page; those of a large display are listed.
        out += &match wires.len() {
            0..=10 => table(&head, rows),
            _ => page::wide(&head, rows),
        };
        out += "<p class=\"sub\">Rows are the wires that were driven, columns those nearest to the answer.</p></section>";
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
                certain(c.says_nothing(), c.p),
            ]
        });
        out += &wide(
            &["pair", "part of answers [95 %]", "people", "p, sign test"],
            rows,
        );
        out += "</section>";
    }
    out
}

fn participant(of: &Participant) -> String {
    let mut out = format!(
        "<section><h2>Participant {}</h2><p class=\"sub\">{} trials that count, {} void{}{}</p>",
        of.number,
        of.trials,
        of.void,
        if of.complete { "" } else { "; not over" },
        of.answers
            .iter()
            .map(|(name, answer)| format!("; {}: {}", escape(name), escape(answer)))
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
    let title = format!("Study {}", of.protocol);
    format!(
        "{}<header><h1>{}</h1></header>\n<p class=\"sub\">{}. Blue is what was played or fitted, orange what was felt, with 95 % intervals.</p>{flag}{}{people}{}",
        head(&title),
        escape(&title),
        match of.participants.len() {
            1 => "1 participant".to_owned(),
            count => format!("{count} participants"),
        },
        over_all(of),
        foot("", "")
    )
}
