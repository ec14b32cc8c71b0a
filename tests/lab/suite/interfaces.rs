//! What an interface can do to a run: down, up, renamed, unplugged, error frames, bus-off. On the loop's own reader.

// These tests live in the lab's own time.
#![allow(clippy::disallowed_methods)]

use std::fs::File;
use std::io::Write;
use std::os::fd::OwnedFd;
use std::time::Duration;

use nix::pty::openpty;
use palpate_buses::can::{CanBuses, Tally};
use palpate_buses::pacer::RunClock;
use palpate_core::bus::CanBus;

use super::tools::{hil, in_lab, sh, text, try_sh, vcan};

/// A reader of one interface, with everything it has told.
struct Reader {
    buses: CanBuses,
    notes: Vec<String>,
    frames: usize,
}

impl Reader {
    fn on(interface: &str) -> Self {
        let buses = CanBuses::open(&[(interface.into(), vec![4])], RunClock::start()).unwrap();
        Self {
            buses,
            notes: Vec::new(),
            frames: 0,
        }
    }

    /// Takes in what there is until `done`; how long that may take is generous.
    #[track_caller]
    fn until(&mut self, what: &str, done: impl Fn(&Self) -> bool) {
        for _ in 0..2000 {
            while self.buses.receive().unwrap().is_some() {
                self.frames += 1;
            }
            while let Some(note) = self.buses.note() {
                self.notes.push(note.text);
            }
            if done(self) {
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("{what}: {} frames, told {:?}", self.frames, self.notes);
    }

    #[track_caller]
    fn told(&mut self, text: &str) {
        self.until(text, |r| r.notes.iter().any(|note| note.contains(text)));
    }

    fn tally(&self) -> Tally {
        self.buses.tallies()[0]
    }

    /// A frame of board 4 arrives.
    #[track_caller]
    fn hears(&mut self, from: &str) {
        let before = self.frames;
        sh(&format!("cansend {from} 104#93C0903EA392530F"));
        self.until("a frame", |r| r.frames > before);
    }
}

#[test]
fn an_interface_goes_down_comes_up_is_renamed_and_unplugged() {
    if !in_lab("an interface's life") {
        return;
    }
    let _ = try_sh("ip link del vcan8; ip link del vcan9");
    vcan("vcan8");
    let mut reader = Reader::on("vcan8");
    reader.hears("vcan8");
    sh("ip link set vcan8 down");
    reader.told("vcan8: went down; waiting for `ip link set vcan8 up`");
    sh("ip link set vcan8 up");
    reader.told("vcan8: up again");
    reader.hears("vcan8");
    sh("ip link set vcan8 down; ip link set vcan8 name vcan9; ip link set vcan9 up");
    reader.told("renamed to vcan9, goes on");
    reader.hears("vcan9");
    sh("ip link del vcan9");
    reader.told("vcan9: gone (unplugged?); waiting for it to come back");
    reader.notes.clear();
    vcan("vcan9");
    reader.told("vcan9: up again");
    reader.hears("vcan9");
    sh("ip link del vcan9");
    reader.told("vcan9: gone (unplugged?); waiting for it to come back");
    vcan("vcan9");
    reader.until("it comes back", |r| {
        r.notes.iter().filter(|n| n.contains("up again")).count() >= 2
    });
    reader.hears("vcan9");
    sh("ip link del vcan9");
}

#[test]
fn bus_off_is_seen_and_survived_and_noise_is_counted() {
    if !in_lab("error frames") {
        return;
    }
    vcan("vcan0");
    let mut reader = Reader::on("vcan0");
    // As drivers tell it: class in the identifier, details in the data (linux/can/error.h).
    sh("cansend vcan0 20000040#0000000000000000");
    reader.told("bus-off: short circuit, wrong bit rate or bad wiring");
    // A virtual controller is not restarted; the way out is told.
    reader.told("stays bus-off: `ip link set vcan0 down; ip link set vcan0 up`");
    sh("cansend vcan0 20000100#0000000000000000");
    reader.told("restarted, back on the bus");
    sh("cansend vcan0 20000004#0020000000000000");
    reader.told("error passive");
    sh("cansend vcan0 20000088#0000000000000000; cansend vcan0 20000004#0001000000000000");
    reader.until("noise and an overrun", |r| {
        r.tally().bus_errors == 1 && r.tally().overruns == 1
    });
    reader.hears("vcan0");
    let tally = reader.tally();
    assert_eq!((tally.bus_off, tally.restarts), (1, 1));
}

#[test]
fn a_controller_with_restart_ms_is_left_to_the_kernel() {
    if !in_lab("restart-ms") || !try_sh("ip link show can0").status.success() {
        return;
    }
    sh(
        "ip link set can0 down; ip link set can0 type can bitrate 1000000 restart-ms 100 && ip link set can0 up",
    );
    sh("ip link set can1 down; ip link set can1 type can bitrate 1000000 && ip link set can1 up");
    let mut reader = Reader::on("can0");
    reader.hears("can1");
    // A driver's own echo of a frame marked as an error frame: the only way to tell this reader of bus-off.
    sh("cansend can0 20000040#0000000000000000");
    reader.told("bus-off");
    reader.hears("can1");
    assert!(
        reader.notes.iter().all(|n| !n.contains("stays bus-off")),
        "{:?}",
        reader.notes
    );
    // Without restart-ms the program restarts it itself, which the kernel refuses to one that is not off.
    sh("ip link set can0 down; ip link set can0 type can restart-ms 0 && ip link set can0 up");
    let mut reader = Reader::on("can0");
    sh("cansend can0 20000040#0000000000000000");
    reader.told("stays bus-off: `ip link set can0 type can restart`");
}

/// A CAN adapter on a serial line: can-utils' slcand, the kernel's slcan, and this end of the line for the adapter.
struct SerialAdapter {
    line: File,
    /// Held open: the line hangs up with its last holder.
    _far_end: OwnedFd,
}

impl SerialAdapter {
    fn start() -> Self {
        let pair = openpty(None, None).unwrap();
        let far_end = nix::unistd::ttyname(&pair.slave).unwrap();
        sh(&format!("slcand -o -s8 {} slcan0", far_end.display()));
        sh("timeout 20 sh -c 'until ip link set slcan0 up 2>/dev/null; do sleep 0.1; done'");
        Self {
            line: pair.master.into(),
            _far_end: pair.slave,
        }
    }

    /// What the adapter says, in LAWICEL's words and the state message of linux/drivers/net/can/slcan.
    fn says(&mut self, word: &str) {
        write!(self.line, "{word}\r").unwrap();
    }

    /// A frame of board 4 from the bus.
    #[track_caller]
    fn is_heard(&mut self, by: &mut Reader) {
        let before = by.frames;
        self.says("t104893C0903EA392530F");
        by.until("a frame", |r| r.frames > before);
    }
}

#[test]
fn a_controller_that_the_kernel_has_taken_off_the_bus_comes_back() {
    if !in_lab("bus-off by the kernel") {
        return;
    }
    let mut adapter = SerialAdapter::start();
    let mut reader = Reader::on("slcan0");
    adapter.is_heard(&mut reader);
    for round in 1..=3 {
        reader.notes.clear();
        // The state, then what its error counters of reception and transmission stand at.
        adapter.says("sp000130");
        reader.told("error passive");
        adapter.says("sb000255");
        reader.told("bus-off: short circuit, wrong bit rate or bad wiring");
        reader.told("stays bus-off: `ip link set slcan0 down; ip link set slcan0 up`");
        let about = sh("ip -details link show slcan0");
        assert!(
            about.contains("BUS-OFF") && about.contains("NO-CARRIER"),
            "{about}"
        );
        let doctor = try_sh(&format!("{} doctor", hil().display()));
        let doctor = text(&doctor.stdout);
        assert!(doctor.contains("slcan0: up, bus-off"), "{doctor}");
        sh("ip link set slcan0 down; ip link set slcan0 up");
        adapter.is_heard(&mut reader);
        assert_eq!(reader.tally().bus_off, round);
        assert!(sh("ip -details link show slcan0").contains("ERROR-ACTIVE"));
    }
    sh("ip link set slcan0 down");
}
