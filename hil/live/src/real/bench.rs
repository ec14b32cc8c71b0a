//! A real bench, opened: interfaces, adapters, and the guardian that watches over them.

use std::path::PathBuf;
use std::time::Duration;

use palpate_buses::can::{CanBuses, Note, Tally};
use palpate_buses::guardian::{Guardian, Latch, StartError, Watch, WatchedBus};
use palpate_buses::hardware::Hardware;
use palpate_buses::i2c::{Line, LinuxAdapter};
use palpate_buses::pacer::RunClock;
use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::guard::Guard;
use palpate_core::skin::Layout;
use palpate_core::units::Instant;
use palpate_files::{Bench, Real, Setup};
use palpate_run::skin_end::CanEnd;
use palpate_run::{Failure, plan};

use crate::again;

/// Section of a real bench's buses.
pub(super) fn real_of(setup: &Setup) -> Result<&Real, Failure> {
    let bench = &setup.bench.value;
    bench
        .real
        .as_ref()
        .ok_or_else(|| Failure::Input(format!("bench `{}`: expected kind = \"real\"", bench.name)))
}

/// Watch of the guardian over a bench.
pub fn watch(bench: &Bench, real: &Real) -> Watch {
    let ms = |ms: u32| Duration::from_millis(ms.into());
    let mut converters = plan::converters(bench).map_or(&[][..], |c| c.addresses);
    let bus = |(path, boards): (&PathBuf, Vec<u8>)| {
        let (own, others) = converters.split_at(boards.len().min(converters.len()));
        converters = others;
        WatchedBus {
            path: path.clone(),
            boards: match &bench.haptics {
                None => boards,
                Some(_) => Vec::new(),
            },
            converters: own.to_vec(),
            motors: bench
                .haptics
                .as_ref()
                .map_or_else(Vec::new, plan::motors::behind),
        }
    };
    Watch {
        buses: real.i2c.iter().zip(plan::buses(bench)).map(bus).collect(),
        oe: real.oe.as_ref().map(|oe| (oe.chip.clone(), oe.line)),
        heartbeat: ms(real.heartbeat_ms),
        transfer: ms(real.transfer_ms),
    }
}

/// Refuses a bench whose own limits of time would let a burst pass its limit: a wire that is on when the run hangs, or when
/// its transfer does, stays on until that is noticed, and for the rest of a PWM period.
///
/// # Errors
/// [`Failure::Input`] with the arithmetic.
pub fn refuse_slow(real: &Real, guard: &Guard) -> Result<(), Failure> {
    let ms = |us: u64| us as f64 * 1e-3;
    let (burst, rest) = (
        guard.limits().burst.as_micros(),
        guard.surplus().as_micros(),
    );
    let most = burst.saturating_sub(rest) / 1000;
    let rows = [
        ("heartbeat_ms", real.heartbeat_ms, 5, "a run that hangs"),
        ("transfer_ms", real.transfer_ms, 1, "a transfer that hangs"),
    ];
    let (actuator, limit) = match guard.motors() {
        None => ("wire", "burst.length_ms of the limits"),
        Some(_) => ("motor", "haptics.burst_ms"),
    };
    let slow = rows.into_iter().find(|row| u64::from(row.1) > most);
    slow.map_or(Ok(()), |(key, value, least, what)| {
        let expected = match most < least {
            true => format!("no value from {least} fits, raise drive.pwm_hz, which is too low for the burst limit"),
            false => format!("expected at most {most}"),
        };
        Err(Failure::Input(format!(
            "real.{key}: {expected}, found {value}: {what} as a burst begins leaves the {actuator} on for so many ms, and then for {:.1} ms, a PWM period and the bus; a burst may last {} ms ({limit})",
            ms(rest),
            ms(burst)
        )))
    })
}

/// Refuses while a stop is latched.
///
/// # Errors
/// [`Failure::Guard`] with the cause of the stop and the way to clear it.
pub fn refuse_latched(watch: &Watch) -> Result<(), Failure> {
    for bus in &watch.buses {
        // Opening an adapter that is not there tells more.
        let Ok(hardware) = Hardware::adapter(&bus.path) else {
            continue;
        };
        if let Some(held) = Latch::new(&hardware).read() {
            return Err(Failure::Guard(held.refusal(&hardware)));
        }
    }
    Ok(())
}

