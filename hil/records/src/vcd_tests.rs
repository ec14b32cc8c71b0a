//! Tests of `vcd.rs`.

use std::collections::BTreeSet;

use super::*;
use crate::synthetic;
use crate::trace::Source;
use palpate_core::schedule::Entry;
use palpate_core::units::{Board, Channel, Instant, Ticks};

fn dump(trace: &Trace) -> String {
    let mut out = Vec::new();
    write_vcd(trace, &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

#[test]
fn a_parser_of_others_reads_every_change() {
    let trace = synthetic::circle(2);
    let text = dump(&trace);
    let mut parser = vcd::Parser::new(text.as_bytes());
    let header = parser.parse_header().unwrap();
    assert_eq!(header.timescale, Some((1, vcd::TimescaleUnit::NS)));
    assert_eq!(header.date, None);
    let of = |path: &[&str]| header.find_var(path).unwrap().code;
    let wire = of(&["emulated", "wire2", "wire_celsius"]);
    let on = of(&["emulated", "wire2", "on_ticks"]);
    of(&["emulated", "wire0", "pin_b0_ch0"]);
    let (mut hottest, mut changes, mut last) = (0.0_f64, 0, 0);
    for command in parser {
        match command.unwrap() {
            vcd::Command::Timestamp(t) => {
                assert!(t >= last);
                last = t;
            }
            vcd::Command::ChangeReal(id, value) if id == wire => hottest = hottest.max(value),
            vcd::Command::ChangeVector(id, _) if id == on => changes += 1,
            _ => {}
        }
    }
    let expected = trace.events.iter().filter_map(|e| match e {
        Event::Wire(event::Temperature {
            wire: 2, milli_c, ..
        }) => Some(*milli_c),
        _ => None,
    });
    assert_eq!((hottest * 1e3).round() as i32, expected.max().unwrap());
    let entries = trace.events.iter().filter(
        |e| matches!(e, Event::Schedule(e) if (e.board, e.channel) == (Board(0), Channel(2))),
    );
    assert!(changes > entries.count());
    assert!(last >= trace.ledger.length_us * 1000);
}

#[test]
fn a_real_run_declares_only_what_was_commanded_and_late_events_do_not_turn_time_back() {
    let mut trace = synthetic::empty();
    trace.header.source = Source::Real;
    trace.header.wires = synthetic::circle(1).header.wires;
    let entry = |t_us, off| {
        Event::Schedule(Entry {
            at: Instant::from_micros(t_us),
            board: Board(0),
            channel: Channel(0),
            on: 0,
            off,
            until: Instant::from_micros(t_us),
            requested: Ticks::new(off),
            requested_until: Instant::from_micros(t_us),
            current: None,
            reason: None,
        })
    };
    trace.events = vec![entry(20, 100), entry(10, 4096)];
    trace.ledger.length_us = 30;
    let text = dump(&trace);
    assert!(
        !text.contains("pin_") && !text.contains("celsius"),
        "{text}"
    );
    let tail = text.split_once("$dumpvars").unwrap().1;
    let tail = tail.split_once("$end\n").unwrap().1;
    assert_eq!(
        tail,
        "#20000\nb0 \"\nb1100100 #\nb0 \"\nb1000000000000 #\n#30000\n"
    );
}

#[test]
fn codes_are_printable_and_never_the_same() {
    let codes: BTreeSet<_> = (0..20_000).map(|n| Code(n).to_string()).collect();
    assert_eq!(codes.len(), 20_000);
    assert!(
        codes
            .iter()
            .all(|c| c.bytes().all(|b| (33..=126).contains(&b)))
    );
}
