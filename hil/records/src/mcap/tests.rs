//! What is written is read again, as far as it is whole.

use palpate_core::codec::can::CanFrame;
use palpate_core::skin::{Layout, Module, RelativeFrame};
use palpate_core::units::Instant;

use super::*;
use crate::synthetic;

fn frames(n: u64) -> Vec<Received> {
    let frame = |k: u64| Received {
        at: Instant::from_micros(k * 417),
        bus: (k % 4) as u8,
        frame: CanFrame::new(0x104 + (k % 16) as u16, &k.to_le_bytes()).unwrap(),
    };
    (0..n).map(frame).collect()
}

fn file(frames: &[Received]) -> Vec<u8> {
    let trace = synthetic::circle(2);
    let attachment = Attachment {
        name: "scene.toml".into(),
        media_type: "application/toml",
        text: "name = \"circle\"\n".into(),
    };
    let traffic = BusTraffic {
        can: frames,
        ..BusTraffic::default()
    };
    let mut out = Vec::new();
    write_mcap((&trace, None), traffic, &[attachment], &mut out).unwrap();
    out
}

#[test]
fn frames_metadata_and_files_survive_the_round_trip() {
    let frames = frames(50_000);
    let bytes = file(&frames);
    let read = read(&bytes).unwrap();
    assert_eq!(read.damages, []);
    assert_eq!(read.frames, frames);
    assert_eq!(read.metadata["source"], "emulated");
    assert_eq!(read.metadata["version"], VERSION.to_string());
    assert_eq!(read.attachments[0].0, "scene.toml");
    assert_eq!(read.attachments[0].1, b"name = \"circle\"\n");
    assert!(read.messages > 50_000);
    assert_eq!(bytes, file(&frames), "the same run gives the same bytes");
}

#[test]
fn a_recording_that_was_cut_opens_up_to_the_cut() {
    let frames = frames(50_000);
    let bytes = file(&frames);
    let mut before = 0;
    for part in 1..=20 {
        let cut = bytes.len() * part / 20 - 3;
        let Ok(read) = read(&bytes[..cut]) else {
            assert!(cut < 8192, "nothing was saved of {cut} bytes");
            continue;
        };
        assert_eq!(read.frames, frames[..read.frames.len()]);
        assert!(read.frames.len() >= before);
        before = read.frames.len();
        let last = read.damages.last().unwrap();
        assert!(last.offset <= cut as u64, "{last}");
    }
    assert_eq!(before, frames.len(), "only the summary was missing");
}

#[test]
fn a_damaged_chunk_is_named_and_the_others_are_read() {
    let frames = frames(50_000);
    let mut bytes = file(&frames);
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x10;
    let read = read(&bytes).unwrap();
    let [damage] = read.damages.as_slice() else {
        panic!("{:?}", read.damages);
    };
    assert!(damage.what.contains("checksum"), "{damage}");
    assert!(damage.offset < middle as u64);
    assert!(
        (20_000..50_000).contains(&read.frames.len()),
        "{}",
        read.frames.len()
    );
}

#[test]
fn no_bytes_make_the_reader_panic() {
    let bytes = file(&frames(300));
    let mut state = 1_u64;
    for _ in 0..3000 {
        let mut hostile = bytes.clone();
        for _ in 0..4 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let place = (state >> 33) as usize % hostile.len();
            hostile[place] = (state >> 25) as u8;
        }
        let _ = read(&hostile);
    }
}

#[test]
fn strangers_are_refused_by_name() {
    let told = |bytes: &[u8]| {
        let e = read(bytes).unwrap_err();
        format!("expected {}, found {}", e.expected, e.found)
    };
    assert_eq!(told(b"hello"), "expected an MCAP file, found byte 0: hello");
    let mut other = file(&[]);
    let place = other
        .windows(12)
        .position(|w| w == b"\x07\0\0\0version\x01")
        .unwrap();
    other[place + 15] = b'9';
    assert!(told(&other).contains("version 9"), "{}", told(&other));
    let mut foreign = Container::begin(Vec::new(), "ros2", "other").unwrap();
    let schema = foreign.schema("std_msgs/String", b"string data").unwrap();
    foreign.channel(schema, "/chatter").unwrap();
    let foreign = foreign.finish().unwrap();
    assert!(told(&foreign).contains("/chatter"), "{}", told(&foreign));
}

#[test]
fn taxels_come_whole_and_their_pictures_at_most_25_times_per_second() {
    let trace = synthetic::circle(2);
    let layout = Layout::single(Module::grid("pad", 4, 4, 4.7).unwrap()).unwrap();
    let frame = RelativeFrame::new(&layout);
    let mut readings = Readings::whole(&layout, 0);
    (0..200).for_each(|n| readings.push(n * 10_000, &frame));
    let messages = |readings| {
        let mut out = Vec::new();
        write_mcap((&trace, readings), BusTraffic::default(), &[], &mut out).unwrap();
        read(&out).unwrap().messages
    };
    assert_eq!(messages(Some(&readings)) - messages(None), 200 + 50);
}
