//! Tests of `can_log.rs`.

use palpate_core::codec::can::CanFrame;
use palpate_files::{LONGEST_LINE, Lines, Text, Times, USUAL_BITRATE};
use palpate_records::mcap::{BusTraffic, McapRecording};

use super::super::pass::Log;
use super::*;

#[derive(Debug)]
struct Seen {
    frames: Vec<Received>,
    notes: Vec<String>,
}

fn log(text: &str, buses: usize) -> Result<Seen, FileError> {
    seen(text, buses, Times::default())
}

fn seen(text: &str, buses: usize, times: Times) -> Result<Seen, FileError> {
    let lines = Lines::over(Text::new("a.log", text.as_bytes(), LONGEST_LINE));
    let pass = Pass::Log(Log::new(lines, times));
    let (mut through, _, notes) = pass.through((buses, USUAL_BITRATE), 100, false)?;
    let mut frames = through.held.take().unwrap();
    frames.iter_mut().for_each(|f| through.start.place(f));
    Ok(Seen { frames, notes })
}

#[test]
fn a_log_of_a_wall_clock_starts_within_its_first_second_and_buses_go_by_name() {
    let text =
        "(1436509052.249713) can10 104#938406805591BB0C\n(1436509053.000001) can2 004#00 R\n";
    let frames = log(text, 2).unwrap().frames;
    let seen: Vec<_> = frames.iter().map(|r| (r.at.as_micros(), r.bus)).collect();
    assert_eq!(seen, [(249_713, 1), (1_000_001, 0)]);
}

#[test]
fn what_was_written_is_read_again() {
    let text = "(0000000000.000116) can0 104#938406805591BB0C\n(0000000003.000000) can1 20F#0700\n";
    let mut again = Vec::new();
    write_can_log(&log(text, 2).unwrap().frames, &[], &mut again).unwrap();
    assert_eq!(String::from_utf8(again).unwrap(), text);
}

#[test]
fn a_cut_is_noted_with_its_line() {
    let read = log("(1.000000) can0 104#00\n(1.0001", 1).unwrap();
    assert_eq!(read.frames.len(), 1);
    assert_eq!(
        read.notes,
        ["a.log:2: the log is cut short in this line; read the 1 frames before it"]
    );
}

#[test]
fn bad_logs_are_named_with_their_line() {
    let told = |text, buses| log(text, buses).unwrap_err().to_string();
    assert_eq!(
        told("(1.000000) can0 104#00\n(2) can0\n", 1),
        "a.log:2: expected a time `(seconds.microseconds)` with six or nine decimals, found `(2) can0` after 1 whole frames"
    );
    assert_eq!(
        told("(1.000000) can0 104#00\n(1.000000) can1 104#00", 1),
        "a.log: expected at most 1 interfaces, as the layout has buses, found 2: can0, can1"
    );
    assert_eq!(
        told("(1.000000) can0 104#R\n", 1),
        "a.log: expected classic data frames with 11-bit identifiers, found none: 1 frames of another kind (29-bit, remote, error, CAN FD, CAN XL) were passed over"
    );
}

#[test]
fn what_a_log_holds_beside_frames_is_said() {
    let text = "# bench restarted\n(1.000000) can0 104#00\nDROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)\n\
                (1.000001) can0 123#81:00:12345678#112233\n(1.000001) can0 12345#81:00:12345678#112233\n";
    let error = log(text, 1).unwrap_err().to_string();
    assert!(
        error.starts_with("a.log:4: expected up to eight bytes"),
        "{error}"
    );
    let read = log(&text.replace(" 123#81", " 12323#81"), 1).unwrap();
    assert_eq!(read.frames.len(), 1);
    assert_eq!(
        read.notes,
        [
            "a.log: 3 frames were lost to the logger, 2 frames of another kind (29-bit, remote, error, CAN FD, CAN XL) were passed over, 1 remark was passed over"
        ]
    );
}

/// A Pi's clock stands at 1970 until its time server answers.
#[test]
fn a_clock_that_jumps_is_named_by_its_line() {
    let text =
        "(12.000000) can0 104#00\n(12.010000) can0 104#01\n(1700000000.000000) can0 104#02\n";
    let said = log(text, 1).unwrap_err().to_string();
    assert!(
        said.starts_with("a.log:3: expected a time near the one before"),
        "{said}"
    );
    assert!(
        said.ends_with("found a jump of the clock, 53.9 years ahead"),
        "{said}"
    );
    let read = seen(text, 1, Times::new(true)).unwrap();
    let at: Vec<_> = read.frames.iter().map(|r| r.at.as_micros()).collect();
    assert_eq!(at, [0, 10_000, 20_000]);
    assert_eq!(
        read.notes,
        [
            "a.log:3: a jump of the clock, 53.9 years ahead taken out: a new piece, joined at 0.020 s of the run"
        ]
    );
}

