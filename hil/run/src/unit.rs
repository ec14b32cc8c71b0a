//! A bench whose boards hang on a driver unit: the host's end of the link, and the emulated unit behind an emulated
//! network.

use palpate_core::codec::link::{MOST, State};
use palpate_core::driver::{
    Actuators, Banks, Driver, DriverError, Traffic, UnitDriver, UnitSettings,
};
use palpate_core::guard::Guarded;
use palpate_core::peltier::Regulator;
use palpate_core::projector::Projector;
use palpate_core::random::RandomStream;
use palpate_core::units::{Board, Duration, Instant};
use palpate_emulators::display::i2c::I2cHandle;
use palpate_emulators::display::i2c::fault::Shared;
use palpate_emulators::display::peltier::PeltierHandle;
use palpate_emulators::network::Profile;
use palpate_emulators::time::Nanos;
use palpate_emulators::unit::{Crystal, EmulatedUnit, OeLine, Settings};
use palpate_files::{Bench, BenchUnit, Network};
use palpate_records::trace::Event;
use serde::Serialize;

use crate::failure::Failure;
use crate::output_enable::OutputEnable;
use crate::place::Place;
use crate::plan;

/// The key of an emulated unit, none of whose datagrams leaves the process.
const KEY: [u8; 32] = [0x5A; 32];

/// Counts of a driver unit and its link.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct UnitReport {
    /// Stimuli that the unit began.
    pub begun: u32,
    /// Stimuli that the unit's own guard changed or refused.
    pub limited: u32,
    /// Stimuli that the unit left out: too late, after too old a reading, while stopped.
    pub dropped: u32,
    /// Largest lateness of a beginning, microseconds.
    pub late_us: u32,
    /// Times that the unit stopped by itself.
    pub stops: u32,
    /// Datagrams that the unit refused.
    pub refused: u32,
    /// Commands sent.
    pub commands: u64,
    /// Answers taken.
    pub answers: u64,
    /// Datagrams that the network lost, both ways.
    pub lost: u64,
    /// Sessions begun.
    pub sessions: u64,
}

impl UnitReport {
    /// Words of the report, in a line.
    #[must_use]
    pub fn words(&self) -> String {
        format!(
            "{} stimuli begun, at most {} us late; {} changed by its guard, {} left out, {} stops; {} commands, {} datagrams lost, {} sessions",
            self.begun,
            self.late_us,
            self.limited,
            self.dropped,
            self.stops,
            self.commands,
            self.lost,
            self.sessions
        )
    }
}

/// A Peltier module, and the regulator that a unit uses for it.
pub(crate) type Lent = (PeltierHandle, Regulator);

/// A unit, and the host's state of its link.
pub struct RemoteUnit {
    driver: UnitDriver,
    air: EmulatedUnit<Shared<I2cHandle>, OeLine, PeltierHandle>,
    profile: Profile,
    boards: u8,
    /// Time of the newest reading of the skin.
    reading: Option<Instant>,
    now: Instant,
    state: State,
}

const fn profile(network: Network) -> Profile {
    match network {
        Network::Wire => Profile::WIRE,
        Network::Wifi => Profile::WIFI,
        Network::Rough => Profile::ROUGH,
    }
}

impl RemoteUnit {
    /// The unit of a bench, with the limits and wires of the projector's guard.
    ///
    /// # Errors
    /// [`Failure::Input`] for what no unit can be.
    pub fn new(
        (bench, unit): (&Bench, &BenchUnit),
        projector: &Projector,
        (i2c, line): (Shared<I2cHandle>, OeLine),
        module: Option<Lent>,
        seed: u64,
    ) -> Result<Self, Failure> {
        let addresses = &*plan::boards(bench);
        let guard = projector.guard();
        let settings = Settings {
            key: &KEY,
            boot: RandomStream::new(seed, "start of the unit").next_u64(),
            wires: projector.display().wires(),
            addresses,
            limits: *guard.limits(),
            plant: *guard.plant(),
            worn: guard.worn().filter(|_| unit.heat),
            converters: plan::converters(bench),
        };
        let profile = profile(unit.network);
        let crystal = Crystal {
            ppm: unit.drift_ppm,
        };
        let network = (profile, crystal);
        let air = EmulatedUnit::warming(&settings, (i2c, line), module, network, seed);
        let nonce = RandomStream::new(seed, "host of the unit").next_u64();
        let delay = Duration::from_micros(u64::from(unit.delay_ms) * 1000);
        let resumes = true; // as every stop of an emulated bench ends by itself
        Ok(Self {
            driver: UnitDriver::new(&KEY, nonce, UnitSettings { delay, resumes }),
            air: air.map_err(|e| Failure::Input(format!("unit: {e}")))?,
            profile,
            boards: addresses.len() as u8, // at most 16
            reading: None,
            now: Instant::ZERO,
            state: State::Ready,
        })
    }

    /// Time of the next event on the unit's side, if that is before `now`.
    pub fn due(&self, now: Nanos) -> Option<Nanos> {
        Some(self.air.next()).filter(|at| *at < now)
    }

