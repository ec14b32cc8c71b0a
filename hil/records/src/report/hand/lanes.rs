//! All fingers against time, a row each: how strong the contact that drives is, and how far over threshold it is felt.

use std::fmt::Write;

use super::{FingerReport, HandReport};
use crate::measure::length_us;
use crate::report::scale::Scale;
use crate::report::svg::{key, path_key};
use crate::report::timeplot::{Pen, SPAN, TimePlot, tenth_ms};
use crate::trace::{Event, FeltAt, event};

/// Height of a row on the page, pixels.
const ROW: f64 = 46.0;
/// Base of a row, and height of its highest level, in units of the paths.
const BASE: i64 = 9_300;
const TALL: f64 = 8_000.0;
/// The least full height of a row, dB.
const LEAST_DB: f64 = 10.0;
/// A contact holds so long where no further frame comes, microseconds.
const HOLDS_US: u64 = 50_000;

fn base(row: usize) -> i64 {
    i64::try_from(row).unwrap_or(0) * SPAN + BASE
}

/// The strongest level of the contacts that drive, while it stays: from, to, level.
fn levels(finger: &FingerReport<'_>) -> Vec<(u64, u64, u16)> {
    let mut frames: Vec<(u64, u16)> = Vec::new();
    for event in &finger.trace.events {
        match event {
            Event::Frame(frame) => frames.push((frame.t_us, 0)),
            Event::Contact(now) if finger.drives(now.module) => {
                if let Some((_, most)) = frames.last_mut().filter(|(t, _)| *t == now.t_us) {
                    *most = (*most).max(now.level);
                }
            }
            _ => {}
        }
    }
    let mut stays: Vec<(u64, u64, u16)> = Vec::new();
    for (n, (from, level)) in frames.iter().enumerate() {
        let holds = from.saturating_add(HOLDS_US);
        let to = frames
            .get(n + 1)
            .map_or(holds, |(next, _)| (*next).min(holds));
        match stays.last_mut() {
            Some((_, end, same)) if same == level && end == from => *end = to,
            _ => stays.push((*from, to, *level)),
        }
    }
    stays.retain(|(_, _, level)| *level > 0);
    stays
}

/// Felt onsets inside the display: time, microseconds, and level, dB; below 0 is a break.
fn felt(finger: &FingerReport<'_>) -> Vec<(u64, f64)> {
    let level = |onset: &event::Felt| {
        let level = onset.met.map_or(-1, |met: FeltAt| met.level_mdb);
        (onset.t_us, f64::from(level) * 1e-3)
    };
    let inside = finger
        .trace
        .each()
        .filter(|onset: &&event::Felt| onset.inside);
    inside.map(level).collect()
}

/// Writes the section; nothing where no finger was touched.
pub(super) fn section(page: &mut String, hand: &HandReport<'_>) {
    let touched: Vec<_> = hand.fingers.iter().map(levels).collect();
    let felt: Vec<_> = hand.fingers.iter().map(felt).collect();
    if touched.iter().all(Vec::is_empty) {
        return;
    }
    let most = touched.iter().flatten().map(|(_, _, level)| *level).max();
    let most = most.unwrap_or(1).max(1);
    let loudest = felt
        .iter()
        .flatten()
        .map(|(_, db)| *db)
        .fold(LEAST_DB, f64::max);
    let full = (loudest / 5.0).ceil() * 5.0;
    let rows = hand.fingers.len();
    let label = "Contact levels and felt levels of all fingers against time";
    let span = (0, length_us(hand.trace));
    let plot = TimePlot::new(label, "", rows as f64 * ROW, span, Scale::exact(0.0, 1.0));
    let mut plot = plot.with_rows(rows).named();
    for (row, finger) in hand.fingers.iter().enumerate() {
        let base = base(row);
        plot.row_name(row, finger.name);
        plot.across(base, "ruling");
        let mut bars = Pen::default();
        for (from, to, level) in &touched[row] {
            let height = f64::from(*level) / f64::from(most) * TALL;
            let (from, to) = (tenth_ms(*from), tenth_ms(*to));
            bars.bar((from, base), to - from, height.round() as i64);
        }
        plot.path("bars", finger.name, "touched", &bars.finish());
        let (mut dots, mut breaks) = (Pen::default(), Pen::default());
        for (t_us, db) in &felt[row] {
            let at = tenth_ms(*t_us);
            if *db < 0.0 {
                breaks.bar((at, base), 0, 0);
                breaks.bar((at, base), 0, TALL as i64);
            } else {
                dots.dot((at, base - (db / full * TALL).round() as i64));
            }
        }
        plot.path("marks", finger.name, "mark break-mark", &breaks.finish());
        plot.path("dots", finger.name, "dots series-dots", &dots.finish());
        let felt = felt[row].iter().filter(|(_, db)| *db >= 0.0).count();
        plot.row_note(row, &format!("{felt} felt"));
    }
    let mut legend = String::new();
    path_key(
        &mut legend,
        "touched",
        "M4 12v-9h18v9z",
        &format!("level of the contact that drives, full height {most}"),
    );
    key(
        &mut legend,
        "<circle class=\"felt-dot\" cx=\"13\" cy=\"6\" r=\"3\"/>",
        &format!("felt level of an onset, full height {full:.0} dB over threshold"),
    );
    path_key(&mut legend, "mark break-mark", "M13 0v12", "break");
    let _ = writeln!(
        page,
        "<section><h2>All fingers against time</h2><p class=\"sub\">A row per finger: what touched its pad, \
         and what its thimble let feel of it.</p>\n<div class=\"lanes\">{}</div>\
         <div class=\"legend\">{legend}</div></section>",
        plot.finish(1, "")
    );
}
