//! The story of a trace.

use super::table::Table;
use super::text::event as event_line;
use super::{COLUMNS, GoldenKind, HeadLine, Story, StoryTiming, pad, strip};
use crate::bursts::bursts;
use crate::digest;
use crate::felt::{energies, felt_level, felt_scores};
use crate::figures::figures;
use crate::fixed::{hundredths, milli, milli_u, seconds};
use crate::measure::{self, Errors};
use crate::trace::{PlaceUm, Trace, event};
use crate::words::{Happening, happenings, one_line};
use std::collections::BTreeMap;

/// Most contacts or wires with a row.
const ROWS: usize = 24;

impl Story {
    /// Golden of a run's schedule: commands to the wires, and their results.
    pub fn schedule(trace: &Trace) -> Self {
        let mut story = Self::begun(GoldenKind::Schedule, trace);
        let header = &trace.header;
        story.timing = StoryTiming {
            tau_d_us: header.tau_d_us,
            soa_us: header.soa_us,
            tick_ns: header.pre_scale.tick_ns(),
        };
        story.head.extend(drive(trace));
        story.head.extend(contact_summary(trace));
        if let Some(level) = felt_level(trace) {
            let decibels = |mdb: i32| format!("{} dB", milli(i64::from(mdb)));
            story.head.push(head(
                "felt level",
                [
                    format!("person {}", header.person),
                    format!("preset {}", header.preset),
                    format!("median {}", decibels(level.median_mdb)),
                    format!("5 % {}", decibels(level.p5_mdb)),
                    format!("taps {}", level.taps),
                ],
            ));
            let micrometres = |nm: i32| format!("{} um", milli(i64::from(nm)));
            story.head.push(head(
                "skin displacement",
                [
                    format!("median {}", micrometres(level.skin_median_nm)),
                    format!("most {}", micrometres(level.skin_most_nm)),
                ],
            ));
        }
        for score in felt_scores(trace) {
            let label = format!("felt error, {}", score.perceiver);
            let mut line = errors(&label, score.errors);
            line.pieces.push(format!("breaks {}", score.breaks));
            line.pieces.push(format!("jumps {}", score.jumps));
            story.head.push(line);
            let label = format!("felt error over all, {}", score.perceiver);
            story.head.push(errors(&label, score.everywhere));
        }
        for (name, (least, most)) in energies(trace).into_iter().flatten() {
            let piece = format!("{least} to {most} thousandths of a wire's");
            story
                .head
                .push(head(&format!("energy {name} inside the display"), [piece]));
        }
        story.head.extend(face(trace));
        story.chart = strip::schedule(trace);
        story.happenings = happenings(trace).iter().map(to_the_line).collect();
        story.figures = figures(trace);
        wires(&mut story.table, trace);
        story.bursts = bursts(trace);
        story.digests = BTreeMap::from([
            ("schedule", digest::schedule_digest(trace)),
            ("trace", digest::trace_digest(trace)),
        ]);
        story
    }

    /// Golden of a run's contacts: the compression's account of the touch.
    pub fn contacts(trace: &Trace) -> Self {
        let mut story = Self::begun(GoldenKind::Contacts, trace);
        story.head.extend(contact_summary(trace));
        story.pad = pad::draw(trace);
        story.chart = strip::contacts(trace);
        contacts(&mut story.table, trace);
        story.digests = BTreeMap::from([("contacts", digest::contacts_digest(trace))]);
        story
    }

    /// Begins a golden of any kind: title and header, before any table.
    pub fn begun(kind: GoldenKind, trace: &Trace) -> Self {
        let h = &trace.header;
        let length = seconds(measure::length_us(trace));
        let mut story = Self::empty(kind, one_line(&h.scene), h.source);
        let banner = h.source.banner().and_then(|text| text.split_once(": "));
        story.head = banner
            .map(|(label, text)| head(label, [text.to_owned()]))
            .into_iter()
            .collect();
        story.head.extend([
            head(
                "",
                [
                    format!("bench {}", name(&h.bench)),
                    format!("seed {}", h.seed),
                ],
            ),
            head(
                "",
                [
                    format!("scene {}", h.scene_digest),
                    format!("limits {}", h.limits_digest),
                ],
            ),
            head("", [format!("length {length} s")]),
        ]);
        story
    }
}

fn head<const N: usize>(label: &str, pieces: [String; N]) -> HeadLine {
    HeadLine {
        label: label.to_owned(),
        pieces: pieces.map(|p| p.trim_end().to_owned()).into(),
    }
}

/// Temperatures of a Peltier module's face and sink, if there is one.
fn face(trace: &Trace) -> Option<HeadLine> {
    let modules = trace.each::<event::Face>();
    let faces = modules.clone().map(|now| now.face_mc);
    let celsius = |mc: i32| format!("{} C", milli(i64::from(mc)));
    let (coldest, warmest) = (faces.clone().min()?, faces.max()?);
    let sink = modules.map(|now| now.sink_mc).max()?;
    Some(head(
        "face",
        [
            format!("coldest {}", celsius(coldest)),
            format!("warmest {}", celsius(warmest)),
            format!("sink at most {}", celsius(sink)),
        ],
    ))
}

/// A name out of a file: on one line, without what parts the pieces of a header.
fn name(text: &str) -> String {
    one_line(text).replace([',', ':'], ";")
}

fn none() -> String {
    "-".to_owned()
}

