//! A review as one HTML page: words, margins before and after, and both schedules drawn over one another.

use std::fmt::Write;

use palpate_records::bursts::{Burst, DrivenOutput};
use palpate_records::diff::Grade;
use palpate_records::report::page::{foot, head};
use palpate_records::report::scale::Scale;
use palpate_records::report::svg::{Plot, Svg, escape, key};
use palpate_records::story::{GoldenKind, Story};

use super::scene::Scene;

/// Width of a drawing, pixels, and what its labels take on the left.
const SIZE: (f64, f64) = (1120.0, 64.0);
/// Height of a wire's row and of its widest burst.
const ROW: (f64, f64) = (30.0, 24.0);
/// Length of the close look, microseconds.
const CLOSE_US: u64 = 600_000;
/// Most wires with a row.
const ROWS: usize = 32;
/// Most differences of a scene on the page.
const TOLD: usize = 40;

/// The page of everything that waits.
pub fn page(scenes: &[Scene]) -> String {
    let mut out = head("review");
    let _ = writeln!(
        out,
        "<header><h1>Changed goldens</h1></header>\n\
         <p class=\"sub\">{} for a decision. The scene that lost most of a margin comes first. \
         Decide with <code>hil review</code>.</p>",
        match scenes.len() {
            0 => "No scene waits".to_owned(),
            1 => "1 scene waits".to_owned(),
            n => format!("{n} scenes wait"),
        }
    );
    for scene in scenes {
        section(&mut out, scene);
    }
    out + &foot("", "")
}

fn section(out: &mut String, scene: &Scene) {
    let kinds: Vec<&str> = scene.changes.iter().map(|c| c.what()).collect();
    let _ = write!(
        out,
        "<section><h2>{}</h2>\n<p class=\"sub\">{}</p>\n<ul>",
        escape(&scene.name),
        kinds.join(", ")
    );
    let words = scene.words();
    for d in words.iter().take(TOLD) {
        let class = match (d.grade, d.meaning) {
            (Grade::Margin, _) => "margin",
            (_, false) => "cosmetic",
            _ => "",
        };
        let _ = writeln!(out, "<li class=\"{class}\">{}</li>", escape(&d.text));
    }
    if words.len() > TOLD {
        let _ = writeln!(out, "<li>.. and {} more</li>", words.len() - TOLD);
    }
    out.push_str("</ul>\n");
    if let Some((old, new)) = scene.golden(GoldenKind::Schedule) {
        margins(out, old, new);
        drawings(out, old, new);
    }
    out.push_str("</section>\n");
}

fn margins(out: &mut String, old: &Story, new: &Story) {
    out.push_str(
        "<h2 class=\"next\">Margins</h2>\n<table><tr><th>limit</th><th class=\"num\">was used</th>\
         <th class=\"num\">is used</th><th></th><th class=\"num\">worst</th><th class=\"num\">limit</th></tr>\n",
    );
    let percent = |used: i64| format!("{:.3}", used as f64 / 1e3);
    for figure in &new.figures {
        let Some(used) = figure.used else { continue };
        let before = old.figures.iter().find(|f| f.name == figure.name);
        let before = before
            .and_then(|f| f.used)
            .map_or_else(|| "-".into(), percent);
        let over = if figure.over { " class=\"over\"" } else { "" };
        let _ = writeln!(
            out,
            "<tr{over}><td>{}</td><td class=\"num\">{} %</td><td class=\"num\">{} %</td>\
             <td><span class=\"meter\"><i style=\"width:{:.0}%\"></i></span></td>\
             <td class=\"num\">{}</td><td class=\"num\">{} {}</td></tr>",
            escape(&figure.name),
            before,
            percent(used),
            (used as f64 / 1e3).clamp(0.0, 100.0),
            figure.text(figure.value),
            figure.text(figure.limit),
            escape(&figure.unit),
        );
    }
    out.push_str("</table>\n");
}

/// Time at which two stories begin to differ, microseconds.
fn first_difference(old: &Story, new: &Story) -> Option<u64> {
    // Both are sorted by their starts, so the first pair that differs is the earliest.
    let longest = old.bursts.len().max(new.bursts.len());
    let pairs = (0..longest).map(|i| (old.bursts.get(i), new.bursts.get(i)));
    let mut differing = pairs.skip_while(|(x, y)| x == y);
    let (x, y) = differing.next()?;
    [x, y].into_iter().flatten().map(|b| b.from_us).min()
}