/// Two adapters stamp frames by the time since each was plugged in.
#[test]
fn a_bus_with_a_clock_of_its_own_is_named_and_put_beside_the_others() {
    let text = "(12.000000) can0 104#00\n(7212.000100) can1 204#00\n(12.010000) can0 104#01\n(7212.010100) can1 204#01\n";
    let said = log(text, 2).unwrap_err().to_string();
    assert!(
        said.starts_with("a.log:2: expected one clock for all buses (--split-jumps"),
        "{said}"
    );
    assert!(
        said.ends_with("found a clock of its own of `can1`, 2.0 hours ahead"),
        "{said}"
    );
    let read = seen(text, 2, Times::new(true)).unwrap();
    let at: Vec<_> = read
        .frames
        .iter()
        .map(|r| (r.at.as_micros(), r.bus))
        .collect();
    assert_eq!(at, [(0, 0), (0, 1), (10_000, 0), (10_000, 1)]);
    assert_eq!(
        read.notes,
        [
            "a.log:2: a clock of its own of `can1`, 2.0 hours ahead: its first frame is put at the newest one of the others"
        ]
    );
}

/// Frames of several buses are a little out of order; a long recording plays them like a held one.
#[test]
fn a_long_recording_plays_the_same_frames_in_the_same_order() {
    let path = std::env::temp_dir().join(format!("palpate-long-{}.log", std::process::id()));
    let line = |n: u64| {
        let us = 1_700_000_000_000_000 + n * 1000 + (n * 7919 % 13) * 50_000;
        let (s, us) = (us / 1_000_000, us % 1_000_000);
        format!("({s}.{us:06}) can{} 104#{n:04X}\n", 1 + n % 2)
    };
    std::fs::write(&path, (0..5000).map(line).collect::<String>()).unwrap();
    let held = read_can_recording(&path, (2, USUAL_BITRATE), false).unwrap();
    let pass = Pass::open(&path, false).unwrap();
    let (through, ..) = pass.through((2, USUAL_BITRATE), 100, false).unwrap();
    assert!(through.held.is_none());
    let long = LongRecording {
        path: path.clone(),
        split_jumps: false,
        rows: through.rows.most(),
        end: through.start.time(through.newest_us),
        start: through.start,
    };
    let all = |source: &dyn FrameSource| -> Vec<Received> {
        source.frames().unwrap().map(Result::unwrap).collect()
    };
    assert_eq!(all(&long), all(&*held.frames));
    assert_eq!(
        (long.rows(), long.end()),
        (held.frames.rows(), held.frames.end())
    );
    std::fs::remove_file(&path).unwrap();
}

/// Buses keep their numbers in an MCAP file, whichever comes first.
#[test]
fn a_bus_with_a_clock_of_its_own_is_named_in_mcap_as_in_a_log() {
    let path = std::env::temp_dir().join(format!("palpate-clocks-{}.mcap", std::process::id()));
    let frame = |us: u64, bus: u8| Received {
        at: Instant::from_micros(us),
        bus,
        frame: CanFrame::new(0x104, &[bus]).unwrap(),
    };
    let frames = [
        frame(12_000_000, 1),
        frame(7_212_000_100, 0),
        frame(12_010_000, 1),
        frame(7_212_010_100, 0),
    ];
    let names = ["can0".to_owned(), "can1".to_owned()];
    let mut recording = McapRecording::of_buses(&names, Vec::new()).unwrap();
    let traffic = BusTraffic {
        can: &frames,
        ..BusTraffic::default()
    };
    recording.piece(&[], traffic).unwrap();
    std::fs::write(&path, recording.finish().unwrap()).unwrap();
    let said = read_can_recording(&path, (2, USUAL_BITRATE), false).unwrap_err();
    let said = said.to_string();
    assert!(said.contains("expected one clock for all buses"), "{said}");
    assert!(
        said.ends_with("found frame 2: a clock of its own of `bus 0`, 2.0 hours ahead"),
        "{said}"
    );
    let read = read_can_recording(&path, (2, USUAL_BITRATE), true).unwrap();
    let at: Vec<_> = read.frames.frames().unwrap().map(Result::unwrap).collect();
    let at: Vec<_> = at.iter().map(|r| (r.at.as_micros(), r.bus)).collect();
    // At one time the file's order stays.
    assert_eq!(at, [(0, 1), (0, 0), (10_000, 1), (10_000, 0)]);
    std::fs::remove_file(&path).unwrap();
}
