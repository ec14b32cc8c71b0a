//! An image as the suite that holds for every kind of unit (`hil/tests/unit/suite.rs`) meets it: in the guest's own time,
//! its datagrams the rig's.

use palpate_core::codec::link::{Header, Key, Kind, Status};
use palpate_core::units::{Duration, Instant};
use palpate_emulators::network::Profile;
use palpate_emulators::time::Nanos;
use palpate_qemu::{Chips, Host, Lockstep, Machine};

use super::machines::{KEY, in_qemu, lockstep};
use super::{held, warmth};
use held::{Seen, Subject};

in_qemu! {
    it_plays_what_it_is_told
    hostile_datagrams_drive_nothing
    a_host_that_lies_gets_nothing_over_a_limit
    it_shows_what_is_cold
    it_bears_what_its_own_guard_bears
    it_lets_go_without_a_reading
}

fn it_plays_what_it_is_told(machine: Machine) {
    held::plays_what_it_is_told(Flashed::new(machine));
}

fn hostile_datagrams_drive_nothing(machine: Machine) {
    held::drives_nothing_without_a_session(Flashed::new(machine));
}

fn a_host_that_lies_gets_nothing_over_a_limit(machine: Machine) {
    held::limits_a_host_that_lies(Flashed::new(machine));
}

fn it_shows_what_is_cold(machine: Machine) {
    warmth::shows_what_is_cold(Flashed::new(machine));
}

fn it_bears_what_its_own_guard_bears(machine: Machine) {
    warmth::bears_what_its_own_guard_bears(Flashed::new(machine));
}

fn it_lets_go_without_a_reading(machine: Machine) {
    warmth::lets_go_without_a_reading(Flashed::new(machine));
}

/// An image that runs. Its host in this process is silent: the suite is its host.
pub struct Flashed {
    run: Lockstep,
    refused: u64,
}

impl Flashed {
    /// Starts it.
    pub fn new(machine: Machine) -> Self {
        let mut host = Host::new(&KEY, 1, Profile::WIRE).unwrap();
        host.lives = false;
        let run = Lockstep::start(
            machine,
            &lockstep(&machine),
            (Chips::new(true).warm(), host),
        );
        Self {
            run: run.unwrap(),
            refused: 0,
        }
    }
}

impl Subject for Flashed {
    fn now(&self) -> Instant {
        Instant::from_micros(self.run.now().0 / 1000)
    }

    fn send(&mut self, datagram: &[u8]) {
        self.run.host.injected.push_back(datagram.to_vec());
    }

    fn pass(&mut self, time: Duration) -> Vec<Vec<u8>> {
        self.run.run(time).unwrap();
        while !self.run.host.injected.is_empty() {
            self.run.run(Duration::from_millis(1)).unwrap();
        }
        let heard = std::mem::take(&mut self.run.host.heard);
        let newest = heard.iter().rfind(|datagram| {
            Header::read(datagram).is_ok_and(|header| header.kind == Kind::Status)
        });
        if let Some(mut datagram) = newest.cloned() {
            let key = Key::new(&KEY);
            let status = Status::read(key.open(&mut datagram).unwrap()).unwrap();
            self.refused = status.refused.into();
        }
        heard
    }

    fn end(mut self) -> Seen {
        // Longer than a unit without a host lets anything run.
        self.run.run(Duration::from_millis(200)).unwrap();
        assert_eq!(self.run.chips.boots.len(), 1, "it began anew");
        let mut seen = Seen {
            refused: self.refused,
            ..Seen::default()
        };
        let mut high = [None; 16];
        for level in &self.run.chips.levels {
            assert_eq!(level.board, 0);
            let Nanos(at) = level.at;
            seen.edge(&mut high, level.channel.0.into(), at, level.high);
        }
        seen.high = high.iter().flatten().count();
        seen
    }
}
