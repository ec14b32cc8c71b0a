//! Recordings whose chunks another program packed, in a page.

use std::io::Write;

use lz4_flex::frame::FrameEncoder;

use super::serve::{answer, recorded, served};
use super::*;

/// A recording with its chunks packed by lz4, and nothing else changed.
fn packed(file: &[u8]) -> Vec<u8> {
    let (magic, mut rest) = file.split_at(8);
    let mut packed = magic.to_vec();
    let wide = |bytes: &[u8]| u64::from_le_bytes(bytes.try_into().unwrap()) as usize;
    while rest.len() > 9 {
        let (record, after) = rest.split_at(9 + wide(&rest[1..9]));
        rest = after;
        if record[0] != 6 {
            packed.extend(record);
            continue;
        }
        // times, size and checksum, no packing, and the length of the records
        let (head, records) = (&record[9..37], &record[49..]);
        let mut frame = FrameEncoder::new(Vec::new());
        frame.write_all(records).unwrap();
        let frame = frame.finish().unwrap();
        let length = (frame.len() as u64).to_le_bytes();
        let body = [head, &[3, 0, 0, 0], b"lz4", &length, &frame].concat();
        packed.push(6);
        packed.extend((body.len() as u64).to_le_bytes());
        packed.extend(body);
    }
    packed.extend(rest);
    packed
}

#[test]
fn a_packed_recording_shows_the_moments_of_the_plain_one() {
    let folder = Folder::new("serve-packed");
    recorded(&folder, "plain.mcap", &[]);
    let plain = fs::read(folder.path("plain.mcap")).unwrap();
    let smaller = packed(&plain);
    assert!(smaller.len() < plain.len());
    fs::write(folder.path("packed.mcap"), smaller).unwrap();
    let run = served(
        &folder,
        &["serve", "plain.mcap", "packed.mcap", "--at", "0"],
    );
    let mut page = run.own_page();
    let mut moments = |recording: usize| {
        let hello = answer(&mut page, &format!("{{\"run\":{recording}}}"), "hello");
        assert!(hello["recording"]["damaged"].is_null(), "{hello}");
        [3_500_000, 1_000_000, 2_000_000]
            .map(|us| answer(&mut page, &format!("{{\"at_us\":{us}}}"), "moment"))
    };
    assert_eq!(moments(0), moments(1));
    assert_eq!(run.interrupted(), Some(0));
}
