//! How many frames a second reach the loop's end of a CAN interface, and whether every lost one is counted.

// The lab's own time is what is measured here.
#![allow(clippy::disallowed_methods)]

use std::time::{Duration, Instant};

use palpate_buses::can::{CanBuses, Endpoint};
use palpate_buses::pacer::RunClock;
use palpate_core::bus::CanBus;
use palpate_core::codec::can::CanFrame;

use super::tools::{in_lab, vcan};

/// A hand of 240 taxels at 100 Hz.
const RATE: u32 = 24_000;
const SECONDS: u32 = 5;

#[test]
fn every_frame_of_a_hand_arrives_or_is_counted_as_lost() {
    if !in_lab("24,000 frames a second") {
        return;
    }
    vcan("vcan0");
    let mut buses = CanBuses::open(&[("vcan0".into(), vec![4])], RunClock::start()).unwrap();
    let sender = std::thread::spawn(|| {
        let out = Endpoint::open("vcan0", &[]).unwrap();
        let frame = CanFrame::new(0x104, &[0x93, 1, 2, 3, 4, 5, 6, 7]).unwrap();
        let (began, mut sent) = (Instant::now(), 0u32);
        while sent < RATE * SECONDS {
            let due = (began.elapsed().as_secs_f64() * f64::from(RATE)) as u32;
            while sent < due.min(RATE * SECONDS) {
                // vcan has no queue that fills: a frame is delivered within the call.
                out.send(&frame).unwrap();
                sent += 1;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        began.elapsed()
    });
    let mut received = 0u32;
    let mut idle = Instant::now();
    while !sender.is_finished() || idle.elapsed() < Duration::from_millis(500) {
        while buses.receive().unwrap().is_some() {
            received += 1;
            idle = Instant::now();
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    let took = sender.join().unwrap();
    let tally = buses.tallies()[0];
    println!(
        "CAN: {} frames sent in {:.2} s ({:.0} a second), {received} received, {} lost in the kernel, {} in the program",
        RATE * SECONDS,
        took.as_secs_f64(),
        f64::from(RATE * SECONDS) / took.as_secs_f64(),
        tally.dropped,
        tally.discarded
    );
    let counted = u64::from(received) + tally.dropped + tally.discarded;
    assert_eq!(counted, u64::from(RATE * SECONDS));
}
