//! Felt level of each onset over threshold, and its distance from the true place, over time.

use super::scale::Scale;
use super::series::{dots, span};
use super::svg::path_key;
use super::timeplot::TimePlot;
use crate::felt::{felt_level, felt_scores};
use crate::fixed::distance2_um;
use crate::measure::length_us;
use crate::trace::{FeltAt, Trace, event};
use std::fmt::Write;

/// Levels below are drawn here, dB: an onset that moves no wire has none.
const FLOOR_DB: f64 = -30.0;

fn level_db(onset: &event::Felt) -> f64 {
    let level = onset
        .met
        .map_or(f64::NEG_INFINITY, |met| f64::from(met.level_mdb) * 1e-3);
    level.max(FLOOR_DB)
}

/// Writes the section; nothing where no onset had one contact.
pub(super) fn section(page: &mut String, trace: &Trace) {
    let onsets: Vec<&event::Felt> = trace.each().collect();
    if onsets.is_empty() {
        return;
    }
    let errors = errors(trace, &onsets);
    let levels = levels(trace, &onsets);
    let levels = if errors.is_none() {
        levels.named()
    } else {
        levels
    };
    let mut legend = String::new();
    for (class, text) in [
        ("felt-dots", "felt"),
        ("felt-dots outside", "felt, the contact outside the wires"),
        ("felt-dots broken", "not felt"),
    ] {
        path_key(&mut legend, &format!("dots {class}"), "M13 6h0", text);
    }
    let _ = writeln!(
        page,
        "<section><h2>Felt level and error over time</h2><p class=\"sub\">Each dot is an onset with one contact: its level \
         over the person's threshold, and how far from the contact's place it is felt, by energy. Levels under \
         {FLOOR_DB:.0} dB are drawn there. The median is that inside the wires, the RMSE that over all onsets.</p>\n{}{}\
         <div class=\"legend\">{legend}</div></section>",
        levels.finish(1, ""),
        errors.map_or_else(String::new, |plot| plot.named().finish(2, ""))
    );
}

fn levels(trace: &Trace, onsets: &[&event::Felt]) -> TimePlot {
    let (low, high) = span(onsets.iter().map(|onset| level_db(onset)));
    let y = Scale::round(low.min(0.0), high.max(3.0));
    let label = "Felt level over threshold against time";
    let mut plot = TimePlot::new(label, "dB", 150.0, (0, length_us(trace)), y);
    plot.y_axis("felt level over threshold [dB]");
    plot.bound(0.0, "bound", "threshold");
    if let Some(level) = felt_level(trace).filter(|level| level.median_mdb > 2000) {
        let median = f64::from(level.median_mdb) * 1e-3;
        plot.bound(median, "median", &format!("median {median:+.1} dB"));
    }
    paths(&mut plot, onsets, |onset| Some(level_db(onset)));
    plot
}

/// Paths of the onsets: felt inside the wires, felt outside, and not felt.
fn paths(plot: &mut TimePlot, onsets: &[&event::Felt], of: impl Fn(&event::Felt) -> Option<f64>) {
    for (felt, inside, name, class) in [
        (true, Some(true), "felt", "felt-dots"),
        (true, Some(false), "felt outside", "felt-dots outside"),
        (false, None, "not felt", "felt-dots broken"),
    ] {
        let own = onsets.iter().filter(|onset| {
            onset.is_felt() == felt && inside.is_none_or(|inside| onset.inside == inside)
        });
        let points = own.filter_map(|onset| Some((onset.t_us, of(onset)?)));
        let path = dots(plot, points);
        plot.path("dots", name, &format!("dots {class}"), &path);
    }
}

/// The distance of every felt onset; `None` where no true place is known, or nothing was felt.
fn errors(trace: &Trace, onsets: &[&event::Felt]) -> Option<TimePlot> {
    trace.each::<event::Truth>().next()?;
    let error = |onset: &event::Felt| {
        let met = onset.met.filter(FeltAt::is_felt)?;
        let um = distance2_um(met.energy, onset.target).isqrt();
        Some(um as f64 * 1e-3)
    };
    let (low, most) = span(onsets.iter().filter_map(|onset| error(onset)));
    if low > most {
        return None;
    }
    let y = Scale::round(0.0, most.max(1.0));
    let label = "Felt error against time";
    let mut plot = TimePlot::new(label, "mm", 130.0, (0, length_us(trace)), y);
    plot.y_axis("felt error [mm]");
    let [energy, _] = felt_scores(trace);
    if let Some(rmse) = energy.everywhere.map(|e| e.rmse_um as f64 * 1e-3) {
        plot.bound(rmse, "median", &format!("RMSE {rmse:.2} mm"));
    }
    paths(&mut plot, onsets, error);
    Some(plot)
}
