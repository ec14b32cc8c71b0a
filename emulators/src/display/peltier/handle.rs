//! A module that two hold: the bench, which lets time pass and looks at it, and the driver unit that regulates it.

use core::convert::Infallible;
use std::sync::{Arc, Mutex, PoisonError};

use palpate_core::driver::Actuators;
use palpate_core::peltier::{GuardedCurrent, Reading};
use palpate_core::units::Instant;
use palpate_unit::Module;

use super::{Peltier, instant};

/// A module of both.
#[derive(Clone, Debug)]
pub struct PeltierHandle(Arc<Mutex<Peltier>>);

impl PeltierHandle {
    /// Takes the module in.
    pub fn new(module: Peltier) -> Self {
        Self(Arc::new(Mutex::new(module)))
    }

    /// Gives access to it, not from within another such call.
    pub fn with<R>(&self, work: impl FnOnce(&mut Peltier) -> R) -> R {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Actuators<GuardedCurrent> for PeltierHandle {
    type Error = Infallible;

    fn apply(&mut self, update: &GuardedCurrent) -> Result<(), Infallible> {
        self.with(|module| module.apply(update))
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        self.with(Peltier::all_off)
    }
}

impl Module for PeltierHandle {
    /// The newest reading, as old by the unit's clock as it is by the module's.
    fn reading(&mut self, now: Instant) -> Reading {
        self.with(|module| {
            let reading = module.reading();
            let age = instant(module.now).since(reading.at).as_micros();
            Reading {
                at: Instant::from_micros(now.as_micros().saturating_sub(age)),
                ..reading
            }
        })
    }
}