fn drawings(out: &mut String, old: &Story, new: &Story) {
    let ends = |s: &Story| s.bursts.iter().map(|b| b.to_us).max();
    let listed = [old.listed_until_us(), new.listed_until_us()];
    let listed = listed.into_iter().flatten().min().unwrap_or(u64::MAX);
    let end = ends(old).max(ends(new)).unwrap_or(0).min(listed);
    if end == 0 {
        return;
    }
    let starts = |s: &Story| s.bursts.first().map(|b| b.from_us);
    let start = [starts(old), starts(new)]
        .into_iter()
        .flatten()
        .min()
        .unwrap_or(0);
    let mut legend = String::new();
    let was = "<rect class=\"was\" width=\"26\" height=\"12\"/>";
    key(&mut legend, was, "as it was");
    let is = "<rect class=\"is\" x=\"1\" y=\"1\" width=\"24\" height=\"10\"/>";
    key(&mut legend, is, "as it is");
    let _ = writeln!(
        out,
        "<h2 class=\"next\">Schedule</h2>\n<p class=\"legend\">{legend}</p>"
    );
    if let Some(first) = first_difference(old, new) {
        let from = first.saturating_sub(CLOSE_US / 12);
        out.push_str("<p class=\"sub\">The first difference, close.</p>\n");
        out.push_str(&overlay(old, new, from, from.saturating_add(CLOSE_US)));
        out.push_str("<p class=\"sub\">The whole run.</p>\n");
    }
    out.push_str(&overlay(old, new, start, end));
    if old.bursts_untold.max(new.bursts_untold) > 0 {
        out.push_str(
            "<p class=\"sub\">One of the goldens does not list every burst: what comes later is not drawn.</p>\n",
        );
    }
}

fn overlay(old: &Story, new: &Story, from_us: u64, to_us: u64) -> String {
    let mut outputs: Vec<DrivenOutput> = old
        .bursts
        .iter()
        .chain(&new.bursts)
        .map(|b| b.output)
        .collect();
    outputs.sort_unstable();
    outputs.dedup();
    outputs.truncate(ROWS);
    let rows = outputs.len() as f64;
    let mut svg = Svg::new(
        SIZE.0,
        rows * ROW.0 + 44.0,
        "Both schedules, one row a wire",
    );
    let seconds = |us: u64| us as f64 * 1e-6;
    let plot = Plot {
        left: SIZE.1,
        top: 4.0,
        width: SIZE.0 - SIZE.1 - 16.0,
        height: rows * ROW.0,
        x: Scale::exact(seconds(from_us), seconds(to_us.max(from_us + 1))),
        y: Scale::exact(0.0, 1.0),
    };
    plot.x_axis(&mut svg, "time [s]");
    let all = || old.bursts.iter().chain(&new.bursts);
    let widest = all().map(|b| b.width).max().unwrap_or(0).max(1);
    for (row, output) in outputs.iter().enumerate() {
        let base = plot.top + (row as f64 + 1.0) * ROW.0 - 2.0;
        svg.text((SIZE.1 - 8.0, base - 6.0), "label end", &output.to_string());
        let bars = |story: &Story| {
            let mut path = String::new();
            let shown = |b: &&Burst| b.output == *output && b.from_us < to_us && b.to_us > from_us;
            for b in story.bursts.iter().filter(shown) {
                let x0 = plot.px(seconds(b.from_us.max(from_us)));
                let x1 = plot.px(seconds(b.to_us.min(to_us)));
                let high = f64::from(b.width) / f64::from(widest) * ROW.1;
                let wide = (x1 - x0).max(0.8);
                let _ = write!(path, "M{x0:.1} {base:.1}v{:.1}h{wide:.1}v{high:.1}z", -high);
            }
            path
        };
        svg.line((plot.left, base), (plot.left + plot.width, base), "ruling");
        svg.path(&bars(old), "was");
        svg.path(&bars(new), "is");
    }
    format!("<div class=\"wide\">{}</div>\n", svg.finish())
}
