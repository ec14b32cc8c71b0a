//! Goldens a person can read: header, strip chart, events in words, ledger, digest. ASCII, under 100
//! columns and 200 lines, built from integers only.
//!
//! Three of a scene, so that a change shows where it belongs: the contact path, the schedule, the margins; and one
//! of a surface over many runs.
//! The chart's quantum follows from the run's length alone; nothing random and no name of a file
//! enters.

mod exact;
mod lists;
mod margins;
mod pad;
mod strip;

pub use margins::{SurfacePoint, margins_golden, surface_golden};

use crate::digest;
use crate::felt::{energy_permille, felt_scores};
use crate::fixed::{milli_u, seconds};
use crate::measure::{self, Errors, Row};
use crate::trace::{Event, Source, Trace};
use crate::words::{self, one_line};
use std::fmt::Write;

/// Most characters on a line.
pub const COLUMNS: usize = 99;
/// Most lines of a golden.
pub const LINES: usize = 199;
/// Most happenings told one by one.
const STORY: usize = 40;

/// Appends one line, cut to [`COLUMNS`].
pub(crate) fn put(out: &mut String, line: &str) {
    out.extend(line.trim_end().chars().take(COLUMNS));
    out.push('\n');
}

fn name(source: Source) -> &'static str {
    match source {
        Source::Emulated => "emulated",
        Source::Real => "real",
    }
}

fn head(out: &mut String, what: &str, trace: &Trace) {
    let h = &trace.header;
    let scene = one_line(&h.scene);
    put(
        out,
        &format!("palpate {what} of {scene} ({})", name(h.source)),
    );
    put(
        out,
        &format!("  bench {}, seed {}", one_line(&h.bench), h.seed),
    );
    put(
        out,
        &format!("  scene {}, limits {}", h.scene_digest, h.limits_digest),
    );
    let length = seconds(measure::length_us(trace));
    put(out, &format!("  length {length} s"));
}

/// Frequency in thousandths of a hertz, rounded, from an exact period in nanoseconds.
fn milli_hz(period_ns: u64) -> u64 {
    (1_000_000_000_000 + period_ns / 2)
        .checked_div(period_ns)
        .unwrap_or(0)
}

fn drive(out: &mut String, trace: &Trace) {
    let h = &trace.header;
    let period = h.pre_scale.period_ns();
    put(
        out,
        &format!(
            "  PWM {} Hz true (PRE_SCALE {}, period {} us, tick {} ns)",
            milli_u(milli_hz(period)),
            h.pre_scale.get(),
            milli_u(period),
            h.pre_scale.tick_ns()
        ),
    );
    put(
        out,
        &format!(
            "  tau_d {} ms, SOA {} ms, illusion {}, K_C {}, {} wires",
            milli_u(h.tau_d_us),
            milli_u(h.soa_us),
            one_line(&h.illusion),
            h.kc,
            h.wires.len()
        ),
    );
}

fn errors(what: &str, found: Option<Errors>) -> String {
    match found {
        None => format!("  {what}: nothing to measure it against"),
        Some(e) => format!(
            "  {what}: rmse {} mm, max {} mm, over {}",
            milli_u(e.rmse_um),
            milli_u(e.max_um),
            e.count
        ),
    }
}

fn contact_summary(out: &mut String, trace: &Trace) {
    let (mut frames, mut touched, mut most) = (0u64, 0u64, 0u16);
    for event in &trace.events {
        if let Event::Frame { in_contact, .. } = event {
            frames += 1;
            touched += u64::from(*in_contact > 0);
            most = most.max(*in_contact);
        }
    }
    put(
        out,
        &format!("  {frames} frames, {touched} in contact, at most {most} taxels at once"),
    );
    put(out, &errors("path error", measure::path_error(trace)));
}

fn more(out: &mut String, all: usize, shown: usize) {
    if all > shown {
        put(out, &format!("  .. and {} more", all - shown));
    }
}

fn story(out: &mut String, trace: &Trace) {
    let list = words::happenings(trace);
    put(out, &format!("events: {}", list.len()));
    for happening in list.iter().take(STORY) {
        put(out, &format!("  {}", words::line(happening)));
    }
    more(out, list.len(), STORY);
}

fn ledger(out: &mut String, rows: &[Row]) {
    put(out, "ledger                          value           limit");
    for row in rows {
        let mut line = format!(
            "  {:<22} {:>12} {:<5} {:>9}",
            row.name,
            row.value_text(),
            row.unit,
            row.limit_text()
        );
        if let Some(percent) = row.percent() {
            let _ = write!(line, "  {percent:>4} %");
        }
        if row.over() {
            line.push_str("  OVER");
        }
        put(out, &line);
    }
}

