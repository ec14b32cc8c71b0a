//! The figures in their sections, each with its legend below, where it covers no data.

use super::svg::{Plot, escape, key, line_key, path_key};
use super::{ReportExtras, paths, series, strip};
use crate::bursts::bursts;
use crate::measure;
use crate::model;
use crate::trace::{Trace, event};
use std::fmt::Write;

pub(super) fn taxel_key(out: &mut String) {
    let taxel = "<rect class=\"taxel\" x=\"7\" y=\"0\" width=\"12\" height=\"12\"/>";
    key(out, taxel, "taxel");
}

pub(super) fn break_key(out: &mut String) {
    let cross = "M8 1l10 10M8 11l10 -10";
    path_key(out, "cross", cross, "break: nothing felt");
}

pub(super) const RAMP: &str = "start <i class=\"ramp\"></i> end of the run";

/// Draws contact path and felt path side by side, and returns their planes.
pub(super) fn planes(page: &mut String, trace: &Trace) -> [Plot; 2] {
    let (pad, on_pad) = paths::contact_path(trace);
    let (display, on_display) = paths::felt_path(trace);
    let truth = trace.each::<event::Truth>().next().is_some();
    let mut legend = String::new();
    if truth {
        line_key(&mut legend, "truth", "true path");
    }
    let _ = write!(legend, "<span>contact: {RAMP}</span>");
    key(
        &mut legend,
        "<circle class=\"start\" cx=\"13\" cy=\"6\" r=\"5\"/>",
        "first contact",
    );
    taxel_key(&mut legend);
    let _ = writeln!(
        page,
        "<div class=\"pair\"><section><h2>Contact path on the sensor</h2>\n\
         <div class=\"plane\" id=\"pad\">{pad}</div><div class=\"legend\">{legend}</div></section>"
    );
    let mut legend = String::new();
    line_key(&mut legend, "aim", "contact, mapped");
    let _ = write!(legend, "<span>felt, energy centroid: {RAMP}</span>");
    break_key(&mut legend);
    path_key(
        &mut legend,
        "cross dim",
        "M8 1l10 10M8 11l10 -10",
        "nothing felt, outside the display",
    );
    line_key(&mut legend, "wire", trace.header.actuator());
    let _ = writeln!(
        page,
        "<section><h2>Felt path on the display</h2>\n\
         <div class=\"plane\" id=\"display\">{display}</div><div class=\"legend\">{legend}</div>{}</section></div>",
        felt_in_words(trace)
    );
    [on_pad, on_display]
}

/// Words on the onsets that the felt path counts, and on why a phantom breaks. Empty where nothing was projected.
fn felt_in_words(trace: &Trace) -> String {
    let (mut scored, mut breaks, mut beyond) = (0u64, 0u64, 0u64);
    for onset in trace.each::<event::Felt>() {
        scored += 1;
        breaks += u64::from(onset.is_break());
        beyond += u64::from(!onset.is_felt() && !onset.inside);
    }
    let driven = bursts(trace).iter().any(|b| b.width > 0);
    let text = match (scored, driven) {
        (0, false) => return String::new(),
        (0, true) => {
            "Not drawn: every onset had several contacts at once, or a texture that has the display to \
                      itself, and one felt place is held against one contact. The wires were driven; see the schedule."
                .to_owned()
        }
        _ => {
            let mut text = format!("Onsets with one contact: {scored}.");
            if breaks > 0 {
                let _ = write!(
                    text,
                    " Breaks: {breaks}. There the contact lies inside the display and all wires together \
                     stay below threshold. {}",
                    why(&trace.header.illusion)
                );
                if trace.ledger.driven.limiter_events > 0 {
                    text.push_str(" What the guard took away can break it too; see the events.");
                }
            }
            if beyond > 0 {
                let _ = write!(
                    text,
                    " Outside the display, where no phantom can be: {beyond}."
                );
            }
            text.push_str(
                " What is felt comes from a model of a person.",
            );
            text
        }
    };
    format!("<p class=\"sub words\">{}</p>", escape(&text))
}

