//! A bus of two loops over a double: whose fault is whose, and who counts as alive.

use std::os::fd::AsRawFd;
use std::time::Duration;

use nix::sys::socket::{AddressFamily, MsgFlags, SockFlag, SockType, recv, socketpair};

use super::super::{Adapter, FaultKind};
use super::*;

/// An adapter that refuses one address, and is held while a lock is.
struct Double {
    refused: u8,
    hold: Arc<Mutex<()>>,
}

impl Adapter for Double {
    fn name(&self) -> String {
        "double".into()
    }

    fn transfer(&mut self, address: u8, _write: &[u8], _read: &mut [u8]) -> Result<(), FaultKind> {
        let _held = self.hold.lock().unwrap();
        match address == self.refused {
            true => Err(FaultKind::NoAddress),
            false => Ok(()),
        }
    }
}

/// Two loops of three on one bus, the guardian's end of the link, and what holds the adapter.
fn two() -> (
    Vec<SharedLine>,
    Arc<Round>,
    std::os::fd::OwnedFd,
    Arc<Mutex<()>>,
) {
    let kind = SockType::SeqPacket;
    let (ours, theirs) =
        socketpair(AddressFamily::Unix, kind, None, SockFlag::SOCK_CLOEXEC).unwrap();
    let hold = Arc::new(Mutex::new(()));
    let double = Double {
        refused: 0x41,
        hold: Arc::clone(&hold),
    };
    let line = Line::new(double, Duration::from_millis(100)).unwrap();
    let round = Arc::new(Round::new(3));
    let pulse = Pulse::new(Arc::new(ours), b'.');
    let ends = SharedLine::share(line, pulse, &round, &[0, 1]);
    (ends, round, theirs, hold)
}

fn beats(link: &std::os::fd::OwnedFd) -> usize {
    let mut packet = [0; 4];
    let mut heard = || recv(link.as_raw_fd(), &mut packet, MsgFlags::MSG_DONTWAIT).is_ok();
    std::iter::from_fn(|| heard().then_some(())).count()
}

#[test]
fn a_fault_is_the_loops_that_met_it() {
    let (mut ends, ..) = two();
    ends[0].write(0x41, &[1]).unwrap_err();
    ends[1].write(0x40, &[1]).unwrap();
    let kinds = ends.iter().map(|e| e.last_fault().map(|f| f.kind));
    assert_eq!(
        kinds.collect::<Vec<_>>(),
        [Some(FaultKind::NoAddress), None]
    );
}

#[test]
fn while_a_transfer_hangs_those_who_wait_are_alive_and_a_third_loop_is_not() {
    let (mut ends, round, link, hold) = two();
    let held = hold.lock().unwrap();
    let mut second = ends.pop().unwrap();
    let mut first = ends.pop().unwrap();
    std::thread::scope(|scope| {
        scope.spawn(|| first.write(0x40, &[1]).unwrap_err());
        scope.spawn(|| second.write(0x40, &[2]).unwrap_err());
    });
    assert_eq!(beats(&link), 0, "the third has made no turn");
    round.ended(2);
    drop(held);
    while first.write(0x40, &[4]).is_err() {}
    let held = hold.lock().unwrap();
    std::thread::scope(|scope| {
        scope.spawn(|| first.write(0x40, &[5]).unwrap_err());
        scope.spawn(|| second.write(0x40, &[6]).unwrap_err());
    });
    assert!(beats(&link) > 0, "both wait");
    drop(held);
}

#[test]
fn a_panic_in_another_loop_leaves_the_bus_usable() {
    let (mut ends, ..) = two();
    let line = Arc::clone(&ends[0].line);
    let panicked = std::thread::spawn(move || {
        let _held = line.lock().unwrap();
        panic!("a drill");
    });
    panicked.join().unwrap_err();
    ends[1].write(0x40, &[1]).unwrap();
}
