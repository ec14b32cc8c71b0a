//! What holds for every kind of unit: the model and the process here, images in `tests/qemu`.

use palpate_core::codec::link::{Command, Header, Hello, Key, Kind, MOST, Planned, Said};
use palpate_core::driver::{Actuators, UnitDriver, UnitSettings};
use palpate_core::guard::{Guard, HARD, WornWire};
use palpate_core::illusion::DisplayWire;
use palpate_core::random::RandomStream;
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Board, Channel, Duration, Instant, Milliamps, Point, Ticks};

/// The key of every unit here; images are built with it.
pub const KEY: [u8; 32] = [9; 32];

/// What its outputs did.
#[derive(Clone, Debug, Default)]
pub struct Seen {
    /// Edges that went high: when, by the subject's clock, us.
    pub rising: Vec<u64>,
    /// The longest pulse, us.
    pub longest_us: f64,
    /// Outputs that were high at the end.
    pub high: usize,
    /// Datagrams refused.
    pub refused: u64,
}

impl Seen {
    /// An output of board 0 changed.
    pub fn edge(&mut self, high: &mut [Option<u64>; 16], channel: usize, t_ns: u64, up: bool) {
        if up {
            self.rising.push(t_ns / 1000);
            high[channel] = Some(t_ns);
        } else if let Some(since) = high[channel].take() {
            self.longest_us = self.longest_us.max((t_ns - since) as f64 / 1e3);
        }
    }
}

/// A unit with eight wires on the board at 0x40 and a Peltier module, under [`KEY`].
pub trait Subject {
    /// The host's clock.
    fn now(&self) -> Instant;

    /// Sends a datagram to it.
    fn send(&mut self, datagram: &[u8]);

    /// Lets time pass; what came back from it.
    fn pass(&mut self, time: Duration) -> Vec<Vec<u8>>;

    /// Ends it.
    fn end(self) -> Seen;
}

