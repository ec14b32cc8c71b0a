//! The sensor end of a run: a skin whose virtual time the session moves, and facts about its boards.

use core::fmt;

use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::skin::{CanSkin, SkinSource, TakeScan};
use palpate_core::units::Instant;
use palpate_emulators::sensor::SkinArray;
use palpate_emulators::sensor::can::faults::Faulty;
use palpate_emulators::sensor::rig::Handle;
use palpate_emulators::time::Nanos;

use crate::boards::{self, BusReport};
use crate::failure::Failure;

/// A skin behind its fault layer, where there is one to disturb.
pub type FaultySkin<'a> = Option<&'a mut Faulty<Handle>>;

/// The sensor end of a session. Boards on a bus have what is empty by default; other skins lack it.
pub trait SkinEnd {
    /// Hands every scan that was complete by `now` to `take`, the oldest first. Never waits.
    ///
    /// # Errors
    /// The sensor's own; scans that were handed on before it count.
    fn scans(&mut self, now: Instant, take: &mut TakeScan<'_>) -> Result<(), Failure>;

    /// Lets time pass until `now`.
    fn advance_to(&mut self, now: Instant);

    /// Tells whether boards that go silent can be told to send.
    fn has_boards(&self) -> bool {
        true
    }

    /// Tells a module's board to send.
    fn start(&mut self, module: usize) {
        let _ = module;
    }

    /// Readings missing from a module's scans so far.
    fn lost_of(&self, module: usize) -> u64 {
        let _ = module;
        0
    }

    /// Frames that were no readings of its layout.
    fn foreign(&self) -> u64 {
        0
    }

    /// Frames that crossed its buses since the last time, if they are kept.
    fn take_frames(&mut self) -> Vec<Received> {
        Vec::new()
    }

    /// The emulated skin behind its fault layer.
    fn emulated(&mut self) -> FaultySkin<'_> {
        None
    }

    /// Reports of the skin's buses, where they are emulated.
    fn buses(&self) -> Vec<BusReport> {
        Vec::new()
    }
}

/// Any end behind one type: the loop is compiled for it once.
impl SkinSource for dyn SkinEnd + '_ {
    type Error = Failure;

    fn scans(&mut self, now: Instant, take: &mut TakeScan<'_>) -> Result<(), Failure> {
        SkinEnd::scans(self, now, take)
    }
}

/// Makes an end of a pointer to one.
macro_rules! pointed_at {
    ($($pointer:ty),*) => {$(
        impl<S: SkinEnd + ?Sized> SkinEnd for $pointer {
            fn scans(&mut self, now: Instant, take: &mut TakeScan<'_>) -> Result<(), Failure> {
                (**self).scans(now, take)
            }

            fn advance_to(&mut self, now: Instant) {
                (**self).advance_to(now);
            }

            fn has_boards(&self) -> bool {
                (**self).has_boards()
            }

            fn start(&mut self, module: usize) {
                (**self).start(module);
            }

            fn lost_of(&self, module: usize) -> u64 {
                (**self).lost_of(module)
            }

            fn foreign(&self) -> u64 {
                (**self).foreign()
            }

            fn take_frames(&mut self) -> Vec<Received> {
                (**self).take_frames()
            }

            fn emulated(&mut self) -> FaultySkin<'_> {
                (**self).emulated()
            }

            fn buses(&self) -> Vec<BusReport> {
                (**self).buses()
            }
        }
    )*};
}

pointed_at!(&mut S, Box<S>);

/// A skin that no bus carries.
impl SkinEnd for SkinArray {
    fn scans(&mut self, now: Instant, take: &mut TakeScan<'_>) -> Result<(), Failure> {
        SkinSource::scans(self, now, take).map_err(|never| match never {})
    }

    fn advance_to(&mut self, now: Instant) {
        self.advance(now.into());
    }
}

/// A skin whose readings are pushed.
impl SkinEnd for () {
    fn scans(&mut self, _now: Instant, _take: &mut TakeScan<'_>) -> Result<(), Failure> {
        Ok(())
    }

    fn advance_to(&mut self, _now: Instant) {}
}

