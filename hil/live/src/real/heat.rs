//! Heat and dose of a run on hardware, which outlive it: the ledger before it, and the bookings of it.

use std::sync::{Mutex, OnceLock};

use palpate_buses::hardware::Hardware;
use palpate_buses::ledger::{self, Fingertip, Keeper, Ledger, LedgerError, Output};
use palpate_core::guard::{Doses, Guard, Memory};
use palpate_core::units::Instant;
use palpate_files::{Bench, Loaded, Setup};
use palpate_run::Failure;

use crate::link::UnitPlace;
use crate::lock::held;

/// Account of wearers whose file has no name.
const WEARER: &str = "wearer";

/// Accounts of a run's heat and dose.
pub struct Heat {
    /// The ledger, until the hardware is the run's own.
    ledger: Mutex<Option<Ledger>>,
    keeper: OnceLock<Keeper>,
    /// Words that tell how heat and dose are forgotten.
    way_out: String,
}

/// Names of the hardware on a bench's adapters.
pub(super) fn of_adapters(bench: &Loaded<Bench>) -> Result<Vec<String>, Failure> {
    let real = bench.value.real.as_ref();
    let adapters = real.into_iter().flat_map(|real| &real.i2c);
    let names = adapters.map(|path| Hardware::adapter(path).map(|own| own.file().to_owned()));
    let names: Result<_, _> = names.collect();
    names.map_err(|unknown| Failure::Device(unknown.to_string()))
}

/// Hardware that the wires of a run hang on.
enum HungOn {
    /// Adapters, by the bench's numbers.
    Adapters(Vec<String>),
    /// A driver unit, with buses of its own.
    Unit(String),
}

/// The name of a driver unit.
pub(super) fn of_unit(place: &UnitPlace) -> String {
    place.hardware().file().to_owned()
}

/// Account of a wearer by the name in their file; all without a name share one.
fn of_wearer(name: Option<&str>) -> String {
    name.map_or_else(|| WEARER.into(), |name| format!("{WEARER}-{name}"))
}

/// The account of the wearer of a unit that is a process here: the unit is never told who wears its boards.
fn of_boards(hardware: &str) -> String {
    format!("unit-on-{hardware}")
}

/// Command that forgets heat and dose: of this bench, and of a wearer with a name.
fn way_out(bench: &Loaded<Bench>, wearers: &[&str]) -> String {
    let bench_of = match bench.value.unit_address() {
        Some(unit) => format!("--unit {unit} --key FILE --forget-heat {unit}"),
        None => format!(
            "--bench {} --forget-heat {}",
            bench.source.label(),
            bench.value.name
        ),
    };
    let wearers = wearers.iter().map(|name| format!(" --wearer {name}"));
    format!(
        "Let the wearer rest, then type: hil off {bench_of}{}",
        wearers.collect::<String>()
    )
}

/// Forgets the heat of a bench's hardware and the dose of who wears it, by the names in their files; of none, of those who have
/// no name. Whether there was any.
///
/// # Errors
/// [`Failure::Device`] while a run books there, and what the system says.
pub fn forget(bench: &Loaded<Bench>, wearers: &[String]) -> Result<bool, Failure> {
    let mut hardware = of_adapters(bench)?;
    let mut worn: Vec<String> = hardware.iter().map(|name| of_boards(name)).collect();
    hardware.extend(UnitPlace::find(bench)?.as_ref().map(of_unit));
    worn.extend(wearers.iter().map(|name| of_wearer(Some(name))));
    if wearers.is_empty() {
        worn.push(of_wearer(None));
    }
    ledger::forget(&ledger::folder(), &hardware, &worn)
        .map_err(|error| Failure::Device(error.to_string()))
}

