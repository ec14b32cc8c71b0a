//! Tests of `port.rs`.

use super::*;
use crate::sensor::can::NodeConfig;

fn frame(n: u8) -> CanFrame {
    CanFrame::new(0x300, &[n]).unwrap()
}

#[test]
fn a_silent_bus_ends_the_wait_and_a_full_queue_empties_in_it() {
    let mut bus = SkinBus::new(1_000_000);
    bus.segment_mut().attach(NodeConfig::default());
    let mut port = HostPort::new(Handle::new(vec![bus]), 0);
    assert_eq!(blocking::Can::receive(&mut port), Err(HostError::TimedOut));
    assert_eq!(port.now(), Ok(PATIENCE));
    for n in 0..10 {
        assert_eq!(polled::Can::transmit(&mut port, &frame(n)), Ok(None));
    }
    let full = polled::Can::transmit(&mut port, &frame(10));
    assert_eq!(full, Err(nb::Error::WouldBlock));
    assert_eq!(blocking::Can::transmit(&mut port, &frame(10)), Ok(()));
    assert!(port.now().unwrap() > PATIENCE);
}

#[test]
fn a_port_that_cannot_send_says_why() {
    let mut nowhere = HostPort::new(Handle::new(Vec::new()), 0);
    assert_eq!(blocking::Can::receive(&mut nowhere), Err(HostError::NoBus));
    let mut bus = SkinBus::new(1_000_000);
    let host = bus.host();
    bus.segment_mut().force_bus_off(host);
    let mut port = HostPort::new(Handle::new(vec![bus]), 0);
    let sent = blocking::Can::transmit(&mut port, &frame(0));
    assert_eq!(sent, Err(HostError::BusOff));
}