/// The wires of every subject.
pub fn wires() -> Vec<DisplayWire> {
    let wire = |n: u8| DisplayWire {
        place: Point::new(f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    (0..8).map(wire).collect()
}

pub(super) const STEP: Duration = Duration::from_millis(2);

pub(super) fn host(nonce: u64) -> UnitDriver {
    let settings = UnitSettings {
        delay: Duration::from_millis(20),
        resumes: false,
    };
    UnitDriver::new(&KEY, nonce, settings)
}

/// Both speak for so long; the skin is read all the time.
pub(super) fn speak(subject: &mut impl Subject, driver: &mut UnitDriver, time: Duration) {
    let end = subject.now() + time;
    while subject.now() < end {
        let now = subject.now();
        let mut buffer = [0; MOST];
        if let Some(datagram) = driver.datagram(now, Some(now), &mut buffer) {
            subject.send(datagram);
        }
        for mut datagram in subject.pass(STEP) {
            let _ = driver.hear(subject.now(), &mut datagram);
        }
    }
}

pub fn plays_what_it_is_told(mut subject: impl Subject) {
    let mut driver = host(1);
    speak(&mut subject, &mut driver, Duration::from_millis(100));
    assert_eq!(driver.ready(subject.now()), Ok(()));
    // Ticks as the unit counts them.
    let plant = driver.hello().unwrap().plant;
    let mut guard = Guard::new(HARD, plant, &wires(), WornWire::default()).unwrap();
    let at = subject.now();
    guard.hear(at);
    let stimulus = Stimulus {
        wire: 2,
        width: Ticks::new(40),
        peak: plant.peak,
        at,
        until: at + Duration::from_millis(35),
    };
    let update = guard.admit(at, Board(0), &[stimulus], |_| ());
    driver.apply(&update).unwrap();
    speak(&mut subject, &mut driver, Duration::from_millis(150));
    let status = *driver.status().unwrap();
    assert_eq!((status.applied, status.limited, status.dropped), (1, 0, 0));
    let seen = subject.end();
    let period_us = plant.prescale.period_ns() / 1000;
    let bursts = 35_000 / period_us;
    let pulses = seen.rising.len() as u64;
    assert!(
        (bursts - 1..=bursts + 2).contains(&pulses),
        "{pulses} of {bursts}"
    );
    let width_us = 40.0 * plant.prescale.period_ns() as f64 / 4096e3;
    assert!((seen.longest_us - width_us).abs() < 2.0, "{seen:?}");
    assert_eq!(seen.high, 0);
}

/// So many datagrams of `ci/hostile`, a hundredth of them in an ordinary test.
fn datagrams() -> usize {
    let asked = std::env::var("PALPATE_DATAGRAMS").ok();
    asked.and_then(|n| n.parse().ok()).unwrap_or(10_000)
}

/// A datagram of no valid session.
fn hostile(dice: &mut RandomStream, hello: Option<Header>) -> Vec<u8> {
    let mut draw = |below: u64| dice.next_u64() % below;
    let kinds = [Kind::Knock, Kind::Hello, Kind::Command, Kind::Status];
    let header = Header {
        kind: kinds[draw(4) as usize],
        host: draw(4),
        unit: hello.map_or(0, |h| h.unit.wrapping_sub(1 + draw(3))),
        sequence: draw(1 << 20),
    };
    let plan: Vec<Planned> = (0..draw(20))
        .map(|n| Planned {
            board: Board(draw(2) as u8),
            channel: Channel(n as u8 % 16),
            width: Ticks::new(4095),
            current: Milliamps(0),
            at: Instant::from_micros(draw(10_000_000)),
            until: Instant::FAR_FUTURE,
        })
        .collect();
    let key = Key::new(if draw(2) == 0 { &KEY } else { &[1; 32] });
    let mut buffer = [0; MOST];
    let says = Said {
        reading: Instant::FAR_FUTURE,
        ..Said::default()
    };
    let write = |out: &mut [u8]| Command::write(out, &says, &plan);
    let mut datagram = key.seal(&header, &mut buffer, write).to_vec();
    match draw(4) {
        0 => datagram.truncate(draw(60) as usize),
        1 => {
            let at = draw(datagram.len() as u64) as usize;
            datagram[at] ^= 1 << draw(8);
        }
        2 => datagram.iter_mut().for_each(|byte| *byte = draw(256) as u8),
        _ => {}
    }
    datagram
}

pub fn drives_nothing_without_a_session(mut subject: impl Subject) {
    let mut dice = RandomStream::new(7, "hostile datagrams");
    // What the unit said of itself to an honest knock: its next challenge is known to every holder of the key.
    let mut driver = host(1_000_000);
    speak(&mut subject, &mut driver, Duration::from_millis(30));
    let key = Key::new(&KEY);
    let mut buffer = [0; MOST];
    let knock = Header {
        kind: Kind::Knock,
        host: 2_000_000,
        unit: 0,
        sequence: 1,
    };
    subject.send(key.seal(&knock, &mut buffer, |_| 0));
    let answers = subject.pass(Duration::from_millis(20));
    let hello = answers
        .iter()
        .find_map(|datagram| Header::read(datagram).ok());
    let total = datagrams();
    for n in 0..total {
        subject.send(&hostile(&mut dice, hello));
        // As fast as it takes them, so that none is lost on its way.
        if n % 64 == 63 {
            subject.pass(Duration::from_millis(1));
        }
    }
    // It still answers.
    let mut after = host(3_000_000);
    speak(&mut subject, &mut after, Duration::from_millis(700));
    assert_eq!(after.ready(subject.now()), Ok(()));
    let seen = subject.end();
    assert_eq!((seen.rising.len(), seen.high), (0, 0), "{seen:?}");
    assert!(
        seen.refused > total as u64 / 2,
        "{} of {total}",
        seen.refused
    );
}

/// A host with the key that asks for whole periods, without an end and with readings of the future.
pub fn limits_a_host_that_lies(mut subject: impl Subject) {
    let key = Key::new(&KEY);
    let knock = Header {
        kind: Kind::Knock,
        host: 77,
        unit: 0,
        sequence: 1,
    };
    let mut buffer = [0; MOST];
    let asked = subject.now();
    subject.send(key.seal(&knock, &mut buffer, |_| 0));
    let answers = subject.pass(Duration::from_millis(30));
    let greeted = Header::read(answers.last().unwrap()).unwrap();
    let mut datagram = answers.last().unwrap().clone();
    let hello = Hello::read(key.open(&mut datagram).unwrap()).unwrap();
    let mut unit_now = hello.now + subject.now().since(asked);
    for n in 0..150_u64 {
        let header = Header {
            kind: Kind::Command,
            host: 77,
            unit: greeted.unit,
            sequence: 2 + n,
        };
        let plan: Vec<Planned> = (0..8)
            .map(|channel| Planned {
                board: Board(0),
                channel: Channel(channel),
                width: Ticks::new(4095),
                current: Milliamps(4095),
                at: unit_now + Duration::from_millis(5),
                until: unit_now + Duration::from_millis(10_000),
            })
            .collect();
        let says = Said {
            reading: Instant::FAR_FUTURE,
            ..Said::default()
        };
        let write = |out: &mut [u8]| Command::write(out, &says, &plan);
        subject.send(key.seal(&header, &mut buffer, write));
        let before = subject.now();
        subject.pass(Duration::from_millis(10));
        unit_now += subject.now().since(before);
    }
    let seen = subject.end();
    // The clock of an emulated chip is exact; the guard counts with the slowest it may be.
    assert!(
        !seen.rising.is_empty() && seen.longest_us <= 200.0,
        "{seen:?}"
    );
    assert_eq!(seen.high, 0);
}
