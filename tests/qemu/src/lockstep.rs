//! A host and a network in the guest's own time.

use std::collections::VecDeque;
use std::io;
use std::path::Path;

use palpate_core::codec::link::MOST;
use palpate_core::driver::{Actuators, DriverError, UnitDriver, UnitSettings};
use palpate_core::guard::{Guard, Plant, WornWire};
use palpate_core::schedule::{Entry, Stimulus};
use palpate_core::units::{Board, Duration, Instant, Ticks};
use palpate_emulators::network::{Profile, Way};
use palpate_emulators::time::Nanos;
use palpate_image::rig::{Head, Kind, LIMITS, Outcome, WIRES};

use crate::chips::{Answer, Chips};
use crate::guest::{Guest, Machine, Network};

/// The host's program looks this often.
const LOOK: Nanos = Nanos::from_micros(1000);
/// How far ahead of the guest's clock the host's is.
const AHEAD: Duration = Duration::from_millis(3_000);

/// A host in virtual time: its driver, its own guard, and the network between.
#[derive(Debug)]
pub struct Host {
    /// Its end of the link.
    pub driver: UnitDriver,
    guard: Guard,
    there: Way,
    back: Way,
    now: Instant,
    /// When the newest reading of the skin was received.
    reading: Instant,
    /// The skin is read.
    pub reads: bool,
    /// The program runs.
    pub lives: bool,
    /// Every datagram that it sent.
    pub sent: Vec<Vec<u8>>,
    /// Datagrams that reach the unit at its next looks, of any sender.
    pub injected: VecDeque<Vec<u8>>,
    /// Every datagram of the unit.
    pub heard: Vec<Vec<u8>>,
}

impl Host {
    /// A host of a unit with this key.
    ///
    /// # Errors
    /// What no plant can be.
    pub fn new(key: &[u8; 32], nonce: u64, profile: Profile) -> io::Result<Self> {
        let settings = UnitSettings {
            delay: Duration::from_millis(20),
            resumes: true,
        };
        let guard = Guard::new(LIMITS, Plant::default(), &WIRES, WornWire::default());
        Ok(Self {
            driver: UnitDriver::new(key, nonce, settings),
            guard: guard.map_err(io::Error::other)?,
            there: Way::new(profile, nonce, "network to the unit"),
            back: Way::new(profile, nonce, "network from the unit"),
            now: Instant::ZERO,
            reading: Instant::ZERO,
            reads: true,
            lives: true,
            sent: Vec::new(),
            injected: VecDeque::new(),
            heard: Vec::new(),
        })
    }

    /// Its clock.
    pub const fn now(&self) -> Instant {
        self.now
    }

    /// Asks for a burst of some wires of a board. Returns how many of them its guard passed.
    ///
    /// # Errors
    /// What the driver says to it.
    pub fn burst(
        &mut self,
        board: u8,
        wires: &[u16],
        width: u16,
        length: Duration,
    ) -> Result<u32, DriverError> {
        let at = self.now;
        let stimulus = |wire: &u16| Stimulus {
            wire: *wire,
            width: Ticks::new(width),
            peak: Plant::default().peak,
            at,
            until: at + length,
        };
        let stimuli: Vec<_> = wires.iter().map(stimulus).collect();
        self.guard.hear(at);
        let mut passed = 0;
        let count = |entry: Entry| passed += u32::from(entry.off > entry.on);
        let update = self.guard.admit(at, Board(board), &stimuli, count);
        self.driver.apply(&update).map(|()| passed)
    }

    /// Its program at this time of the guest's.
    fn look(&mut self, at: Nanos) {
        self.now = Instant::from_micros(at.0 / 1000) + AHEAD;
        if !self.lives {
            return;
        }
        if self.reads {
            self.reading = self.now;
        }
        while let Some(mut datagram) = self.back.land(at) {
            // Refused ones are counted by the driver.
            let _ = self.driver.hear(self.now, &mut datagram);
        }
        let mut buffer = [0; MOST];
        let datagram = self
            .driver
            .datagram(self.now, Some(self.reading), &mut buffer);
        if let Some(datagram) = datagram {
            self.sent.push(datagram.to_vec());
            self.there.send(at, datagram);
        }
    }
}

