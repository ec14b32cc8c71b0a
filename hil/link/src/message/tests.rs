//! Tests of the messages: out and in again, and whatever bytes come.

use palpate_core::contact::Contact;
use palpate_core::units::Point;
use palpate_records::mcap::proto::Message;
use palpate_records::mcap::{MessageSchema, decode, encoded};
use palpate_records::trace::event;
use proptest::prelude::*;

use super::*;
use crate::judge::Head;

fn head() -> Head {
    Head {
        version: VERSION,
        session: u64::MAX,
        sequence: 300,
        sent_us: 1 << 40,
        taken_us: (1 << 40) - 1,
        layout: 0x1234_5678_9abc_def0,
    }
}

fn contact(id: u32) -> Contact {
    Contact {
        id,
        module: 2,
        place: Point::new(-7.05, 0.0),
        intensity: 412.5,
        level: 3,
        members: 5,
        ..Contact::default()
    }
}

fn bytes(frame: &Frame) -> Vec<u8> {
    let mut message = Message::default();
    frame.write(&mut message);
    message.bytes().to_vec()
}

#[test]
fn frames_come_back_as_they_went() {
    let truth = Some(Truth {
        at: [1.5, -2.0],
        force_n: 0.7,
    });
    for contacts in [vec![], vec![contact(1)], (1..=16).map(contact).collect()] {
        let frame = Frame {
            head: head(),
            body: Body::Touched(contacts),
            truth,
            flexed: 0,
        };
        assert_eq!(Frame::touched(&bytes(&frame)), Some(frame));
    }
    let counts = (0..16_u16).map(|i| [32_768 + i, 0, 65_535 - i]).collect();
    let frame = Frame {
        head: head(),
        body: Body::Scanned { module: 3, counts },
        truth: None,
        flexed: 0,
    };
    assert_eq!(Frame::scanned(&bytes(&frame)), Some(frame));
}

#[test]
fn contacts_are_twenty_times_fewer_bytes_than_scans_of_a_hand() {
    let touched = Frame {
        head: head(),
        body: Body::Touched(vec![contact(1)]),
        truth: None,
        flexed: 0,
    };
    let counts = vec![[33_000; 3]; 368];
    let scanned = Frame {
        head: head(),
        body: Body::Scanned { module: 0, counts },
        truth: None,
        flexed: 0,
    };
    assert!(bytes(&scanned).len() > 20 * bytes(&touched).len());
}

#[test]
fn wearers_echoes_and_publishers_come_back_as_they_went() {
    let mut wearer = Wearer {
        version: VERSION,
        session: 5,
        said_us: 77,
        feels: 9,
        refused: vec![1, 2],
        stopped: "stopped by SIGINT".into(),
        trouble: String::new(),
    };
    assert_eq!(decode::<Wearer>(encoded(&mut wearer).bytes()), Some(wearer));
    let mut echo = Echo {
        version: VERSION,
        session: 1,
        wearer: 2,
        said_us: 3,
        heard_us: 4,
    };
    assert_eq!(decode::<Echo>(encoded(&mut echo).bytes()), Some(echo));
    let mut about = About {
        version: VERSION,
        session: 1,
        layout: 2,
        layout_name: "uskin-4x4".into(),
        scene: "sphere-along".into(),
        kind: "scans".into(),
        rest: vec![vec![1, 2], vec![]],
    };
    // An empty field is none.
    let mut expected = about.clone();
    expected.rest.pop();
    assert_eq!(decode::<About>(encoded(&mut about).bytes()), Some(expected));
}

#[test]
fn a_frame_of_too_many_contacts_is_none() {
    let frame = Frame {
        head: head(),
        body: Body::Touched((0..257).map(contact).collect()),
        truth: None,
        flexed: 0,
    };
    assert_eq!(Frame::touched(&bytes(&frame)), None);
}

#[test]
fn refused_publishers_stand_one_by_one_and_there_are_eight_at_most() {
    let mut wearer = Wearer {
        version: 1,
        refused: vec![1, 0, 300],
        trouble: "a".into(),
        ..Wearer::default()
    };
    let bytes = [8, 1, 0x28, 1, 0x28, 0xac, 2, 0x3a, 1, b'a'];
    assert_eq!(encoded(&mut wearer).bytes(), bytes);
    let eight: Vec<u64> = (1..=8).collect();
    wearer.refused = (1..=9).collect();
    let written: Wearer = decode(encoded(&mut wearer).bytes()).unwrap();
    assert_eq!(written.refused, eight);
    let nine: Vec<u8> = (1..=9).flat_map(|session| [0x28, session]).collect();
    assert_eq!(decode::<Wearer>(&nine).unwrap().refused, eight);
}

#[test]
fn an_empty_truth_is_another_than_none() {
    let frame = Frame {
        head: Head::default(),
        body: Body::Touched(vec![]),
        truth: Some(Truth::default()),
        flexed: 0,
    };
    assert_eq!(bytes(&frame), [0x3a, 0]);
    assert_eq!(Frame::touched(&[0x3a, 0]), Some(frame));
    assert_eq!(Frame::touched(&[]).unwrap().truth, None);
}

#[test]
fn contacts_and_truth_have_the_fields_of_a_recording() {
    let recorded = MessageSchema::describe(event::Contact::default());
    assert_eq!(MessageSchema::describe(Contact::default()), recorded);
    let recorded = MessageSchema::describe(event::Truth::default());
    assert_eq!(MessageSchema::describe(Truth::default()), recorded);
}

#[test]
fn the_proto_file_says_what_is_repeated_and_what_is_inside() {
    let text = proto_file();
    assert!(text.starts_with("syntax = \"proto3\";\npackage palpate;\n\nmessage Contact {\n"));
    for line in [
        "  Truth truth = 7;",
        "  repeated Contact contacts = 8;",
        "  repeated uint32 x = 9;",
        "  repeated uint64 refused = 5;",
        "  repeated bytes rest = 7;",
        "  double force_n = 3;",
        "  string layout_name = 4;",
    ] {
        assert!(text.contains(line), "{line}");
    }
}

proptest! {
    #[test]
    fn no_bytes_are_a_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let _ = Frame::touched(&bytes);
        let _ = Frame::scanned(&bytes);
        let _ = decode::<Wearer>(&bytes);
        let _ = decode::<Echo>(&bytes);
        let _ = decode::<About>(&bytes);
    }

    #[test]
    fn a_bit_that_fell_over_is_another_frame_or_none(place in 0..200_usize, bit in 0..8_u32) {
        let frame = Frame { head: head(), body: Body::Touched(vec![contact(1), contact(2)]), truth: None, flexed: 0 };
        let mut bytes = bytes(&frame);
        let place = place % bytes.len();
        bytes[place] ^= 1 << bit;
        let _ = Frame::touched(&bytes);
    }
}