/// Every adapter, and the guardian over them, last: from then on it can say off. Then what it found driving.
pub(super) fn guarded(watch: &Watch) -> Result<(Vec<Line>, Guardian, String), Failure> {
    let device = |e: &dyn std::fmt::Display| Failure::Device(e.to_string());
    let mut lines = Vec::new();
    for bus in &watch.buses {
        let adapter = LinuxAdapter::open(&bus.path, &bus.addresses()).map_err(|e| device(&e))?;
        lines.push(Line::new(adapter, watch.transfer).map_err(|e| device(&e))?);
    }
    let program = again::again().map_err(|e| device(&e))?;
    let (guardian, found) = Guardian::start(program, watch).map_err(|e| unguarded(&e))?;
    Ok((lines, guardian, found))
}

/// Failure for a run that has no guardian.
pub fn unguarded(error: &StartError) -> Failure {
    match error {
        StartError::Latched(_) => Failure::Guard(error.to_string()),
        _ => Failure::Device(error.to_string()),
    }
}

/// Interfaces of a bench: time passes there by itself.
pub struct Interfaces {
    buses: CanBuses,
    /// Each one's number on the bench.
    numbers: Vec<u8>,
}

impl Interfaces {
    /// Opens the interfaces of a bench, one for each bus of the layout.
    pub(super) fn open(real: &Real, layout: &Layout, clock: RunClock) -> Result<Self, Failure> {
        Self::numbered((0..).zip(interfaces(real, layout)?).collect(), clock)
    }

    /// The interfaces that carry boards of this layout.
    pub(super) fn of_boards(
        real: &Real,
        layout: &Layout,
        clock: RunClock,
    ) -> Result<Self, Failure> {
        let all = (0..).zip(interfaces(real, layout)?);
        let needed = all.filter(|(_, (_, boards))| !boards.is_empty());
        Self::numbered(needed.collect(), clock)
    }

    fn numbered(all: Vec<(u8, (String, Vec<u8>))>, clock: RunClock) -> Result<Self, Failure> {
        let (numbers, all): (Vec<u8>, Vec<_>) = all.into_iter().unzip();
        let buses = CanBuses::open(&all, clock).map_err(|e| Failure::Device(e.to_string()))?;
        Ok(Self { buses, numbers })
    }

    /// The oldest note not yet taken.
    pub(super) fn note(&mut self) -> Option<Note> {
        self.buses.note()
    }

    /// Tallies of all interfaces of the bench; zero for those that are not read here.
    pub(super) fn tallies(&self) -> Vec<Tally> {
        let count = self.numbers.last().map_or(0, |last| usize::from(*last) + 1);
        let mut all = vec![Tally::default(); count];
        for (number, tally) in self.numbers.iter().zip(self.buses.tallies()) {
            all[usize::from(*number)] = tally;
        }
        all
    }
}

impl CanBus for Interfaces {
    type Error = <CanBuses as CanBus>::Error;

    fn receive(&mut self) -> Result<Option<Received>, Self::Error> {
        let numbered = |received: Received| Received {
            bus: (self.numbers.get(usize::from(received.bus)).copied()).unwrap_or(received.bus),
            ..received
        };
        Ok(self.buses.receive()?.map(numbered))
    }

    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), Self::Error> {
        let own = self.numbers.iter().position(|number| *number == bus);
        // An interface outside the list is refused below, as an absent one.
        self.buses
            .transmit(own.map_or(u8::MAX, |own| own as u8), frame)
    }
}

impl CanEnd for Interfaces {
    fn advance_to(&mut self, _now: Instant) {}
}

/// Each interface with the boards that the layout has on its bus.
fn interfaces(real: &Real, layout: &Layout) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let mut interfaces: Vec<(String, Vec<u8>)> =
        real.can.iter().map(|name| (name.clone(), vec![])).collect();
    let needed = layout.modules().iter().filter_map(|m| m.address());
    for address in needed {
        let count = interfaces.len();
        let Some((_, boards)) = interfaces.get_mut(usize::from(address.bus)) else {
            return Err(Failure::Input(format!(
                "the layout has boards on CAN bus {}, the bench names {count} interfaces; give one `--can` (or `real.can` entry) a bus",
                address.bus
            )));
        };
        if !boards.contains(&address.board) {
            boards.push(address.board);
        }
    }
    Ok(interfaces)
}

#[cfg(test)]
#[path = "bench_tests.rs"]
mod tests;
