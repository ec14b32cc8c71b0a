//! Tests of the link's bytes.

use alloc::vec::Vec;

use proptest::prelude::*;

use super::*;
use crate::guard::{Cause, CurrentControl, HARD, Plant};
use crate::peltier::PeltierReason;
use crate::units::{Board, Channel, Instant, Milliamps, Ticks};

const KEY: [u8; 32] = [7; 32];

const fn at(us: u64) -> Instant {
    Instant::from_micros(us)
}

fn header() -> impl Strategy<Value = Header> {
    const KINDS: &[Kind] = &[Kind::Knock, Kind::Hello, Kind::Command, Kind::Status];
    let kind = proptest::sample::select(KINDS);
    (kind, any::<u64>(), any::<u64>(), 0..FROM_UNIT).prop_map(|(kind, host, unit, sequence)| {
        Header {
            kind,
            host,
            unit,
            sequence,
        }
    })
}

fn planned() -> impl Strategy<Value = Planned> {
    (
        0..16u8,
        0..16u8,
        (0..4096u16, 0..4096u32),
        5_000_000..6_000_000u64,
        0..60_000u64,
    )
        .prop_map(|(board, channel, (width, current), from, length)| Planned {
            board: Board(board),
            channel: Channel(channel),
            width: Ticks::new(width),
            current: Milliamps(current),
            at: at(from),
            until: at(from + length),
        })
}

fn sealed(header: &Header, body: &[u8]) -> Vec<u8> {
    let mut buffer = [0; MOST];
    let write = |out: &mut [u8]| {
        out[..body.len()].copy_from_slice(body);
        body.len()
    };
    Key::new(&KEY).seal(header, &mut buffer, write).to_vec()
}

proptest! {
    #[test]
    fn what_was_sealed_opens_and_an_altered_bit_anywhere_does_not(
        header in header(),
        body in proptest::collection::vec(any::<u8>(), 0..200),
        bit in any::<prop::sample::Index>(),
    ) {
        let datagram = sealed(&header, &body);
        prop_assert_eq!(datagram.len(), HEADER + body.len() + TAG);
        let mut whole = datagram.clone();
        prop_assert_eq!(Header::read(&whole), Ok(header));
        let key = Key::new(&KEY);
        prop_assert_eq!(key.open(&mut whole), Ok(&*body));
        let mut altered = datagram.clone();
        let bit = bit.index(8 * altered.len());
        altered[bit / 8] ^= 1 << (bit % 8);
        prop_assert_eq!(key.open(&mut altered), Err(Refusal::Forged));
        let mut other = datagram;
        let mut wrong = KEY;
        wrong[31] ^= 1;
        prop_assert_eq!(Key::new(&wrong).open(&mut other), Err(Refusal::Forged));
    }

    #[test]
    fn commands_mean_what_was_written(
        plan in proptest::collection::vec(planned(), 0..=MOST_PLANNED),
        reading in any::<u64>(),
        stops in any::<u32>(),
        request in proptest::sample::select(&[Request::Play, Request::Off, Request::Stop][..]),
        warmth in proptest::option::of((1..u16::MAX, any::<u16>())),
    ) {
        let warmth = warmth.map(|(face_mc, ceiling_mc)| Warmth { face_mc, ceiling_mc });
        let said = Said { reading: at(reading), stops, request, warmth };
        let mut out = [0; MOST - HEADER - TAG];
        let length = Command::write(&mut out, &said, &plan);
        let command = Command::read(&out[..length]).unwrap();
        prop_assert_eq!(command.said, said);
        prop_assert_eq!(command.planned().collect::<Vec<_>>(), plan);
        prop_assert_eq!(Command::read(&out[..length - 1]), Err(Refusal::Body));
        prop_assert_eq!(Command::read(&out[..length + 1]), Err(Refusal::Body));
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in proptest::collection::vec(any::<u8>(), 0..300)) {
        let _ = Header::read(&bytes);
        if let Ok(command) = Command::read(&bytes) {
            prop_assert!(command.planned().count() <= MOST_PLANNED);
            prop_assert!(command.planned().all(|p| p.board.0 < 16 && p.until >= p.at));
        }
        let _ = Hello::read(&bytes);
        let _ = Status::read(&bytes);
    }
}

