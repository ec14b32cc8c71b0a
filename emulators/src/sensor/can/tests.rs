//! The segment: bits, arbitration, errors.

use palpate_core::codec::can::CanFrame;

use super::*;
use crate::time::Nanos;

fn frame(id: u16, data: &[u8]) -> CanFrame {
    CanFrame::new(id, data).unwrap()
}

fn bus(nodes: usize) -> (CanSegment, Vec<NodeId>) {
    let mut segment = CanSegment::new(1_000_000);
    let config = NodeConfig {
        transmit_limit: 64,
        ..NodeConfig::default()
    };
    let nodes = (0..nodes).map(|_| segment.attach(config)).collect();
    (segment, nodes)
}

fn ms(n: u64) -> Nanos {
    Nanos::from_micros(n * 1000)
}

fn received(segment: &mut CanSegment, node: NodeId) -> Vec<(u64, u16)> {
    std::iter::from_fn(|| segment.receive(node))
        .map(|(at, f)| (at.0, f.id()))
        .collect()
}

#[test]
fn the_lowest_identifier_wins_whatever_the_order_of_calls() {
    let (mut segment, nodes) = bus(4);
    segment.advance(ms(1));
    for (node, id) in nodes.iter().zip([0x300, 0x100, 0x200]) {
        segment.send(*node, &frame(id, &[0x55; 8])).unwrap();
    }
    segment.advance(ms(2));
    let ids: Vec<_> = received(&mut segment, nodes[3])
        .iter()
        .map(|r| r.1)
        .collect();
    assert_eq!(ids, [0x100, 0x200, 0x300]);
}

#[test]
fn frames_take_their_bits_and_are_received_at_their_end() {
    for bitrate in [1_000_000, 500_000, 125_000] {
        let mut segment = CanSegment::new(bitrate);
        let config = NodeConfig::default();
        let (a, b) = (segment.attach(config), segment.attach(config));
        let f = frame(0x104, &[0x93, 0x84, 0x06, 0x80, 0x55, 0x91, 0xBB, 0x0C]);
        segment.send(a, &f).unwrap();
        segment.send(a, &f).unwrap();
        segment.advance(ms(10));
        let bit = 1_000_000_000 / u64::from(bitrate);
        let length = u64::from(bits::length(&f));
        let times: Vec<_> = received(&mut segment, b).iter().map(|r| r.0).collect();
        assert_eq!(times, [length * bit, (2 * length + 3) * bit]);
        assert_eq!(segment.statistics().bits, 2 * (length + 3));
    }
}

#[test]
fn a_running_frame_is_not_interrupted_and_a_replaced_one_goes_again() {
    let (mut segment, _) = bus(0);
    let mailboxes = NodeConfig {
        order: Order::Priority,
        transmit_limit: 2,
        ..NodeConfig::default()
    };
    let (a, b) = (
        segment.attach(mailboxes),
        segment.attach(NodeConfig::default()),
    );
    segment.send(a, &frame(0x200, &[1])).unwrap();
    segment.advance(Nanos(10_000));
    assert_eq!(segment.pending(a), 1);
    segment.replace(a, &frame(0x200, &[2])).unwrap();
    segment.replace(a, &frame(0x200, &[3])).unwrap();
    segment.send(a, &frame(0x100, &[])).unwrap();
    assert_eq!(segment.send(a, &frame(0x101, &[])), Err(SendError::Full));
    segment.advance(ms(1));
    let seen: Vec<_> = std::iter::from_fn(|| segment.receive(b))
        .map(|(_, f)| f)
        .collect();
    assert_eq!(
        seen,
        [frame(0x200, &[1]), frame(0x100, &[]), frame(0x200, &[3])]
    );
}

#[test]
fn a_destroyed_frame_is_sent_again_and_counted() {
    for (class, tec, rec) in [
        (ErrorClass::Bit, 7, 0),
        (ErrorClass::Stuff, 7, 0),
        (ErrorClass::Crc, 7, 0),
        (ErrorClass::Form, 7, 0),
        (ErrorClass::Ack, 7, 0),
    ] {
        let (mut segment, nodes) = bus(2);
        segment.inject(class);
        segment.send(nodes[0], &frame(0x100, &[7; 8])).unwrap();
        segment.advance(ms(1));
        assert_eq!(received(&mut segment, nodes[1]).len(), 1);
        assert_eq!(segment.statistics().errors.iter().sum::<u64>(), 1);
        assert_eq!(segment.statistics().errors[class as usize], 1);
        assert_eq!(
            segment.confinement(nodes[0]),
            Some((Confinement::Active, tec, 0))
        );
        assert_eq!(
            segment.confinement(nodes[1]),
            Some((Confinement::Active, 0, rec))
        );
    }
}

