//! Boards that a unit's process drives: emulated ones, or those of a Linux I2C adapter under a guardian.

use std::cell::RefCell;
use std::rc::Rc;

use embedded_hal::digital::{ErrorKind, ErrorType, OutputPin};
use palpate_buses::guardian::Guardian;
use palpate_buses::i2c::{Line, LinuxAdapter};
use palpate_core::peltier::Regulator;
use palpate_core::physics::{PeltierParameters, Thermistor};
use palpate_core::units::Instant;
use palpate_emulators::display::i2c::I2cHandle;
use palpate_emulators::display::peltier::{Peltier, PeltierHandle};
use palpate_emulators::time::Nanos;
use palpate_emulators::unit::OeLine;
use palpate_files::{Bench, BenchHeat, Real, Setup};
use palpate_run::Failure;

use super::record::Told;
use crate::emulate::{Flowed, ServedDisplay};
use crate::real::{Heat, lost, refuse_latched, unguarded, watch};
use crate::telling::Teller;

/// Boards behind a unit's bus.
pub(super) trait Boards {
    /// Lets time pass before a turn, `since_ns` after the start; the owner of the bus is alive.
    fn advance(&mut self, since_ns: u64, teller: &mut Teller) -> Result<(), Failure>;

    /// Accounts of heat; `None` for emulated boards.
    fn ledger(&self) -> Option<&Heat> {
        None
    }

    /// Tells whether a guardian switches off outputs that this program leaves on.
    fn is_guarded(&self) -> bool {
        true
    }

    /// Ends the work. `off` tells whether every board took its all-off. Returns whether everything is off.
    fn finish(&mut self, off: bool) -> Result<bool, String>;

    /// Currents of the wires, where they are known.
    fn flowed(&mut self) -> Option<Flowed> {
        None
    }
}

/// Emulated boards and wires.
pub(super) struct Emulated {
    display: ServedDisplay,
    /// The Peltier module under the fingertip, where the bench has one.
    module: Option<PeltierHandle>,
    /// Parameters of that module.
    parameters: PeltierParameters,
    /// CLOCK_MONOTONIC at the emulators' zero.
    epoch_ns: u64,
}

impl Emulated {
    pub(super) fn new(setup: &Setup, epoch_ns: u64) -> Result<Self, Failure> {
        let display = ServedDisplay::new(setup)?;
        let heat = setup.bench.value.heat;
        let module = |h: BenchHeat| Peltier::new(h.parameters(), Thermistor::default(), h.air_c);
        Ok(Self {
            display,
            module: heat.map(module).map(PeltierHandle::new),
            parameters: heat.map_or_else(PeltierParameters::default, |h| h.parameters()),
            epoch_ns,
        })
    }

    /// The module, and the regulator that the unit uses for it.
    pub(super) fn module(&self) -> Option<(PeltierHandle, Regulator)> {
        let regulator = Regulator::new(self.parameters, Thermistor::default());
        self.module.clone().map(|module| (module, regulator))
    }

    /// Lines that the unit holds: the bus, and the one to the OE pins.
    pub(super) fn lines(&self) -> (I2cHandle, OeLine) {
        let bus = self.display.worn.bus();
        (bus.clone(), OeLine(bus))
    }
}

impl Boards for Emulated {
    fn advance(&mut self, since_ns: u64, teller: &mut Teller) -> Result<(), Failure> {
        if let Some(module) = &self.module {
            let face_c = module.with(|module| {
                module.advance(Nanos(since_ns));
                module.state().face_c
            });
            self.display.worn.warm(face_c);
        }
        let tell = |edge| teller.tell(&Told::Edge(edge));
        self.display.advance(Nanos(since_ns), self.epoch_ns, tell)
    }

    fn finish(&mut self, off: bool) -> Result<bool, String> {
        let driving = self.display.driving();
        // Chips that cannot be looked at are not known to be off.
        Ok(off && !driving.is_empty() && driving.iter().all(|(_, drives)| !drives))
    }

    fn flowed(&mut self) -> Option<Flowed> {
        Some(self.display.flowed())
    }
}

/// Boards of a Linux I2C adapter. A process can hang as a microcontroller can: in place of a hardware watchdog a guardian
/// switches everything off.
pub(super) struct Guarded {
    guardian: Rc<RefCell<Guardian>>,
    heat: Heat,
    line: Option<Line>,
    has_oe: bool,
}

/// The OE pins behind the guardian, so that it can cut them when the unit is gone, and whether they are wired.
pub(super) struct OePin(Rc<RefCell<Guardian>>, bool);

impl ErrorType for OePin {
    type Error = ErrorKind;
}

impl OutputPin for OePin {
    fn set_low(&mut self) -> Result<(), ErrorKind> {
        // A guardian that is gone ends the unit at the next heartbeat.
        let _ = self.0.borrow().set_outputs(true);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), ErrorKind> {
        let _ = self.0.borrow().set_outputs(false);
        self.1.then_some(()).ok_or(ErrorKind::Other)
    }
}

impl Guarded {
    /// Opens the adapter; the guardian has switched everything off when this returns. Returns the boards that it found
    /// driving, too.
    pub(super) fn open(bench: &Bench, real: &Real, heat: Heat) -> Result<(Self, String), Failure> {
        let device = |e: &dyn std::fmt::Display| Failure::Device(e.to_string());
        let watch = watch(bench, real);
        let [bus] = &*watch.buses else {
            return Err(Failure::Input(format!(
                "bench `{}`: expected the boards of a unit on one I2C adapter, found {} adapters: start a unit for each",
                bench.name,
                watch.buses.len()
            )));
        };
        refuse_latched(&watch)?;
        let adapter = LinuxAdapter::open(&bus.path, &bus.addresses()).map_err(|e| device(&e))?;
        let mut line = Line::new(adapter, watch.transfer).map_err(|e| device(&e))?;
        let program = crate::again::again().map_err(|e| device(&e))?;
        let (guardian, found) = Guardian::start(program, &watch).map_err(|e| unguarded(&e))?;
        line.set_pulse(guardian.pulse());
        let opened = Self {
            guardian: Rc::new(RefCell::new(guardian)),
            heat,
            line: Some(line),
            has_oe: real.oe.is_some(),
        };
        Ok((opened, found))
    }

    /// Takes the lines that the unit holds, once.
    pub(super) fn lines(&mut self) -> Option<(Line, OePin)> {
        let pin = OePin(Rc::clone(&self.guardian), self.has_oe);
        Some((self.line.take()?, pin))
    }
}

impl Boards for Guarded {
    fn advance(&mut self, since_ns: u64, _teller: &mut Teller) -> Result<(), Failure> {
        let now = Instant::from_micros(since_ns / 1000);
        self.guardian.borrow_mut().beat(now).map_err(lost)
    }

    fn ledger(&self) -> Option<&Heat> {
        Some(&self.heat)
    }

    fn is_guarded(&self) -> bool {
        !self.guardian.borrow().is_gone()
    }

    fn finish(&mut self, off: bool) -> Result<bool, String> {
        let mut guardian = self.guardian.borrow_mut();
        match off {
            true => guardian.end().map(|()| true),
            false => Ok(guardian.hand_over("the unit could not switch every board off")),
        }
    }
}
