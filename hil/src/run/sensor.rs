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

/// A sensor end of which every frame is kept, in either direction, as the host saw it: what a fault layer
/// swallowed is not there, what it garbled is garbled.
pub struct Tapped<S> {
    inner: S,
    now: Instant,
    keep: Keep,
    kept: Option<Vec<Received>>,
}

impl<S> Tapped<S> {
    /// A tap on `inner`; one that keeps no frames costs nothing.
    pub fn new(inner: S, keep: Keep) -> Self {
        Self {
            inner,
            now: Instant::ZERO,
            keep,
            kept: keep.can.then(Vec::new),
        }
    }

    /// What the run is to keep.
    pub const fn keeps(&self) -> Keep {
        self.keep
    }

    /// What crossed the bus.
    pub fn take(&mut self) -> Vec<Received> {
        self.kept.take().unwrap_or_default()
    }

    /// The bus behind the tap.
    pub const fn inner(&self) -> &S {
        &self.inner
    }
}

impl<S: Skin> Skin for Tapped<S> {
    fn advance_to(&mut self, now: Instant) {
        self.now = self.now.max(now);
        self.inner.advance_to(now);
    }

    fn emulated(&mut self) -> Option<&mut Faulty<Handle>> {
        self.inner.emulated()
    }

    fn buses(&self) -> Vec<BusReport> {
        self.inner.buses()
    }
}

impl<S: SensorBus> SensorBus for Tapped<S> {
    type Error = S::Error;

    fn receive(&mut self) -> Result<Option<Received>, S::Error> {
        let received = self.inner.receive()?;
        if let Some(kept) = &mut self.kept {
            kept.extend(received);
        }
        Ok(received)
    }

    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), S::Error> {
        self.inner.transmit(bus, frame)?;
        if let Some(kept) = &mut self.kept {
            kept.push(Received {
                at: self.now,
                bus,
                frame: *frame,
            });
        }
        Ok(())
    }
}
