//! Tests of `live.rs`.

use std::os::fd::OwnedFd;
use std::os::unix::net::UnixDatagram;

use palpate_buses::can::Endpoint;

use super::*;
use crate::output::Outputs;
use crate::recording::read_can_recording;
use palpate_files::USUAL_BITRATE;

/// What comes over a bus is in the files, with times of the wall clock, and can be read again.
#[test]
fn a_bus_is_recorded_in_both_formats() {
    let (ours, theirs) = UnixDatagram::pair().unwrap();
    ours.set_nonblocking(true).unwrap();
    let endpoint = Endpoint::from(OwnedFd::from(ours));
    let clock = RunClock::start();
    let can = CanBuses::over(vec![("test0".into(), vec![], endpoint)], clock).unwrap();
    let folder = std::env::temp_dir().join(format!("palpate-live-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let files = [
        (Format::Candump, folder.join("a.log")),
        (Format::Mcap, folder.join("a.mcap")),
    ];
    let names = ["test0".to_owned()];
    let sinks = Sink::create_all(&files, &About::Buses(&names), Outputs::default()).unwrap();
    let journal = Journal::start(sinks, false).unwrap();
    for n in 0..100_u8 {
        let mut raw = [0; 16];
        raw[..4].copy_from_slice(&4_u32.to_ne_bytes());
        raw[4] = 8;
        raw[8] = n;
        theirs.send(&raw).unwrap();
    }
    let epoch_us = 1_700_000_000_000_000;
    let stop = |now: Instant| now >= Instant::from_micros(300_000);
    let recorded = listen(can, journal, &names, (clock, epoch_us), stop).unwrap();
    assert_eq!((recorded.frames, recorded.frames_not_recorded), (100, 0));
    let text = std::fs::read_to_string(&files[0].1).unwrap();
    assert!(
        text.starts_with("(1700000000.") && text.contains(" test0 004#"),
        "{text}"
    );
    let log = read_can_recording(&files[0].1, (1, USUAL_BITRATE), false).unwrap();
    let mcap = read_can_recording(&files[1].1, (1, USUAL_BITRATE), false).unwrap();
    let frames = |source: &crate::recording::CanRecording| -> Vec<Received> {
        let frames = source.frames.frames().unwrap();
        frames.map(Result::unwrap).collect()
    };
    assert_eq!(frames(&log), frames(&mcap));
    assert_eq!(
        (&log.interfaces, &log.notes),
        (&mcap.interfaces, &mcap.notes)
    );
    assert_eq!((frames(&log).len(), &log.interfaces[0][..]), (100, "test0"));
    for (n, received) in frames(&log).iter().enumerate() {
        assert_eq!(usize::from(received.frame.data()[0]), n);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