#[test]
fn reports_mean_what_was_written() {
    let mut out = [0; MOST - HEADER - TAG];
    let hello = Hello {
        now: at(123_456_789),
        busy: true,
        heat: false,
        warmth: true,
        state: State::Stopped(Cause::StaleInput),
        stops: 3,
        plant: Plant::default(),
        limits: HARD,
        wires: [0x00FF; 16],
        current: None,
    };
    let length = hello.write(&mut out);
    assert_eq!(Hello::read(&out[..length]), Ok(hello));
    let set = Hello {
        current: Some(CurrentControl {
            full_scale: Milliamps(990),
            gain_ppm: 10_000,
            offset: Milliamps(5),
        }),
        ..hello
    };
    assert_eq!(set.write(&mut out), length);
    assert_eq!(Hello::read(&out[..length]), Ok(set));
    assert_eq!(Hello::read(&out[..length - 1]), Err(Refusal::Body));
    // The fifth of eight bytes of the supply, whose type has four.
    out[35 + 14 * 8 + 4] = 1;
    assert_eq!(Hello::read(&out[..length]), Err(Refusal::Body));
    for state in [
        State::Ready,
        State::Stopped(Cause::StaleInput),
        State::Stopped(Cause::End),
    ] {
        let status = Status {
            now: at(5),
            echo: 6,
            taken: at(4),
            state,
            stops: 1,
            applied: 2,
            limited: 3,
            reasons: 0x201,
            dropped: 4,
            late_us: 5,
            refused: 6,
            skin_mc: 33_000,
            phase_us: core::array::from_fn(|board| if board < 2 { 4000 } else { HELD }),
            face: Face {
                face_mc: 33_500,
                warmest_mc: 34_000,
                aim_mc: 33_400,
                sink_mc: 25_100,
                milliamps: -250,
                reason: Some(PeltierReason::ALL[0]),
            },
        };
        let length = status.write(&mut out);
        assert_eq!(Status::read(&out[..length]), Ok(status));
        assert_eq!(Status::read(&out[..length + 1]), Err(Refusal::Body));
    }
    // Every reason that a module may be held back for, and none beyond.
    let last = Status {
        now: at(0),
        echo: 0,
        taken: at(0),
        state: State::Ready,
        stops: 0,
        applied: 0,
        limited: 0,
        reasons: 0,
        dropped: 0,
        late_us: 0,
        refused: 0,
        skin_mc: 0,
        phase_us: [HELD; 16],
        face: Face::default(),
    };
    let length = last.write(&mut out);
    for (number, reason) in (1..).zip(PeltierReason::ALL) {
        out[length - 1] = number;
        let read = Status::read(&out[..length]).unwrap();
        assert_eq!(read.face.reason, Some(reason));
        assert_eq!(read.write(&mut out), length);
        assert_eq!(out[length - 1], number);
    }
    out[length - 1] = 9;
    assert_eq!(Status::read(&out[..length]), Err(Refusal::Body));
}

#[test]
fn what_is_no_datagram_says_why() {
    let knock = Header {
        kind: Kind::Knock,
        host: 1,
        unit: 0,
        sequence: 1,
    };
    let good = sealed(&knock, &[]);
    let with = |index: usize, byte: u8| {
        let mut bytes = good.clone();
        bytes[index] = byte;
        Header::read(&bytes)
    };
    assert_eq!(Header::read(&good[1..]), Err(Refusal::Length));
    assert_eq!(Header::read(&[0; MOST + 1]), Err(Refusal::Length));
    assert_eq!(with(0, b'Q'), Err(Refusal::Magic));
    assert_eq!(with(2, 3), Err(Refusal::Version(3)));
    assert_eq!(with(3, 9), Err(Refusal::Kind(9)));
    assert_eq!(Header::other_version(&good), None);
    let mut newer = good.clone();
    newer[2] = VERSION + 1;
    let answer = Header::other_version(&newer).unwrap();
    assert_eq!((answer[2], answer[3]), (VERSION, Kind::Hello.number()));
    assert_eq!(answer[4..12], good[4..12]);
    assert_eq!(Header::other_version(&newer[..newer.len() - 1]), None);
    // A knock from the unit's side.
    assert_eq!(with(27, 0x80), Err(Refusal::Kind(1)));
}

#[test]
fn another_length_or_an_unknown_request_is_no_command() {
    let mut out = [0; 64];
    let one = Planned {
        board: Board(0),
        channel: Channel(1),
        width: Ticks::new(4096),
        current: Milliamps(5000),
        at: at(9),
        until: at(10),
    };
    let length = Command::write(&mut out, &Said::default(), &[one]);
    let read = Command::read(&out[..length]).unwrap().planned().next();
    // The nearest that a stimulus carries.
    let most = read.map(|planned| (planned.width.get(), planned.current.0));
    assert_eq!(most, Some((4095, MOST_CURRENT)));
    for (index, byte) in [(20, 3), (21, 2)] {
        let mut altered = out;
        altered[index] = byte;
        assert_eq!(
            Command::read(&altered[..length]),
            Err(Refusal::Body),
            "{index}"
        );
    }
}