#[test]
fn sixteen_errors_make_a_node_passive_and_thirty_two_put_it_off_the_bus() {
    let (mut segment, nodes) = bus(2);
    for n in 1..=32 {
        segment.inject(ErrorClass::Bit);
        if n == 1 {
            segment.send(nodes[0], &frame(0x100, &[])).unwrap();
        }
        let due = segment.next_event();
        segment.advance(due); // the start of frame
        segment.advance(segment.next_event()); // its end
        let (state, tec, _) = segment.confinement(nodes[0]).unwrap();
        assert_eq!(tec, 8 * n);
        let expected = match n {
            ..16 => Confinement::Active,
            16..32 => Confinement::Passive,
            _ => Confinement::BusOff,
        };
        assert_eq!(state, expected, "after {n}");
    }
    assert_eq!(
        segment.send(nodes[0], &frame(0x100, &[])),
        Err(SendError::BusOff)
    );
    assert_eq!(segment.next_event(), Nanos::MAX);
    segment.restart(nodes[0]);
    let back = segment.now() + Nanos(1_408_000);
    segment.advance(Nanos(back.0 - 1));
    assert_eq!(
        segment.send(nodes[0], &frame(0x100, &[])),
        Err(SendError::BusOff)
    );
    segment.advance(back);
    assert_eq!(
        segment.confinement(nodes[0]),
        Some((Confinement::Active, 0, 0))
    );
    segment.send(nodes[0], &frame(0x100, &[])).unwrap();
    segment.advance(ms(100));
    assert_eq!(received(&mut segment, nodes[1]).len(), 1);
}

#[test]
fn a_node_restarts_from_bus_off_by_itself_when_told_to() {
    let mut segment = CanSegment::new(1_000_000);
    let config = NodeConfig {
        restart_after: Some(ms(100)),
        ..NodeConfig::default()
    };
    let (a, _) = (
        segment.attach(config),
        segment.attach(NodeConfig::default()),
    );
    (0..32).for_each(|_| segment.inject(ErrorClass::Form));
    segment.send(a, &frame(0x100, &[])).unwrap();
    segment.advance(ms(50));
    assert_eq!(segment.confinement(a).unwrap().0, Confinement::BusOff);
    segment.advance(ms(150));
    assert_eq!(segment.confinement(a).unwrap().0, Confinement::Active);
}

#[test]
fn a_node_alone_gets_no_acknowledgement_and_stays_passive_for_ever() {
    let (mut segment, nodes) = bus(1);
    segment.send(nodes[0], &frame(0x100, &[])).unwrap();
    segment.advance(ms(1000));
    assert_eq!(
        segment.confinement(nodes[0]),
        Some((Confinement::Passive, 128, 0))
    );
    assert_eq!(segment.pending(nodes[0]), 1);
    let late = segment.attach(NodeConfig::default());
    segment.advance(ms(1001));
    assert_eq!(received(&mut segment, late).len(), 1);
}

#[test]
fn two_nodes_with_one_identifier_make_bit_errors_until_one_is_passive() {
    let (mut segment, nodes) = bus(3);
    segment.send(nodes[0], &frame(0x20c, &[7, 0])).unwrap();
    segment.send(nodes[1], &frame(0x20c, &[0; 8])).unwrap();
    segment.advance(ms(20));
    assert!(segment.statistics().errors[ErrorClass::Bit as usize] >= 16);
    let seen = received(&mut segment, nodes[2]);
    assert_eq!(seen.len(), 2, "both get through in the end");
}

#[test]
fn the_same_bits_from_two_nodes_are_one_frame() {
    let (mut segment, nodes) = bus(3);
    for node in &nodes[..2] {
        segment.send(*node, &frame(0x20f, &[7, 0])).unwrap();
    }
    segment.advance(ms(1));
    assert_eq!(received(&mut segment, nodes[2]).len(), 1);
    assert_eq!(segment.statistics().errors, [0; 5]);
}

#[test]
fn a_full_receive_queue_loses_and_counts() {
    let mut segment = CanSegment::new(1_000_000);
    let small = NodeConfig {
        receive_limit: 3,
        ..NodeConfig::default()
    };
    let (a, b) = (segment.attach(NodeConfig::default()), segment.attach(small));
    (0..5).for_each(|n| segment.send(a, &frame(n, &[])).unwrap());
    segment.advance(ms(5));
    assert_eq!(
        (received(&mut segment, b).len(), segment.overflows(b)),
        (3, 2)
    );
}