/// The cause of a break, by the model's name.
fn why(illusion: &str) -> &'static str {
    match illusion {
        "phantom" => {
            "The phantom law (5.2) leaves little activation between wires: with shape 1 a quarter \
             halfway between two, and less beside both axes, since the shares of x and y multiply."
        }
        _ => "The illusion leaves too little activation there.",
    }
}

/// Contacts and time per frame; nothing where contacts came without taxels, as those that another machine found.
pub(super) fn frames(page: &mut String, trace: &Trace, extras: &ReportExtras<'_>) {
    let has_contacts = trace.each::<event::Contact>().next().is_some();
    if has_contacts
        && trace
            .each()
            .all(|frame: &event::Frame| frame.in_contact == 0)
    {
        return;
    }
    let said = match series::times(extras.frame_us).next().is_none() {
        true => "Time per frame was not measured.",
        false => {
            "Measured on this machine, for the whole loop: compression, and stimuli where an onset is due. The first \
             frames make the reference and are not drawn."
        }
    };
    let _ = writeln!(
        page,
        "<section><h2>Contacts and time per frame</h2><p class=\"sub\">{said}</p>\n{}</section>",
        series::frames(trace, extras.frame_us)
    );
}

/// Wire temperatures; nothing where no wire was measured.
pub(super) fn temperatures(page: &mut String, trace: &Trace) {
    let wires = series::warm_wires(trace);
    if wires.is_empty() {
        return;
    }
    let plot = series::temperatures(trace, &wires);
    let legend = plot.legend.clone();
    let all = trace.header.wires.len();
    let mut which = String::from(
        "Sampled at each onset, before its burst heats the wire: the peaks within a burst are not drawn.",
    );
    if let Some((milli_c, wire)) = trace.ledger.hottest_wire {
        let hottest = model::on_page(f64::from(milli_c) / 1000.0, model::WIRE_C);
        let _ = write!(which, " Hottest at any instant: wire {wire}, {hottest}.");
    }
    if wires.len() < all {
        let _ = write!(which, " The {} hottest of {all} wires.", wires.len());
    }
    let _ = writeln!(
        page,
        "<section><h2>Wire temperatures at the onsets</h2><p class=\"sub\">{which}</p>\n{}\
         <div class=\"legend\">{legend}</div></section>",
        plot.finish(2, "")
    );
}

/// The schedule, whole and in detail.
pub(super) fn schedule(page: &mut String, trace: &Trace) {
    let all = bursts(trace);
    let mut legend = String::new();
    let height = match trace.header.motors {
        true => "burst, height is level",
        false => "burst, height is pulse width",
    };
    for (class, shape, words) in [
        ("burst", "M7 12v-10h12v10z", height),
        ("burst cut", "M7 12v-6h12v6z", "applied after a limit"),
        ("asked", "M7 11v-10h12v10z", "requested, cut or refused"),
        ("mark limit-mark", "M13 0v12", "limiter"),
        ("mark break-mark", "M13 0v12", "break"),
        ("mark note-mark", "M13 0v12", "note"),
        ("mark off-mark", "M13 0v12", "all off"),
    ] {
        path_key(&mut legend, class, shape, words);
    }
    let length = measure::length_us(trace);
    let words = match trace.header.motors {
        true => {
            "One row a motor; a bar is a burst, as high as its level. On the right the highest level of the motor."
        }
        false => {
            "One row a wire; a bar is a burst of pulses, as high \
             as its pulses are wide. On the right the largest duty of the wire."
        }
    };
    let _ = writeln!(
        page,
        "<section><h2>Schedule</h2><p class=\"sub\">{words}</p>\n{}",
        strip::schedule(trace, &all, (0, length))
    );
    if let Some((from, to)) = strip::detail(trace, &all) {
        let _ = writeln!(
            page,
            "<div class=\"still\"><h2 class=\"next\">In detail: twenty onsets</h2>\n{}</div>",
            strip::schedule(trace, &all, (from, to))
        );
    }
    let _ = writeln!(page, "<div class=\"legend\">{legend}</div></section>");
}
