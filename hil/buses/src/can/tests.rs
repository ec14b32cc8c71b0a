//! The reader over pairs of local sockets: what does not need a CAN interface.

use std::os::fd::{AsRawFd, OwnedFd};
use std::time::Duration;

use nix::sys::socket::{AddressFamily, MsgFlags, SockFlag, SockType, recv, send, socketpair};

use super::*;

fn pair() -> (Endpoint, OwnedFd) {
    let kind = SockType::SeqPacket;
    let (ours, theirs) =
        socketpair(AddressFamily::Unix, kind, None, SockFlag::SOCK_NONBLOCK).unwrap();
    (Endpoint::from(ours), theirs)
}

fn raw(id: u32, data: &[u8]) -> [u8; 16] {
    let mut bytes = [0; 16];
    bytes[..4].copy_from_slice(&id.to_ne_bytes());
    bytes[4] = data.len() as u8;
    bytes[8..8 + data.len()].copy_from_slice(data);
    bytes
}

/// Waits, a second at most, for something to be there.
fn soon<T>(mut look: impl FnMut() -> Option<T>) -> T {
    let clock = RunClock::start();
    loop {
        if let Some(found) = look() {
            return found;
        }
        let now = clock.now();
        assert!(now.as_micros() < 1_000_000, "nothing within a second");
        clock.sleep_until(now + palpate_core::units::Duration::from_millis(1));
    }
}

fn buses(n: usize) -> (CanBuses, Vec<OwnedFd>) {
    let (mut endpoints, mut others) = (Vec::new(), Vec::new());
    for bus in 0..n {
        let (ours, theirs) = pair();
        endpoints.push((format!("test{bus}"), vec![4], ours));
        others.push(theirs);
    }
    (
        CanBuses::over(endpoints, RunClock::start()).unwrap(),
        others,
    )
}

#[test]
fn frames_of_every_interface_arrive_in_order_with_their_bus() {
    let (mut buses, others) = buses(2);
    for n in 0..200u8 {
        let other = &others[usize::from(n % 2)];
        send(
            other.as_raw_fd(),
            &raw(4, &[0, n, 0, 0, 0, 0, 0]),
            MsgFlags::empty(),
        )
        .unwrap();
    }
    let mut next = [0u8, 1];
    for _ in 0..200 {
        let received = soon(|| buses.receive().unwrap());
        let bus = usize::from(received.bus);
        assert_eq!(received.frame.data()[1], next[bus]);
        next[bus] += 2;
    }
    let frames: Vec<u64> = buses.tallies().iter().map(|t| t.frames).collect();
    assert_eq!(frames, [100, 100]);
}

#[test]
fn commands_leave_as_frames_on_their_own_bus() {
    let (mut buses, others) = buses(2);
    let start = CanFrame::new(0x20c, &[7, 0]).unwrap();
    buses.transmit(1, &start).unwrap();
    let mut bytes = [0; 32];
    let length = soon(|| recv(others[1].as_raw_fd(), &mut bytes, MsgFlags::MSG_DONTWAIT).ok());
    assert_eq!(bytes[..length], raw(0x20c, &[7, 0]));
    assert!(recv(others[0].as_raw_fd(), &mut bytes, MsgFlags::MSG_DONTWAIT).is_err());
    assert_eq!(buses.transmit(2, &start), Err(BusError::NoBus));
}

#[test]
fn bus_off_is_counted_and_told_once() {
    let (mut buses, others) = buses(1);
    for _ in 0..3 {
        let class = nix::libc::CAN_ERR_FLAG | 0x40;
        send(
            others[0].as_raw_fd(),
            &raw(class, &[0; 8]),
            MsgFlags::empty(),
        )
        .unwrap();
    }
    let told = soon(|| buses.note());
    assert!(told.text.starts_with("test0: bus-off"), "{}", told.text);
    soon(|| (buses.tallies()[0].bus_off == 3).then_some(()));
    assert_eq!(buses.note(), None);
    // The bus goes on after it.
    send(others[0].as_raw_fd(), &raw(4, &[1; 8]), MsgFlags::empty()).unwrap();
    assert_eq!(soon(|| buses.receive().unwrap()).frame.id(), 4);
}

#[test]
fn strange_packets_are_counted_and_left() {
    let (mut buses, others) = buses(1);
    for bytes in [&raw(0x8000_0004, &[1; 8])[..], &[1, 2, 3], &raw(4, &[9; 8])] {
        send(others[0].as_raw_fd(), bytes, MsgFlags::empty()).unwrap();
    }
    assert_eq!(soon(|| buses.receive().unwrap()).frame.data(), [9; 8]);
    assert_eq!(buses.tallies()[0].other, 2);
}

#[test]
fn an_interface_that_is_not_there_says_what_to_type() {
    let wanted = [("no-such-can".to_owned(), vec![])];
    let error = CanBuses::open(&wanted, RunClock::start()).unwrap_err();
    let text = error.to_string();
    assert!(text.starts_with("no-such-can: "), "{text}");
    assert!(
        text.contains("ip link") || text.contains("modprobe"),
        "{text}"
    );
}

#[test]
fn the_thread_ends_with_its_owner() {
    let (buses, _others) = buses(2);
    let clock = RunClock::start();
    drop(buses);
    let took = Duration::from_micros(clock.now().as_micros());
    assert!(took < Duration::from_secs(1), "{took:?}");
}
