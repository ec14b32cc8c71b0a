//! The DBC file and the codec say the same about every taxel of every board.

use can_dbc::{ByteOrder, Dbc, MessageId, Signal};
use palpate_core::codec::can::CanFrame;
use palpate_core::codec::uskin::{self, Message, Reading, Wiring};

const DBC: &str = include_str!("../../fixtures/dbc/uskin.dbc");

/// What a DBC reader makes of a big-endian signal (Vector's sawtooth numbering: bit 7 of byte 0 is 7).
fn extract(signal: &Signal, data: &[u8]) -> u64 {
    assert_eq!(signal.byte_order, ByteOrder::BigEndian);
    let first = 8 * (signal.start_bit / 8) + 7 - signal.start_bit % 8;
    (first..first + signal.size).fold(0, |value, bit| {
        value << 1 | u64::from(data[(bit / 8) as usize] >> (7 - bit % 8) & 1)
    })
}

#[test]
fn every_taxel_reads_alike_through_the_dbc_and_the_codec() {
    let dbc = Dbc::try_from(DBC).unwrap();
    assert_eq!(dbc.messages.len(), 16 * 16);
    let reading = Reading {
        x: 0x1234,
        y: 0xFEDC,
        z: 0x8001,
    };
    for message in &dbc.messages {
        let MessageId::Standard(id) = message.id else {
            panic!("{:?}", message.id)
        };
        let frame = uskin::data_frame(id, reading).unwrap();
        let Ok(Message::Data(data)) = uskin::decode(&frame) else {
            panic!("{id:03x}")
        };
        let (_, taxel) = Wiring::FLAT.taxel(data.place).unwrap();
        let board = data.board;
        assert_eq!(message.name, format!("Board{board}_Taxel{taxel}"));
        assert_eq!(message.size, 8);
        for (signal, value) in message
            .signals
            .iter()
            .zip([reading.x, reading.y, reading.z])
        {
            assert_eq!(
                extract(signal, frame.data()),
                u64::from(value),
                "{}",
                signal.name
            );
        }
    }
}

#[test]
fn the_golden_vector_reads_alike_through_the_dbc() {
    let dbc = Dbc::try_from(DBC).unwrap();
    let frame = CanFrame::new(0x104, &[0x93, 0x84, 0x06, 0x80, 0x55, 0x91, 0xBB, 0x0C]).unwrap();
    let message = dbc
        .messages
        .iter()
        .find(|m| m.id == MessageId::Standard(0x104))
        .unwrap();
    let values: Vec<_> = message
        .signals
        .iter()
        .map(|s| (s.name.as_str(), extract(s, frame.data())))
        .collect();
    assert_eq!(message.name, "Board4_Taxel7");
    assert_eq!(values, [("X", 33798), ("Y", 32853), ("Z", 37307)]);
}