/// A skin on another machine, which hands on contacts and no readings.
#[derive(Clone, Copy, Debug, Default)]
pub struct Elsewhere;

impl SkinEnd for Elsewhere {
    fn scans(&mut self, _now: Instant, _take: &mut TakeScan<'_>) -> Result<(), Failure> {
        Ok(())
    }

    fn advance_to(&mut self, _now: Instant) {}

    fn has_boards(&self) -> bool {
        false
    }
}

/// A CAN bus whose virtual time the session moves.
pub trait CanEnd: CanBus<Error: fmt::Display> {
    /// Lets time pass until `now`.
    fn advance_to(&mut self, now: Instant);

    /// The emulated skin behind its fault layer.
    fn emulated(&mut self) -> FaultySkin<'_> {
        None
    }

    /// The buses, where they are emulated.
    fn buses(&self) -> Vec<BusReport> {
        Vec::new()
    }
}

impl CanEnd for Faulty<Handle> {
    fn advance_to(&mut self, now: Instant) {
        self.inner_mut().advance(Nanos::from(now));
    }

    fn emulated(&mut self) -> FaultySkin<'_> {
        Some(self)
    }

    fn buses(&self) -> Vec<BusReport> {
        self.inner().with(|buses| boards::buses(buses))
    }
}

/// uSkin boards on a bus.
impl<B: CanEnd> SkinEnd for CanSkin<Tap<B>> {
    fn scans(&mut self, now: Instant, take: &mut TakeScan<'_>) -> Result<(), Failure> {
        SkinSource::scans(self, now, take).map_err(|e| Failure::Device(e.to_string()))
    }

    fn advance_to(&mut self, now: Instant) {
        let tap = self.bus_mut();
        tap.now = tap.now.max(now);
        tap.inner.advance_to(now);
    }

    fn start(&mut self, module: usize) {
        // A full queue or a host that is bus-off: a board that stays silent is told again.
        let _ = CanSkin::start(self, module);
    }

    fn lost_of(&self, module: usize) -> u64 {
        CanSkin::lost_of(self, module)
    }

    fn foreign(&self) -> u64 {
        CanSkin::foreign(self)
    }

    fn take_frames(&mut self) -> Vec<Received> {
        self.bus_mut().take()
    }

    fn emulated(&mut self) -> FaultySkin<'_> {
        self.bus_mut().inner.emulated()
    }

    fn buses(&self) -> Vec<BusReport> {
        self.bus().inner.buses()
    }
}

/// A bus that keeps the frames that cross it, in either direction, until they are taken: as the host saw them, so
/// without those that a fault layer swallowed, and garbled where it garbled them.
#[derive(Debug)]
pub struct Tap<B> {
    /// The bus.
    pub inner: B,
    /// Time that sent frames get.
    now: Instant,
    kept: Option<Vec<Received>>,
}

impl<B> Tap<B> {
    /// A tap on a bus; one that does not `keep` costs nothing.
    pub fn new(inner: B, keep: bool) -> Self {
        Self {
            inner,
            now: Instant::ZERO,
            kept: keep.then(Vec::new),
        }
    }

    /// Takes the frames that crossed the bus since the last time.
    pub fn take(&mut self) -> Vec<Received> {
        self.kept.as_mut().map(std::mem::take).unwrap_or_default()
    }
}

impl<B: CanBus> CanBus for Tap<B> {
    type Error = B::Error;

    fn receive(&mut self) -> Result<Option<Received>, B::Error> {
        let received = self.inner.receive()?;
        if let Some(kept) = &mut self.kept {
            kept.extend(received);
        }
        Ok(received)
    }

    fn receive_all(&mut self, take: &mut impl FnMut(&Received)) -> Result<(), B::Error> {
        match &mut self.kept {
            None => self.inner.receive_all(take),
            Some(kept) => self.inner.receive_all(&mut |received| {
                kept.push(*received);
                take(received);
            }),
        }
    }

    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), B::Error> {
        self.inner.transmit(bus, frame)?;
        if let Some(kept) = &mut self.kept {
            let (at, frame) = (self.now, *frame);
            kept.push(Received { at, bus, frame });
        }
        Ok(())
    }
}
