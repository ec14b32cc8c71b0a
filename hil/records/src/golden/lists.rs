//! Tables of a golden: its contacts and its wires, one by one.

use super::{more, put};
use crate::fixed::{milli, place, seconds};
use crate::measure;
use crate::trace::{Event, PlaceUm, Trace};
use std::collections::BTreeMap;

/// Most contacts or wires told one by one.
const MEMBERS: usize = 24;

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
pub(super) fn contacts(out: &mut String, trace: &Trace) {
    let mut spans: BTreeMap<(u16, u32), Span> = BTreeMap::new();
    for event in &trace.events {
        let Event::Contact {
            t_us,
            module,
            contact,
            place,
            intensity_milli,
            level,
            members,
            ..
        } = event
        else {
            continue;
        };
        let span = spans.entry((*module, *contact)).or_insert(Span {
            first_us: *t_us,
            last_us: *t_us,
            frames: 0,
            from: *place,
            to: *place,
            levels: (*level, *level),
            peak_milli: 0,
            members: 0,
        });
        span.last_us = *t_us;
        span.to = *place;
        span.frames += 1;
        span.levels = (span.levels.0.min(*level), span.levels.1.max(*level));
        span.peak_milli = span.peak_milli.max(*intensity_milli);
        span.members = span.members.max(*members);
    }
    put(out, &format!("contacts: {}", spans.len()));
    for ((module, contact), s) in spans.iter().take(MEMBERS) {
        put(
            out,
            &format!(
                "  {module}/{contact:<3} {:>8}..{} s {:>5} frames {} -> {}",
                seconds(s.first_us),
                seconds(s.last_us),
                s.frames,
                place(s.from),
                place(s.to)
            ),
        );
        put(
            out,
            &format!(
                "        levels {}..{}, peak {} counts, at most {} taxels",
                s.levels.0,
                s.levels.1,
                s.peak_milli / 1000,
                s.members
            ),
        );
    }
    more(out, spans.len(), MEMBERS);
}

/// What each wire did.
pub(super) fn wires(out: &mut String, trace: &Trace) {
    put(
        out,
        "wire  output     place                bursts limited on [s]  widest  mean duty  hottest",
    );
    let length = measure::length_us(trace);
    let tallies = measure::wire_tallies(trace);
    for (index, (wire, t)) in trace
        .header
        .wires
        .iter()
        .zip(&tallies)
        .take(MEMBERS)
        .enumerate()
    {
        // Nanoseconds over microseconds is thousandths; a percent of it is five digits further.
        let duty = (u128::from(t.high_ns) * 100).checked_div(u128::from(length));
        let duty = duty.map_or_else(
            || "-".to_owned(),
            |d| milli(i64::try_from(d).unwrap_or(i64::MAX)),
        );
        let hottest = t
            .hottest_milli_c
            .map_or_else(|| "-".to_owned(), |c| milli(i64::from(c)));
        put(
            out,
            &format!(
                "{index:>4}  {:<9} {:<21} {:>6} {:>7} {:>7} {:>7} {duty:>8} % {hottest:>7} C",
                format!("{}:{}", wire.board, wire.channel),
                place(wire.place),
                t.bursts,
                t.limited,
                seconds(t.burst_us),
                t.widest,
            ),
        );
    }
    more(out, tallies.len(), MEMBERS);
}