impl Heat {
    /// Reads the accounts of a bench's hardware and wearers. The guard of each fingertip, which has this setup alone,
    /// goes on from them. Where the setup has a memory already, dose is kept elsewhere and counts as in that memory.
    ///
    /// # Errors
    /// [`Failure::Guard`] where heat or dose cannot be read, or the dose is spent, with the command that mends it.
    pub(super) fn open(bench: &Loaded<Bench>, fingertips: &mut [Setup]) -> Result<Self, Failure> {
        if bench.value.haptics.is_some() {
            // Motors do not heat tissue, and their guard begins as if an earlier run had spent their coils' heat.
            return Ok(Self {
                ledger: Mutex::new(None),
                keeper: OnceLock::new(),
                way_out: String::new(),
            });
        }
        let mut wearers: Vec<Option<String>> = Vec::new();
        let worn = |setup: &Setup| {
            if setup.memory.is_some() {
                return None;
            }
            let name = setup
                .wearer
                .as_ref()
                .map(|wearer| wearer.value.name.clone());
            let known = wearers.iter().position(|other| *other == name);
            Some(known.unwrap_or_else(|| {
                wearers.push(name);
                wearers.len() - 1
            }))
        };
        let whose: Vec<Option<usize>> = fingertips.iter().map(worn).collect();
        let names: Vec<&str> = wearers.iter().flatten().map(String::as_str).collect();
        let accounts: Vec<String> = wearers
            .iter()
            .map(|name| of_wearer(name.as_deref()))
            .collect();
        let hardware = match UnitPlace::find(bench)? {
            Some(place) => HungOn::Unit(of_unit(&place)),
            None => HungOn::Adapters(of_adapters(bench)?),
        };
        let way_out = way_out(bench, &names);
        Self::read(hardware, &accounts, (fingertips, &whose[..]), way_out)
    }

    /// Reads the accounts of a bench with one display. Returns the setup that its guard goes on from.
    ///
    /// # Errors
    /// [`Failure::Guard`] where heat or dose cannot be read, or the dose is spent, with the command that mends it.
    pub fn alone(setup: &Setup) -> Result<(Setup, Self), Failure> {
        let mut alone = [setup.clone()];
        let heat = Self::open(&setup.bench, &mut alone)?;
        let [setup] = alone;
        Ok((setup, heat))
    }

    /// Reads the accounts of boards that are a unit's here.
    ///
    /// # Errors
    /// [`Failure::Guard`] where heat or dose cannot be read, or the dose is spent, with the command that mends it.
    pub fn of_boards(setup: &mut Setup) -> Result<Self, Failure> {
        let (adapters, way_out) = (of_adapters(&setup.bench)?, way_out(&setup.bench, &[]));
        let accounts: Vec<String> = adapters.iter().map(|name| of_boards(name)).collect();
        let fingertip = std::slice::from_mut(setup);
        let hardware = HungOn::Adapters(adapters);
        let whose = [Some(0)];
        Self::read(hardware, &accounts, (fingertip, &whose[..]), way_out)
    }

    fn read(
        hardware: HungOn,
        wearers: &[String],
        (fingertips, whose): (&mut [Setup], &[Option<usize>]),
        way_out: String,
    ) -> Result<Self, Failure> {
        let (names, is_unit) = match hardware {
            HungOn::Adapters(names) => (names, false),
            HungOn::Unit(name) => (vec![name], true),
        };
        let places = fingertips.iter().zip(whose).map(|(setup, wearer)| {
            let outputs = setup.bench.value.outputs.iter();
            let wires = outputs.map(|own| {
                // A unit has buses of its own, an adapter is one.
                let (hardware, bus) = match is_unit {
                    true => (0, own.bus),
                    false => (usize::from(own.bus), 0),
                };
                let output = Output {
                    bus,
                    board: own.board,
                    channel: own.channel,
                };
                (hardware, output)
            });
            Fingertip {
                wires: wires.collect(),
                wearer: *wearer,
            }
        });
        let opened = Ledger::open(&ledger::folder(), (&names[..], wearers), places.collect());
        let ledger = opened.map_err(|error| {
            Failure::Guard(format!(
                "heat of earlier runs: {error}; tissue counts as at each limit, and the dose as spent. {way_out}"
            ))
        })?;
        for (number, setup) in fingertips.iter_mut().enumerate() {
            let mut memory = ledger.memory(number);
            match &setup.memory {
                Some(own) => with_doses_of(&mut memory, own),
                None => refuse_spent(memory.doses(), setup, &way_out)?,
            }
            setup.memory = Some(memory);
        }
        Ok(Self {
            ledger: Mutex::new(Some(ledger)),
            keeper: OnceLock::new(),
            way_out,
        })
    }