    /// Runs the unit's program at `at`, where its boards have been advanced to; datagrams that reach the host are
    /// heard.
    pub fn run(&mut self, at: Nanos, events: &mut Vec<Event>) {
        self.air.run(at);
        let heard = Instant::from_micros(at.as_micros());
        while let Some(mut datagram) = self.air.hear(at) {
            // Refused datagrams are counted.
            let _ = self.driver.hear(heard, &mut datagram);
        }
        self.now = self.now.max(heard);
        let state = self.driver.status().map_or(self.state, |s| s.state);
        if state != self.state {
            let text = match state {
                State::Ready => "unit: drives again".to_owned(),
                State::Stopped(cause) => {
                    format!("unit: stopped by its own guard, {}", cause.word())
                }
            };
            events.push(Event::note(heard, text));
            self.state = state;
        }
    }

    /// Sends the commands that are due at `now`, with the time of the newest reading.
    pub fn tell(&mut self, now: Instant, reading: Option<Instant>) {
        self.now = now;
        self.reading = reading.or(self.reading);
        self.flush();
    }

    fn flush(&mut self) {
        let mut buffer = [0; MOST];
        let datagram = self.driver.datagram(self.now, self.reading, &mut buffer);
        if let Some(datagram) = datagram {
            self.air.send(Nanos::from(self.now), datagram);
        }
    }

    /// The host's end of its link.
    pub(crate) const fn driver(&mut self) -> &mut UnitDriver {
        &mut self.driver
    }

    /// Cuts the network, or opens it again.
    pub const fn set_cut(&mut self, cut: bool) {
        self.air.set_cut(cut);
    }

    /// Makes the air rough, or as the bench has it.
    pub const fn set_rough(&mut self, rough: bool) {
        let profile = if rough { Profile::ROUGH } else { self.profile };
        self.air.set_profile(profile);
    }

    /// Report of unit and link so far.
    pub fn report(&self) -> UnitReport {
        let (counts, link) = (self.air.unit().counts(), self.driver.counts());
        UnitReport {
            begun: counts.applied,
            limited: counts.limited,
            dropped: counts.dropped,
            late_us: counts.late_us,
            stops: counts.stops,
            refused: counts.refused,
            commands: link.sent,
            answers: link.answered,
            lost: self.air.lost(),
            sessions: link.sessions,
        }
    }
}

impl Actuators for RemoteUnit {
    type Error = DriverError;

    fn apply(&mut self, update: &Guarded) -> Result<(), DriverError> {
        self.driver.apply(update)
    }

    fn all_off(&mut self) -> Result<(), DriverError> {
        let told = self.driver.all_off();
        self.flush();
        told
    }
}

impl Driver for RemoteUnit {
    fn start(&mut self, now: Instant) -> Result<Instant, DriverError> {
        self.tell(now, None);
        let ready = self.driver.ready(now).map(|()| now);
        ready.map_err(DriverError::Unit)
    }

    fn verify(&mut self) -> Result<(), DriverError> {
        self.driver.ready(self.now).map_err(DriverError::Unit)
    }

    fn retries(&self) -> u64 {
        0
    }

    fn traffic(&self) -> Traffic {
        self.air.unit().traffic()
    }

    fn boards(&self) -> Vec<Board> {
        (0..self.boards).map(Board).collect()
    }
}

/// Stands in for the line that cuts outputs: the host of a unit has none.
pub struct NoLine;

impl OutputEnable for NoLine {
    fn set_enabled(&self, _now: Instant, _enabled: bool) {}

    /// The unit knows when each stimulus ends, and ends it whether it hears more or not.
    fn cuts(&self) -> bool {
        true
    }

    fn words(&self) -> &'static str {
        "the unit switches off by itself 100 ms after the newest reading"
    }
}

/// Driver of an emulated bench's boards.
pub enum EmulatedDriver {
    /// The host itself.
    Wired(Banks<Shared<I2cHandle>>),
    /// A unit behind a network.
    Unit(Box<RemoteUnit>),
}

impl EmulatedDriver {
    /// Driver of a bench: its unit, or the host itself.
    ///
    /// # Errors
    /// [`Failure::Input`] for what no unit can be.
    pub fn new(
        bench: &Bench,
        projector: &Projector,
        (i2c, bus): (Shared<I2cHandle>, I2cHandle),
        (place, module): (&Place, Option<Lent>),
        seed: u64,
    ) -> Result<Self, Failure> {
        let Some(unit) = &bench.unit else {
            let banks = plan::banks(bench, i2c, projector.guard().prescale());
            return Ok(Self::Wired(match place.alone {
                true => banks,
                false => banks.sharing(&place.channels),
            }));
        };
        let lines = (i2c, OeLine(bus));
        let unit = RemoteUnit::new((bench, unit), projector, lines, module, seed)?;
        Ok(Self::Unit(Box::new(unit)))
    }

    /// The unit, where there is one.
    pub const fn unit(&mut self) -> Option<&mut RemoteUnit> {
        match self {
            Self::Wired(_) => None,
            Self::Unit(unit) => Some(unit),
        }
    }

    /// The boards or the unit, as the loop drives them.
    pub fn boards(&mut self) -> &mut dyn Driver {
        match self {
            Self::Wired(banks) => banks,
            Self::Unit(unit) => &mut **unit,
        }
    }
}
