//! The line over a double: order, limits, and what a stuck adapter does.

use std::sync::{Arc, Mutex};

use embedded_hal::i2c::I2c as _;
use palpate_core::driver::Pca9685Bank;
use palpate_core::units::{Clock, Instant, Prescale};

use super::*;

/// Address and bytes of every write.
type Writes = Arc<Mutex<Vec<(u8, Vec<u8>)>>>;

/// An adapter that remembers writes, answers reads with their number, and can be held.
struct Double {
    writes: Writes,
    hold: Arc<Mutex<()>>,
    fault: Option<FaultKind>,
}

type Seen = (Line, Writes, Arc<Mutex<()>>);

fn line(fault: Option<FaultKind>) -> Seen {
    let (writes, hold) = (Arc::default(), Arc::default());
    let double = Double {
        writes: Arc::clone(&writes),
        hold: Arc::clone(&hold),
        fault,
    };
    let line = Line::new(double, Duration::from_millis(20)).unwrap();
    (line, writes, hold)
}

impl Adapter for Double {
    fn name(&self) -> String {
        "double".into()
    }

    fn transfer(&mut self, address: u8, write: &[u8], read: &mut [u8]) -> Result<(), FaultKind> {
        let _held = self.hold.lock().unwrap();
        self.writes.lock().unwrap().push((address, write.to_vec()));
        for (n, byte) in read.iter_mut().enumerate() {
            *byte = n as u8;
        }
        self.fault.map_or(Ok(()), Err)
    }
}

#[test]
fn adjacent_operations_are_one_message() {
    let (mut line, writes, _) = line(None);
    let (mut a, mut b) = ([9; 2], [9; 3]);
    let mut operations = [
        Operation::Write(&[1, 2]),
        Operation::Write(&[3]),
        Operation::Read(&mut a),
        Operation::Read(&mut b),
    ];
    line.transaction(0x40, &mut operations).unwrap();
    assert_eq!((a, b), ([0, 1], [2, 3, 4]));
    assert_eq!(*writes.lock().unwrap(), [(0x40, vec![1, 2, 3])]);
    let mut a = [0];
    let mut backwards = [Operation::Read(&mut a), Operation::Write(&[1])];
    let fault = line.transaction(0x40, &mut backwards).unwrap_err();
    assert_eq!(fault.kind, FaultKind::Unsupported);
}

#[test]
fn a_stuck_adapter_costs_its_limit_and_is_never_queued_for() {
    let (mut line, writes, hold) = line(None);
    let held = hold.lock().unwrap();
    assert_eq!(line.write(0x40, &[1]).unwrap_err().kind, FaultKind::Stuck);
    assert_eq!(line.write(0x40, &[2]).unwrap_err().kind, FaultKind::Stuck);
    drop(held);
    while line.write(0x40, &[3]).is_err() {}
    // The first was on its way and may arrive late; the second was never sent.
    assert_eq!(*writes.lock().unwrap(), [(0x40, vec![1]), (0x40, vec![3])]);
}

#[test]
fn a_line_that_is_stuck_can_be_dropped() {
    let (mut line, _writes, hold) = line(None);
    let _held = hold.lock().unwrap();
    line.write(0x40, &[1]).unwrap_err();
    drop(line);
}

#[test]
fn the_driver_tries_passing_faults_three_times_and_others_once() {
    for (kind, times) in [
        (FaultKind::Busy, 3),
        (FaultKind::ArbitrationLost, 3),
        (FaultKind::NoAddress, 1),
        (FaultKind::TimedOut, 1),
        (FaultKind::Gone, 1),
    ] {
        let (line, writes, _) = line(Some(kind));
        let mut bank = Pca9685Bank::new(
            line,
            &[0x40],
            Prescale::from_hz(Clock::INTERNAL, 200.0).unwrap(),
        );
        bank.start(Instant::ZERO).unwrap_err();
        let own = writes
            .lock()
            .unwrap()
            .iter()
            .filter(|w| w.0 == 0x40)
            .count();
        assert_eq!(own, times, "{kind:?}");
        assert_eq!(bank.bus().last_fault().unwrap().kind, kind);
    }
}

/// An adapter that tells the priority of the thread that transfers.
struct Ranked(Sender<Option<u8>>);

impl Adapter for Ranked {
    fn name(&self) -> String {
        "ranked".into()
    }

    fn transfer(&mut self, _: u8, _: &[u8], _: &mut [u8]) -> Result<(), FaultKind> {
        self.0.send(fifo_priority()).unwrap();
        Ok(())
    }
}

#[test]
fn the_thread_of_a_bus_has_the_priority_of_who_waits_for_it() {
    let (told, ranks) = channel();
    let mut line = Line::new(Ranked(told), Duration::from_millis(500)).unwrap();
    // This test has a thread of its own, and the system may allow it none but the ordinary priority.
    for wanted in [None, Some(1), Some(2)] {
        let _ = wanted.map(set_fifo_priority);
        line.write(0x40, &[0]).unwrap();
        assert_eq!(ranks.recv(), Ok(fifo_priority()));
    }
}