/// A guest, its boards and its host.
#[derive(Debug)]
pub struct Lockstep {
    guest: Guest,
    /// The boards.
    pub chips: Chips,
    /// The host.
    pub host: Host,
    /// When the host's program last looked.
    looked: Nanos,
    /// QEMU's other thread is woken all the time.
    pub disturbed: bool,
    /// Longest that the guest was busy with a datagram before it asked again.
    pub longest: Nanos,
    /// When the guest was given a datagram, if that was the last answer.
    given: Option<Nanos>,
    /// A question that waits for the next run.
    waiting: Option<(Head, Vec<u8>)>,
}

impl Lockstep {
    /// Starts an image.
    ///
    /// # Errors
    /// When QEMU cannot be had.
    pub fn start(machine: Machine, image: &Path, (chips, host): (Chips, Host)) -> io::Result<Self> {
        Ok(Self {
            guest: Guest::start(machine, image, Network::Rig)?,
            chips,
            host,
            looked: Nanos::ZERO,
            disturbed: false,
            longest: Nanos::ZERO,
            given: None,
            waiting: None,
        })
    }

    /// How far it has come.
    pub const fn now(&self) -> Nanos {
        self.looked
    }

    /// Lets the guest run for so long.
    ///
    /// # Errors
    /// When the guest ended or hangs.
    pub fn run(&mut self, length: Duration) -> io::Result<()> {
        let until = self.looked + Nanos(length.as_micros() * 1000);
        loop {
            let next = self.waiting.take().or_else(|| self.guest.question());
            let gone = || io::Error::other("the guest ended, or says nothing");
            let (head, bytes) = next.ok_or_else(gone)?;
            while self.looked + LOOK <= Nanos(head.ns) && self.looked < until {
                self.looked = self.looked + LOOK;
                self.host.look(self.looked);
            }
            if self.looked >= until {
                self.waiting = Some((head, bytes));
                self.chips.advance(until);
                return Ok(());
            }
            if let Some(given) = self.given.take() {
                self.longest = self.longest.max(Nanos(head.ns).since(given));
            }
            let (ns, outcome, bytes) = self.answer(&head, bytes);
            let takes = head.kind() == Some(Kind::Receive) && outcome == Outcome::Done;
            self.given = takes.then_some(Nanos(head.ns));
            if self.disturbed {
                self.guest.disturb()?;
            }
            self.guest.answer(ns, outcome, &bytes)?;
        }
    }

    fn answer(&mut self, head: &Head, bytes: Vec<u8>) -> Answer {
        if let Some(answer) = self.chips.answer(head, &bytes) {
            return answer;
        }
        let now = Nanos(head.ns);
        let host = &mut self.host;
        if head.kind() == Some(Kind::Send) {
            host.back.send(now, &bytes);
            host.heard.push(bytes);
            return (head.ns, Outcome::Done, Vec::new());
        }
        if let Some(datagram) = host.injected.pop_front().or_else(|| host.there.land(now)) {
            return (head.ns, Outcome::Done, datagram);
        }
        let look = self.looked + LOOK;
        let next = host.there.next().map_or(look, |lands| lands.min(look));
        (next.0, Outcome::Nothing, Vec::new())
    }

    /// The guest's memory now.
    ///
    /// # Errors
    /// When the guest ended, or QEMU has not written it within a minute of the guest's.
    pub fn memory(&mut self) -> io::Result<Vec<u8>> {
        self.guest.save_memory()?;
        for _ in 0..6000 {
            if let Some(memory) = self.guest.memory() {
                return Ok(memory);
            }
            self.run(Duration::from_millis(10))?;
        }
        Err(io::Error::other("the guest's memory was not written"))
    }
}
