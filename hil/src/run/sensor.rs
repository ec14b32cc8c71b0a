//! The sensor end of a run: a bus whose virtual time the run moves, and a tap that keeps what crosses it.

use palpate_core::bus::{Received, SensorBus};
use palpate_core::units::Instant;
use palpate_core::wire::can::CanFrame;
use palpate_emulators::can::faults::Faulty;
use palpate_emulators::rig::Handle;
use palpate_emulators::time::Nanos;

use super::Keep;
use super::boards::{self, BusReport};
use super::replay::Replay;
use crate::record::Tap;

/// A sensor end whose virtual time the run moves.
pub trait Skin: SensorBus {
    /// Lets time pass until `now`.
    fn advance_to(&mut self, now: Instant);

    /// The emulated skin behind its fault layer.
    fn emulated(&mut self) -> Option<&mut Faulty<Handle>> {
        None
    }

    /// Its buses, where they are emulated.
    fn buses(&self) -> Vec<BusReport> {
        Vec::new()
    }
}

impl Skin for Faulty<Handle> {
    fn advance_to(&mut self, now: Instant) {
        self.inner_mut().advance(Nanos::from(now));
    }

    fn emulated(&mut self) -> Option<&mut Faulty<Handle>> {
        Some(self)
    }

    fn buses(&self) -> Vec<BusReport> {
        self.inner().with(|buses| boards::buses(buses))
    }
}

impl Skin for Replay {
    fn advance_to(&mut self, now: Instant) {
        self.advance(now);
    }
}

/// A [`Tap`] on a sensor end, with what the run is to keep beside its frames.
pub struct Tapped<S> {
    tap: Tap<S>,
    keep: Keep,
}

impl<S> Tapped<S> {
    /// A tap on `inner`; one that keeps no frames costs nothing.
    pub fn new(inner: S, keep: Keep) -> Self {
        Self {
            tap: Tap::new(inner, keep.can),
            keep,
        }
    }

    /// What the run is to keep.
    pub const fn keeps(&self) -> Keep {
        self.keep
    }

    /// What crossed the bus since the last time.
    pub fn take(&mut self) -> Vec<Received> {
        self.tap.take()
    }

    /// The bus behind the tap.
    pub const fn inner(&self) -> &S {
        &self.tap.inner
    }
}

impl<S: Skin> Skin for Tapped<S> {
    fn advance_to(&mut self, now: Instant) {
        self.tap.now = self.tap.now.max(now);
        self.tap.inner.advance_to(now);
    }

    fn emulated(&mut self) -> Option<&mut Faulty<Handle>> {
        self.tap.inner.emulated()
    }

    fn buses(&self) -> Vec<BusReport> {
        self.tap.inner.buses()
    }
}

impl<S: SensorBus> SensorBus for Tapped<S> {
    type Error = S::Error;

    fn receive(&mut self) -> Result<Option<Received>, S::Error> {
        self.tap.receive()
    }

    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), S::Error> {
        self.tap.transmit(bus, frame)
    }
}
