//! Cards of a hand's fingers: results of each.

use std::fmt::Write;

use super::drawing::contacts;
use super::{FingerReport, HandReport, link};
use crate::felt::{FeltLevel, felt_level, felt_scores};
use crate::margin::Margin;
use crate::measure::{Errors, path_error};
use crate::model;
use crate::report::page::table;
use crate::report::svg::escape;
use crate::report::tables::meter;
use crate::trace::{Event, event};

/// Number of a finger's limits on its card: those used up most.
const LIMITS: usize = 4;

/// Writes all cards.
pub(super) fn section(page: &mut String, hand: &HandReport<'_>) {
    page.push_str("<h2 class=\"next\">Finger by finger</h2>\n<div class=\"cards\">");
    for finger in hand.fingers {
        card(page, hand, finger);
    }
    page.push_str("</div>\n");
}

fn card(page: &mut String, hand: &HandReport<'_>, finger: &FingerReport<'_>) {
    let _ = writeln!(
        page,
        "<section><h2><a href=\"{}\">{}</a> <span class=\"badge {}\">{}</span></h2><p class=\"sub\">{}</p>",
        link(finger.file),
        escape(finger.name),
        finger.conclusion.verdict.key(),
        finger.conclusion.verdict.word(),
        escape(&driven_by(hand, finger))
    );
    if let Some(why) = finger.conclusion.why.first() {
        let _ = writeln!(page, "<p class=\"sub\">{}</p>", escape(why));
    }
    page.push_str("<table>");
    for (name, value, unit) in figures(finger) {
        let _ = writeln!(
            page,
            "<tr><td>{name}</td><td class=\"num\">{value}</td><td>{unit}</td></tr>"
        );
    }
    page.push_str("</table>\n");
    let columns = [("", "limit"), ("num", "worst"), ("html", "used")];
    let row = |margin: &Margin| {
        let unit = match margin.of.unit() {
            "C" => "\u{b0}C",
            unit => unit,
        };
        let worst = match margin.is_beyond() {
            true => format!("> {:.0} {unit}", model::TISSUE_C),
            false => format!("{:.1} {unit}", margin.worst()),
        };
        let used = meter(margin.used_milli_percent());
        let cells = vec![margin.of.name().to_owned(), worst, used];
        (margin.over(), cells)
    };
    let margins = finger.trace.ledger.margins.iter().take(LIMITS);
    let _ = writeln!(page, "{}</section>", table(&columns, margins.map(row)));
}

/// Modules, wires and boards of a finger in words.
fn driven_by(hand: &HandReport<'_>, finger: &FingerReport<'_>) -> String {
    let name = |m: &usize| hand.pads.get(*m).map_or("?", |pad| &*pad.name);
    let names: Vec<&str> = finger.modules.iter().map(name).collect();
    let modules = match names.as_slice() {
        [first, rest @ ..] if !rest.is_empty() && !finger.merged => {
            format!("{first} drives; {} recorded", rest.join(", "))
        }
        all => format!("{} drives", all.join(" and ")),
    };
    let wires = &finger.trace.header.wires;
    let mut boards: Vec<u8> = wires.iter().map(|w| w.board).collect();
    boards.sort_unstable();
    boards.dedup();
    let boards: Vec<String> = boards.iter().map(u8::to_string).collect();
    let plural = if boards.len() == 1 { "" } else { "s" };
    format!(
        "{modules}. {} wires on board{plural} {}.",
        wires.len(),
        boards.join(", ")
    )
}

/// Rows of a card: name, value, unit.
fn figures(finger: &FingerReport<'_>) -> Vec<(&'static str, String, &'static str)> {
    let trace = finger.trace;
    let none = || "\u{2013}".to_owned();
    let rmse = |errors: Option<Errors>| {
        errors.map_or_else(none, |e| format!("{:.2}", e.rmse_um as f64 * 1e-3))
    };
    let drives = |contact: &&event::Contact| finger.drives(contact.module);
    let driving = trace.each().filter(drives).count();
    let [energy, _] = felt_scores(trace);
    let level = felt_level(trace);
    let skin = trace.events.iter().filter_map(|e| match e {
        Event::Skin(now) => Some(now.milli_c),
        _ => None,
    });
    let of_level = |text: &dyn Fn(&FeltLevel) -> String| level.as_ref().map_or_else(none, text);
    let db = |of: fn(&FeltLevel) -> i32| of_level(&|l| format!("{:+.1}", f64::from(of(l)) * 1e-3));
    let moved = of_level(&|l| format!("{:.1}", f64::from(l.skin_median_nm) * 1e-3));
    let driven = trace.ledger.driven;
    // Without a true path there is nothing to hold the felt path against.
    let known = trace.each::<event::Truth>().next().is_some();
    let [all, inside] = [energy.everywhere, energy.errors].map(|errors| errors.filter(|_| known));
    let onsets = inside.map_or_else(none, |e| e.count.to_string());
    let energy_mj = format!("{:.0}", trace.ledger.energy_uj as f64 * 1e-3);
    let mut rows = vec![
        ("contacts that drive", driving.to_string(), ""),
        ("contacts, all", contacts(finger).to_string(), ""),
        ("path error, RMSE", rmse(path_error(trace)), "mm"),
        ("felt level, median", db(|l| l.median_mdb), "dB"),
        ("felt level, 5 %", db(|l| l.p5_mdb), "dB"),
        ("felt error, RMSE", rmse(all), "mm"),
        ("inside the wires", rmse(inside), "mm"),
        ("onsets inside", onsets, ""),
        ("skin moves, median", moved, "um"),
        ("breaks", of_level(&|_| energy.breaks.to_string()), "onsets"),
        ("stimuli", driven.stimuli.to_string(), ""),
        ("limiter events", driven.limiter_events.to_string(), ""),
        ("energy", energy_mj, "mJ"),
    ];
    if let Some(hottest) = skin.max() {
        let hottest = model::known(f64::from(hottest) * 1e-3, model::TISSUE_C);
        let beyond = || format!("> {:.0}", model::TISSUE_C);
        let hottest = hottest.map_or_else(beyond, |c| format!("{c:.1}"));
        rows.push(("skin at onsets, hottest", hottest, "\u{b0}C"));
    }
    rows
}