    /// The hardware is the run's own: the accounts are held, and a first reserve is on the disk when this returns. These are the
    /// guards of all fingertips.
    ///
    /// # Errors
    /// [`Failure::Device`] where nothing can be kept, [`Failure::Guard`] where it can no longer be read: nothing may be driven.
    pub(crate) fn begin(&self, states: &[(Instant, &Guard)]) -> Result<(), Failure> {
        let ledger = held(&self.ledger).take();
        let Some(ledger) = ledger else {
            return Ok(());
        };
        let keeper = ledger.keep(states).map_err(|error| match error {
            LedgerError::Unreadable { .. } => Failure::Guard(format!("{error}. {}", self.way_out)),
            _ => Failure::Device(error.to_string()),
        })?;
        // There is none before.
        let _ = self.keeper.set(keeper);
        Ok(())
    }

    /// Shows the guard before a turn of a fingertip's loop.
    ///
    /// # Errors
    /// [`Failure::Device`] where nothing is reserved for it: outputs are to go off.
    pub(crate) fn beat(
        &self,
        fingertip: usize,
        now: Instant,
        guard: &Guard,
    ) -> Result<(), Failure> {
        let beat = self.keeper.get().map(|own| own.beat(fingertip, now, guard));
        failure(beat)
    }

    /// Takes the guard of a fingertip's loop that ends before the others'.
    pub(super) fn leave(&self, fingertip: usize, now: Instant, guard: &Guard) {
        if let Some(keeper) = self.keeper.get() {
            keeper.leave(fingertip, now, guard);
        }
    }

    /// Books true heat and dose at the end, where everything is known to be `off`.
    ///
    /// # Errors
    /// [`Failure::Device`] where they could not be booked: reserves stay booked.
    pub(crate) fn end(&self, states: &[(Instant, &Guard)], off: bool) -> Result<(), Failure> {
        failure(self.keeper.get().map(|own| own.end(states, off)))
    }
}

fn failure(kept: Option<Result<(), LedgerError>>) -> Result<(), Failure> {
    let kept = kept.unwrap_or(Ok(()));
    kept.map_err(|error| Failure::Device(error.to_string()))
}

/// The dose of each wire as another memory has it; none of wires that it does not know.
fn with_doses_of(memory: &mut Memory, other: &Memory) {
    let mut known = other.wires.iter().map(|wire| wire.doses);
    for wire in &mut memory.wires {
        wire.doses = known.next().unwrap_or_default();
    }
}

/// Refuses a wearer who has had a session's dose.
fn refuse_spent(doses: Doses, setup: &Setup, way_out: &str) -> Result<(), Failure> {
    let limits = &setup.limits.value.limits;
    let omega = limits.dose_omega_ppm as f64 * 1e-6;
    let cem43_min = limits.dose_cem43_ms as f64 / 60_000.0;
    if doses.omega < omega && doses.cem43_min < cem43_min {
        return Ok(());
    }
    let wearer = setup.wearer.as_ref();
    let wearer = wearer.map_or_else(
        || "the wearer".to_owned(),
        |wearer| format!("wearer `{}`", wearer.value.name),
    );
    Err(Failure::Guard(format!(
        "{wearer} has had a session's dose: Omega {:.4} of {omega}, CEM43 {:.2} of {cem43_min} min. {way_out}",
        doses.omega, doses.cem43_min
    )))
}