/// Part of a happening that its line shows.
fn to_the_line(happening: &Happening) -> Happening {
    let whole_ms = |us: u64| us / 1000 * 1000;
    let mut line = Happening {
        t_us: whole_ms(happening.t_us),
        last_us: whole_ms(happening.last_us),
        kind: happening.kind,
        text: String::new(),
    };
    let left = COLUMNS.saturating_sub(event_line(&line).len());
    let text: String = happening.text.trim_start().chars().take(left).collect();
    text.trim_end().clone_into(&mut line.text);
    line
}

/// Frequency in thousandths of a hertz, rounded, from an exact period in nanoseconds.
fn milli_hz(period_ns: u64) -> u64 {
    (1_000_000_000_000 + period_ns / 2)
        .checked_div(period_ns)
        .unwrap_or(0)
}

fn drive(trace: &Trace) -> [HeadLine; 2] {
    let h = &trace.header;
    let period = h.pre_scale.period_ns();
    [
        head(
            "",
            [
                format!("PWM {} Hz true", milli_u(milli_hz(period))),
                format!("PRE_SCALE {}", h.pre_scale.get()),
                format!("period {} us", milli_u(period)),
                format!("tick {} ns", h.pre_scale.tick_ns()),
            ],
        ),
        head(
            "",
            [
                format!("tau_d {} ms", milli_u(h.tau_d_us)),
                format!("SOA {} ms", milli_u(h.soa_us)),
                format!("illusion {}", name(&h.illusion)),
                format!("K_C {}", h.kc),
                format!("{} wires", h.wires.len()),
            ],
        ),
    ]
}

fn errors(label: &str, found: Option<Errors>) -> HeadLine {
    match found {
        None => head(label, ["nothing to measure it against".to_owned()]),
        Some(e) => head(
            label,
            [
                format!("rmse {} mm", milli_u(e.rmse_um)),
                format!("max {} mm", milli_u(e.max_um)),
                format!("over {}", e.count),
            ],
        ),
    }
}

fn contact_summary(trace: &Trace) -> [HeadLine; 2] {
    let (mut frames, mut touched, mut most) = (0u64, 0u64, 0u16);
    for frame in trace.each::<event::Frame>() {
        frames += 1;
        touched += u64::from(frame.in_contact > 0);
        most = most.max(frame.in_contact);
    }
    [
        head(
            "",
            [
                format!("{frames} frames"),
                format!("{touched} in contact"),
                format!("at most {most} taxels at once"),
            ],
        ),
        errors("path error", measure::path_error(trace)),
    ]
}

/// A contact from its first frame to its last.
struct Span {
    first_us: u64,
    last_us: u64,
    frames: u64,
    from: PlaceUm,
    to: PlaceUm,
    levels: (u16, u16),
    peak_milli: u32,
    members: u32,
}

/// The contacts, by module and identity.
fn contacts(table: &mut Table, trace: &Trace) {
    let mut spans: BTreeMap<(u16, u32), Span> = BTreeMap::new();
    for now in trace.each::<event::Contact>() {
        let span = spans.entry((now.module, now.contact)).or_insert(Span {
            first_us: now.t_us,
            last_us: now.t_us,
            frames: 0,
            from: now.place,
            to: now.place,
            levels: (now.level, now.level),
            peak_milli: 0,
            members: 0,
        });
        span.last_us = now.t_us;
        span.to = now.place;
        span.frames += 1;
        span.levels = (span.levels.0.min(now.level), span.levels.1.max(now.level));
        span.peak_milli = span.peak_milli.max(now.intensity_milli);
        span.members = span.members.max(now.members);
    }
    table.untold = spans.len().saturating_sub(ROWS) as u64;
    let listed = spans.iter().take(ROWS);
    table.rows.extend(listed.map(|((module, contact), s)| {
        vec![
            format!("{module}/{contact}"),
            seconds(s.first_us),
            seconds(s.last_us),
            s.frames.to_string(),
            hundredths(s.from.x),
            hundredths(s.from.y),
            hundredths(s.to.x),
            hundredths(s.to.y),
            format!("{}..{}", s.levels.0, s.levels.1),
            (s.peak_milli / 1000).to_string(),
            s.members.to_string(),
        ]
    }));
}

/// Fills the table with a row for each wire.
fn wires(table: &mut Table, trace: &Trace) {
    let length = measure::length_us(trace);
    let all = &trace.header.wires;
    let tallies = measure::wire_tallies(trace);
    table.untold = all.len().saturating_sub(ROWS) as u64;
    for (index, (wire, t)) in all.iter().zip(&tallies).take(ROWS).enumerate() {
        // Nanoseconds over microseconds is thousandths; a percent of it is five digits further.
        let duty = (u128::from(t.high_ns) * 100).checked_div(u128::from(length));
        let duty = duty.map(|d| milli(i64::try_from(d).unwrap_or(i64::MAX)));
        let hottest = t.hottest_milli_c.map(|c| milli(i64::from(c)));
        table.rows.push(vec![
            index.to_string(),
            format!("{}:{}", wire.board, wire.channel),
            hundredths(wire.place.x),
            hundredths(wire.place.y),
            t.bursts.to_string(),
            t.limited.to_string(),
            seconds(t.burst_us),
            t.widest.to_string(),
            duty.unwrap_or_else(none),
            hottest.unwrap_or_else(none),
        ]);
    }
}
