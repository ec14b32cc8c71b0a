//! Tests of `journal.rs`.

use std::os::fd::AsRawFd;

use palpate_records::mcap::{self, BusTraffic, write_mcap};
use palpate_records::readings::Readings;
use palpate_records::trace::{DisplayInfo, Trace};
use palpate_records::{contacts_csv, schedule, vcd};

use palpate_core::codec::can::CanFrame;
use palpate_core::units::Instant;

use super::*;
use crate::output::Outputs;
use crate::record::sink::About;
use palpate_files::{Format, Setup};
use palpate_run::{Input, Keep, KeptReadings, run_with};

/// A frame.
fn frame() -> Received {
    Received {
        at: Instant::ZERO,
        bus: 0,
        frame: CanFrame::new(1, &[]).unwrap(),
    }
}

/// A run of an emulated bench; its pieces could have come from a real one.
fn run() -> (Trace, Vec<Received>, Readings) {
    let setup = Setup::load("sphere-along", "emulated").unwrap();
    let keep = Keep {
        can: true,
        readings: KeptReadings::All,
        ..Keep::default()
    };
    let outcome = run_with(&setup, &Input::Scene, 1, keep, &mut ()).unwrap();
    (outcome.trace, outcome.can, outcome.readings.unwrap())
}

#[test]
fn pieces_make_the_same_files_as_a_whole_run() {
    let (trace, frames, readings) = run();
    let folder = std::env::temp_dir().join(format!("palpate-journal-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = |name: &str| folder.join(name);
    let files = [
        (Format::Contacts, path("c.csv")),
        (Format::Schedule, path("s.jsonl")),
        (Format::Vcd, path("v.vcd")),
        (Format::Mcap, path("m.mcap")),
    ];
    let about = About::Run(&trace.header, readings.modules(), &[]);
    let mut journal = Journal::start(
        Sink::create_all(&files, &about, Outputs::default()).unwrap(),
        false,
    )
    .unwrap();
    let (mut told, mut sent, mut read) = (0, 0, 0);
    for end in 0..=trace.events.len() {
        let at = |i: usize| trace.events.get(i).map(Event::t_ns);
        if end == trace.events.len() || at(end) != at(end.wrapping_sub(1)) {
            let until = at(end).unwrap_or(u64::MAX);
            let due = frames[sent..].iter();
            let due = due.take_while(|f| f.at.as_micros() * 1000 < until);
            let due: Vec<_> = due.copied().collect();
            sent += due.len();
            let taxels = readings.frames()[read..].iter();
            let taxels = taxels.take_while(|f| f.t_us * 1000 < until);
            let taxels: Vec<_> = taxels.cloned().collect();
            read += taxels.len();
            journal.add(&trace.events[told..end], due, taxels);
            told = end;
            // The thread may be slower than this loop; nothing here is to be dropped.
            while !journal.waiting.events.is_empty() {
                std::thread::yield_now();
                journal.add(&[], vec![], vec![]);
            }
        }
    }
    journal.finish().unwrap();
    let (mut contacts, mut plan) = (Vec::new(), Vec::new());
    contacts_csv::write_table(&trace, &mut contacts).unwrap();
    schedule::write_schedule(&trace, &mut plan).unwrap();
    assert_eq!(std::fs::read(path("c.csv")).unwrap(), contacts);
    assert_eq!(std::fs::read(path("s.jsonl")).unwrap(), plan);
    let mut dump = Vec::new();
    vcd::write_vcd(&trace, &mut dump).unwrap();
    let written = std::fs::read(path("v.vcd")).unwrap();
    // A growing dump ends with its last event, a whole one with the run.
    assert!(dump.starts_with(&written) || written.starts_with(&dump));
    let grown = mcap::read(&std::fs::read(path("m.mcap")).unwrap()).unwrap();
    let mut whole = Vec::new();
    let traffic = BusTraffic {
        can: &frames,
        ..BusTraffic::default()
    };
    write_mcap((&trace, Some(&readings)), traffic, &[], &mut whole).unwrap();
    let whole = mcap::read(&whole).unwrap();
    assert_eq!(
        (grown.frames, grown.messages),
        (whole.frames, whole.messages)
    );
    // The module of the scene is read at 100 Hz for ten seconds.
    assert!(read > 900, "{read} scans");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn contacts_of_several_displays_name_theirs_as_a_whole_run_does() {
    let mut trace = run().0;
    let display = |name: &str, module| DisplayInfo {
        name: name.to_owned(),
        wires: 8,
        modules: vec![module],
    };
    trace.header.displays = vec![display("thumb", 1), display("index", 0)];
    let path = std::env::temp_dir().join(format!("palpate-displays-{}.csv", std::process::id()));
    let files = [(Format::Contacts, path.clone())];
    let about = About::Run(&trace.header, &[], &[]);
    let sinks = Sink::create_all(&files, &about, Outputs::default()).unwrap();
    let mut journal = Journal::start(sinks, false).unwrap();
    journal.add(&trace.events, vec![], vec![]);
    journal.finish().unwrap();
    let mut whole = Vec::new();
    contacts_csv::write_table(&trace, &mut whole).unwrap();
    let written = std::fs::read(&path).unwrap();
    assert!(written.ends_with(b",index\n"));
    assert_eq!(written, whole);
    let sidecar = path.with_extension("schema.json");
    let schema = std::fs::read_to_string(&sidecar).unwrap();
    assert!(schema.contains("\"name\": \"display\""), "{schema}");
    std::fs::remove_file(path).unwrap();
    std::fs::remove_file(sidecar).unwrap();
}

#[test]
fn a_full_disk_is_noticed() {
    let header = run().0.header;
    for kind in [Format::Contacts, Format::Mcap, Format::Vcd] {
        let files = [(kind, PathBuf::from("/dev/full"))];
        let refused = Sink::create_all(&files, &About::Run(&header, &[], &[]), Outputs::default());
        assert_eq!(refused.err().unwrap().status(), 3, "{kind:?}");
    }
}

#[test]
fn a_disk_that_does_not_follow_costs_frames_and_no_time() {
    let (pieces, stuck) = sync_channel(2);
    let mut journal = Journal {
        pieces: Some(pieces),
        thread: None,
        written: sync_channel(1).1,
        stream: None,
        failed: Arc::default(),
        waiting: Piece::default(),
        dropped: 0,
    };
    let note = Event::Note(event::Note {
        t_us: 0,
        text: "kept".into(),
    });
    let events = vec![note; 100];
    for turn in 0..100 {
        journal.add(&events[turn..=turn], vec![frame(); 1000], vec![]);
    }
    let held = 2 * 1000 + WAITING as u64;
    assert_eq!(journal.dropped(), 100_000 - held);
    let mut kept: usize = stuck.try_iter().map(|p| p.events.len()).sum();
    kept += journal.waiting.events.len();
    assert_eq!(kept, 100, "events are never left out");
}

#[test]
fn a_pipe_that_nobody_reads_is_given_up_at_the_end() {
    let (reader, writer) = io::pipe().unwrap();
    let path = PathBuf::from(format!("/proc/self/fd/{}", writer.as_raw_fd()));
    let names = ["test0".to_owned()];
    let files = [(Format::Candump, path)];
    let sinks = Sink::create_all(&files, &About::Buses(&names), Outputs::default()).unwrap();
    let mut journal = Journal::start(sinks, false).unwrap();
    for _ in 0..10 {
        journal.add(&[], vec![frame(); 1000], vec![]);
    }
    let said = journal.finish().unwrap_err();
    assert_eq!(said.status(), 3);
    assert!(said.to_string().contains("nobody has read it"), "{said}");
    drop(reader);
}
