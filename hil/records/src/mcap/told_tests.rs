//! What was written of a run is told again.

use super::*;
use crate::mcap::{BusTraffic, McapReader, write_mcap};
use crate::synthetic;
use crate::trace::Trace;

fn file(trace: &Trace) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_mcap((trace, None), BusTraffic::default(), &[], &mut bytes).unwrap();
    bytes
}

fn told(bytes: &[u8]) -> Vec<Told> {
    let mut reader = McapReader::of_run(bytes).unwrap();
    std::iter::from_fn(|| reader.told().unwrap()).collect()
}

/// What an event is when it is read again; none where no topic has it.
fn again(event: &Event, trace: &Trace) -> Option<Told> {
    Some(match event.clone() {
        Event::Edge(event::Edge {
            t_ns,
            board,
            channel,
            high,
        }) => {
            let wires = trace.header.wires.iter();
            let mut numbered = wires.zip(0..);
            let here = numbered.find(|(w, _)| (w.board, w.channel) == (board, channel))?;
            let wire = here.1;
            Told::Pin { t_ns, wire, high }
        }
        Event::AllOff(event::AllOff { t_us, cause, .. }) => Told::Event(Event::Note(event::Note {
            t_us,
            text: format!("all off: {cause}"),
        })),
        Event::Latent(_) | Event::Joint(_) | Event::Face(_) => return None,
        event => Told::Event(event),
    })
}

#[test]
fn every_event_comes_again_in_its_order() {
    let trace = synthetic::circle(2);
    let expected: Vec<Told> = trace
        .events
        .iter()
        .filter_map(|e| again(e, &trace))
        .collect();
    let found = told(&file(&trace));
    assert!(found.len() > 1000, "{}", found.len());
    for (found, expected) in found.iter().zip(&expected) {
        assert_eq!(found, expected);
    }
    assert_eq!(found.len(), expected.len());
}

#[test]
fn reading_goes_on_from_any_place_between_two_records() {
    let bytes = file(&synthetic::circle(20));
    let mut reader = McapReader::of_run(&*bytes).unwrap();
    let (mut all, mut places) = (Vec::new(), Vec::new());
    loop {
        places.extend(reader.between().map(|offset| (offset, all.len())));
        match reader.told().unwrap() {
            Some(told) => all.push(told),
            None => break,
        }
    }
    assert!(places.len() > 2, "{places:?}");
    for (offset, before) in places {
        let rest = &bytes[offset as usize..];
        let mut resumed = reader.resumed(rest, offset);
        let rest: Vec<Told> = std::iter::from_fn(|| resumed.told().unwrap()).collect();
        assert!(rest == all[before..], "from byte {offset}");
    }
}

#[test]
fn what_is_no_message_of_its_topic_is_left_out() {
    let damaged: [(&str, &[u8]); 4] = [
        ("/frames", &[0x08]),
        // A module of 2^20.
        ("/contacts", &[0x10, 0x80, 0x80, 0x40]),
        ("/wire/0/schedule", &[0x08, 0x80, 0x80, 0x40]),
        // A taxel of 2^20 counts.
        ("/taxels/0", &[0x22, 0x03, 0x80, 0x80, 0x40]),
    ];
    for (name, message) in damaged {
        assert_eq!(Topic::named(name).read(0, message), None, "{name}");
    }
    for name in [
        "/wire/x/pin",
        "/wire/1",
        "/taxels/",
        "/skin/0",
        "/i2c",
        "/frames/7",
        "/3/contacts",
    ] {
        assert_eq!(Topic::named(name).read(0, &[0x08]), Some(None), "{name}");
    }
}
