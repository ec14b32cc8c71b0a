//! Golden vectors, identifiers and orders on the wire.

use super::*;

fn data(id: u16, bytes: &[u8]) -> Data {
    match decode(&CanFrame::new(id, bytes).unwrap()).unwrap() {
        Message::Data(data) => data,
        Message::Command(command) => panic!("{command:?}"),
    }
}

#[test]
fn golden_vectors_decode_and_encode() {
    let bytes = [0x93, 0x7E, 0x31, 0x7E, 0x15, 0x93, 0x12, 0x0F];
    let first = data(0x004, &bytes);
    let reading = Reading {
        x: 32305,
        y: 32277,
        z: 37650,
    };
    assert_eq!((first.board, first.reading), (4, reading));
    assert_eq!(Wiring::FLAT.taxel(first.place), Some((0, 3)));
    let frame = encode(4, first.place, reading).unwrap();
    assert_eq!((frame.id(), frame.data()), (0x004, &bytes[..]));

    let second = data(0x104, &[0x93, 0x84, 0x06, 0x80, 0x55, 0x91, 0xBB, 0x0C]);
    assert_eq!(second.reading.x, 33798);
    assert_eq!(second.reading.y, 32853);
    assert_eq!(second.reading.z, 37307);
    assert_eq!(Wiring::FLAT.taxel(second.place), Some((0, 7)));
    // Seven bytes say the same: byte 7 is skipped anyway.
    assert_eq!(data(0x004, &bytes[..7]), first);
}

#[test]
fn commands_are_told_from_data_by_length_and_first_byte() {
    for (id, argument, board, start) in [
        (0x204, 0, 4, true),
        (0x204, 1, 4, false),
        (0x20F, 0, 15, true),
    ] {
        let frame = CanFrame::new(id, &[0x07, argument]).unwrap();
        let command = Command { board, start };
        assert_eq!(decode(&frame), Ok(Message::Command(command)));
        assert_eq!(command.encode(), Some(frame));
    }
    // The same identifier with eight bytes is board 4's chip 0 on SDA line 2.
    let trap = data(0x204, &[0x07, 0, 0, 0, 0, 0, 0, 0]);
    assert_eq!((trap.board, trap.place), (4, ChipPlace { sda: 2, chip: 0 }));
    assert!(
        Command {
            board: 15,
            start: true
        }
        .is_for(3)
    );
    assert!(
        !Command {
            board: 2,
            start: true
        }
        .is_for(3)
    );
    assert_eq!(
        Command {
            board: 16,
            start: true
        }
        .encode(),
        None
    );
}

#[test]
fn rejects_what_means_nothing() {
    let say = |id, bytes: &[u8]| decode(&CanFrame::new(id, bytes).unwrap());
    assert_eq!(say(0x004, &[0; 6]), Err(Rejected::Length));
    assert_eq!(say(0x004, &[]), Err(Rejected::Length));
    assert_eq!(say(0x304, &[7, 0]), Err(Rejected::UnknownCommand));
    assert_eq!(say(0x204, &[7, 2]), Err(Rejected::UnknownCommand));
    assert_eq!(say(0x204, &[6, 0]), Err(Rejected::UnknownCommand));
}

#[test]
fn identifiers_survive_the_round_trip() {
    for number in 0..=0x7FF {
        let (board, place) = sender(number);
        assert_eq!(id(board, place), Some(number));
    }
    assert_eq!(id(4, ChipPlace { sda: 3, chip: 3 }), Some(0x334));
    assert_eq!(id(0, ChipPlace { sda: 8, chip: 0 }), None);
    assert_eq!(id(0, ChipPlace { sda: 0, chip: 16 }), None);
    assert_eq!(id(16, ChipPlace::default()), None);
}

#[test]
fn wiring_maps_places_to_taxels_and_back() {
    let halves = Wiring::new(2, 4, 2).unwrap();
    for wiring in [Wiring::FLAT, Wiring::CURVED, halves] {
        let total = wiring.taxels() * usize::from(wiring.modules());
        for n in 0..total {
            let place = wiring.nth(n).unwrap();
            assert_eq!(wiring.order(place), Some(n));
            let (module, taxel) = wiring.taxel(place).unwrap();
            assert_eq!(wiring.place(module, taxel), Some(place));
        }
        assert_eq!(wiring.nth(total), None);
        assert_eq!(wiring.place(0, wiring.taxels()), None);
    }
    // Chip-major, SDA line inner: 004, 104, 204, 304, 014 ...
    let ids: [_; 5] = core::array::from_fn(|n| id(4, Wiring::FLAT.nth(n).unwrap()));
    assert_eq!(
        ids,
        [
            Some(0x004),
            Some(0x104),
            Some(0x204),
            Some(0x304),
            Some(0x014)
        ]
    );
    assert_eq!(halves.taxel(ChipPlace { sda: 1, chip: 0xB }), Some((1, 4)));
    assert_eq!(halves.taxel(ChipPlace { sda: 1, chip: 0x4 }), None);
    assert_eq!(Wiring::new(0, 4, 1), None);
    assert_eq!(Wiring::new(4, 9, 1), None);
    assert_eq!(Wiring::new(4, 4, 3), None);
}