/// The golden of a contact path: what the compression made of the touch.
pub fn contacts_golden(trace: &Trace) -> String {
    let mut out = String::new();
    head(&mut out, "contact path", trace);
    contact_summary(&mut out, trace);
    out.push('\n');
    pad::draw(&mut out, trace);
    out.push('\n');
    strip::contacts(&mut out, trace);
    lists::contacts(&mut out, trace);
    put(
        &mut out,
        &format!("digest of contacts {}", digest::contacts_digest(trace)),
    );
    out
}

/// The golden of a schedule: what the wires were told, and what it came to.
pub fn schedule_golden(trace: &Trace) -> String {
    let mut out = String::new();
    head(&mut out, "schedule", trace);
    drive(&mut out, trace);
    contact_summary(&mut out, trace);
    for score in felt_scores(trace) {
        let what = format!("felt error, {}", score.perceiver);
        let (breaks, jumps) = (score.breaks, score.jumps);
        put(
            &mut out,
            &format!(
                "{}; breaks {breaks}, jumps {jumps}",
                errors(&what, score.errors)
            ),
        );
    }
    if let Some((least, most)) = energy_permille(trace) {
        put(
            &mut out,
            &format!("  energy inside the display: {least} to {most} thousandths of a wire's"),
        );
    }
    out.push('\n');
    strip::schedule(&mut out, trace);
    story(&mut out, trace);
    out.push('\n');
    ledger(&mut out, &measure::ledger_rows(trace));
    out.push('\n');
    lists::wires(&mut out, trace);
    out.push('\n');
    // Heading, digests and the line that counts the rest.
    let left = LINES.saturating_sub(out.lines().count() + 4);
    exact::list(&mut out, trace, left.max(1));
    put(
        &mut out,
        &format!("digest of schedule {}", digest::schedule_digest(trace)),
    );
    put(
        &mut out,
        &format!("digest of trace    {}", digest::trace_digest(trace)),
    );
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic;
    use crate::trace::PlaceUm;

    fn readable(text: &str) {
        assert!(text.is_ascii());
        assert!(text.lines().count() < 200, "{} lines", text.lines().count());
        for line in text.lines() {
            assert!(line.len() < 100, "{line}");
        }
    }

    #[test]
    fn goldens_stay_within_a_screen_whatever_the_length() {
        for seconds in [1, 10, 60] {
            let trace = synthetic::circle(seconds);
            for text in [contacts_golden(&trace), schedule_golden(&trace)] {
                readable(&text);
                assert!(text.contains("sphere-circle (emulated)"));
            }
        }
        let trace = synthetic::circle(10);
        if let Some(folder) = std::env::var_os("PALPATE_SHOW") {
            let folder = std::path::PathBuf::from(folder);
            std::fs::write(folder.join("contacts.txt"), contacts_golden(&trace)).unwrap();
            std::fs::write(folder.join("schedule.txt"), schedule_golden(&trace)).unwrap();
        }
        let text = schedule_golden(&trace);
        assert!(text.contains("196.888 Hz"), "{text}");
        assert!(text.contains("tau_d 35.000 ms, SOA 58.500 ms"));
        assert!(text.contains("wire-power"));
    }

    #[test]
    fn empty_and_extreme_traces_still_make_goldens() {
        let mut trace = synthetic::empty();
        readable(&contacts_golden(&trace));
        readable(&schedule_golden(&trace));
        trace.header.taxels.clear();
        trace.header.wires.clear();
        trace.header.scene = "n\u{f6}\u{0}\n".repeat(90);
        trace.ledger.length_us = u64::MAX;
        trace.ledger.energy_uj = u64::MAX;
        trace.events.push(Event::Truth {
            t_us: u64::MAX,
            place: PlaceUm {
                x: i32::MAX,
                y: i32::MIN,
            },
            force_mn: 0,
        });
        readable(&contacts_golden(&trace));
        readable(&schedule_golden(&trace));
    }

    #[test]
    fn a_model_change_leaves_the_contact_golden_alone() {
        let trace = synthetic::circle(3);
        let mut other = trace.clone();
        other.ledger.energy_uj += 17;
        other.events.retain(|e| !matches!(e, Event::Wire { .. }));
        assert_eq!(contacts_golden(&trace), contacts_golden(&other));
        assert_ne!(schedule_golden(&trace), schedule_golden(&other));
    }
}
