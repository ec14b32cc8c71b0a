//! Tests of `mod.rs`.

use super::*;
use crate::synthetic;
use palpate_core::units::{Board, Channel, Instant, Ticks};

fn lines(trace: &Trace) -> Vec<serde_json::Value> {
    let mut out = Vec::new();
    write_schedule(trace, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    text.lines()
        .map(|l| serde_json::from_str(l).unwrap())
        .collect()
}

#[test]
fn every_line_is_json_of_integers_and_words_in_order() {
    let trace = synthetic::circle(2);
    let all = lines(&trace);
    assert_eq!(all[0]["version"], 2);
    assert_eq!(all[0]["seed"], trace.header.seed);
    assert!(all.len() > 50);
    let mut last = (0, 0);
    for line in &all[1..] {
        for (key, value) in line.as_object().unwrap() {
            assert!(
                value.is_u64() || value.is_string() || value.is_null(),
                "{key}: {value}"
            );
        }
        let key = (
            line["t_us"].as_u64().unwrap(),
            line["board"].as_u64().unwrap(),
        );
        assert!(key >= last);
        last = key;
    }
}

#[test]
fn the_record_is_spelled_as_promised() {
    let mut trace = synthetic::empty();
    let entry = |channel| {
        Event::Schedule(Entry {
            at: Instant::from_micros(0),
            board: Board(0),
            channel: Channel(channel),
            on: 256,
            off: 356,
            until: Instant::from_micros(35_000),
            requested: Ticks::new(100),
            requested_until: Instant::from_micros(35_000),
            current: None,
            reason: None,
        })
    };
    trace.events = vec![
        Event::AllOff(event::AllOff {
            t_us: 0,
            board: 0,
            cause: "start",
        }),
        Event::PreScale(event::PreScale {
            t_us: 0,
            board: 0,
            pre_scale: 30,
        }),
        entry(2),
        entry(1),
        Event::AllOff(event::AllOff {
            t_us: 0,
            board: 0,
            cause: "stop",
        }),
    ];
    let mut out = Vec::new();
    write_schedule(&trace, &mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    let body: Vec<_> = text.lines().skip(1).collect();
    let tail = r#""pulses":7,"on":256,"off":356,"period":5079040,"until_us":35000,"requested":100,"reason":null}"#;
    assert_eq!(
        body,
        [
            r#"{"t_us":0,"board":0,"all_off":"start"}"#.to_owned(),
            r#"{"t_us":0,"board":0,"pre_scale":30}"#.to_owned(),
            format!(r#"{{"t_us":0,"board":0,"channel":1,{tail}"#),
            format!(r#"{{"t_us":0,"board":0,"channel":2,{tail}"#),
            r#"{"t_us":0,"board":0,"all_off":"stop"}"#.to_owned(),
        ]
    );
}
