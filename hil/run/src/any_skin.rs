//! A sensor end of any kind behind one type.
//!
//! Whole runs have six kinds of skin. Through this type the code of a run is compiled once; a turn goes through it twice.

use core::fmt;

use palpate_core::bus::Received;
use palpate_core::skin::{ModuleScan, SkinSource};
use palpate_core::units::Instant;

use crate::boards::BusReport;
use crate::failure::Failure;
use crate::skin_end::{FaultySkin, SkinEnd};

/// What [`SkinEnd`] and its source do, without a type of their own in it.
trait Erased {
    fn scans(&mut self, now: Instant, take: &mut dyn FnMut(&ModuleScan<'_>))
    -> Result<(), Failure>;
    fn advance_to(&mut self, now: Instant);
    fn start(&mut self, module: usize);
    fn lost_of(&self, module: usize) -> u64;
    fn take_frames(&mut self) -> Vec<Received>;
    fn emulated(&mut self) -> FaultySkin<'_>;
    fn buses(&self) -> Vec<BusReport>;
}

impl<S: SkinEnd> Erased for S {
    fn scans(
        &mut self,
        now: Instant,
        mut take: &mut dyn FnMut(&ModuleScan<'_>),
    ) -> Result<(), Failure> {
        SkinSource::scans(self, now, &mut take).map_err(|e| Failure::Device(e.to_string()))
    }

    fn advance_to(&mut self, now: Instant) {
        SkinEnd::advance_to(self, now);
    }

    fn start(&mut self, module: usize) {
        SkinEnd::start(self, module);
    }

    fn lost_of(&self, module: usize) -> u64 {
        SkinEnd::lost_of(self, module)
    }

    fn take_frames(&mut self) -> Vec<Received> {
        SkinEnd::take_frames(self)
    }

    fn emulated(&mut self) -> FaultySkin<'_> {
        SkinEnd::emulated(self)
    }

    fn buses(&self) -> Vec<BusReport> {
        SkinEnd::buses(self)
    }
}

/// A skin of any kind, borrowed for a run.
pub(crate) struct AnySkin<'s>(&'s mut dyn Erased);

impl<'s> AnySkin<'s> {
    /// This skin.
    pub(crate) fn of(skin: &'s mut impl SkinEnd) -> Self {
        Self(skin)
    }
}

impl fmt::Debug for AnySkin<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("AnySkin")
    }
}

impl SkinSource for AnySkin<'_> {
    type Error = Failure;

    fn scans(
        &mut self,
        now: Instant,
        take: &mut impl FnMut(&ModuleScan<'_>),
    ) -> Result<(), Failure> {
        self.0.scans(now, take)
    }
}

impl SkinEnd for AnySkin<'_> {
    fn advance_to(&mut self, now: Instant) {
        self.0.advance_to(now);
    }

    fn start(&mut self, module: usize) {
        self.0.start(module);
    }

    fn lost_of(&self, module: usize) -> u64 {
        self.0.lost_of(module)
    }

    fn take_frames(&mut self) -> Vec<Received> {
        self.0.take_frames()
    }

    fn emulated(&mut self) -> FaultySkin<'_> {
        self.0.emulated()
    }

    fn buses(&self) -> Vec<BusReport> {
        self.0.buses()
    }
}
