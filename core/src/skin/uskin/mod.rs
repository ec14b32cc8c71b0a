//! Modules behind boards on CAN as a [`SkinSource`]: frames in, scans out; boards are started and stopped here.
//!
//! Most are uSkin modules. A layout may state that its boards are the iCub's MTB boards ([`Protocol::Mtb`]).
//!
//! Routes are precomputed: a frame off the bus costs one look-up.

mod assembler;
mod routes;

use alloc::boxed::Box;

use super::layout::{Address, Layout, Module, Protocol};
use super::source::{SkinSource, TakeScan};
use crate::bus::{CanBus, Received};
use crate::codec::mtb;
use crate::codec::uskin::{Command, Raw, Reading};
use crate::units::{Duration, Instant};

use assembler::{ScanAssembler, TaxelReading};
use routes::{Route, Routes};

/// The silence that ends a scan, unless stated otherwise.
pub const SCAN_GAP: Duration = Duration::from_millis(4);

/// The modules of a layout that boards on a CAN bus read.
#[derive(Debug)]
pub struct CanSkin<B> {
    bus: B,
    sorting: Sorting,
    /// The board of each module that waits for commands.
    addresses: Box<[Option<Address>]>,
}

/// Destination of each frame: a route, an assembler, or the count of foreign ones.
#[derive(Debug)]
struct Sorting {
    routes: Routes,
    assembler: ScanAssembler,
    foreign: u64,
}

impl<B: CanBus> CanSkin<B> {
    /// The modules of a layout that have an address and can be wired to a board, on this bus.
    pub fn new(layout: &Layout, bus: B) -> Self {
        let obeys = |m: &Module| m.address().filter(|_| m.protocol() == Protocol::Uskin);
        Self {
            bus,
            sorting: Sorting {
                routes: Routes::new(layout),
                assembler: ScanAssembler::new(layout, SCAN_GAP),
                foreign: 0,
            },
            addresses: layout.modules().iter().map(obeys).collect(),
        }
    }

    /// Sets another silence that ends a scan: longer than between two frames of one, shorter than between two scans.
    #[must_use]
    pub const fn with_gap(mut self, gap: Duration) -> Self {
        self.sorting.assembler.set_gap(gap);
        self
    }

    /// The bus.
    pub const fn bus(&self) -> &B {
        &self.bus
    }

    /// The bus, mutable, to look at its other frames.
    pub const fn bus_mut(&mut self) -> &mut B {
        &mut self.bus
    }

    /// Tells a module's board to send. A module without a board, or that does not exist, is told nothing.
    ///
    /// # Errors
    /// The bus's own error: a full queue, a controller that is bus-off.
    pub fn start(&mut self, module: usize) -> Result<(), B::Error> {
        let Some(Address { bus, board }) = self.addresses.get(module).copied().flatten() else {
            return Ok(());
        };
        // A layout has no board over 15, so there is always a frame.
        match (Command { board, start: true }).encode() {
            Some(frame) => self.bus.transmit(bus, &frame),
            None => Ok(()),
        }
    }

    /// Tells every board to send, also those behind one that could not be reached.
    ///
    /// # Errors
    /// The bus's first error.
    pub fn start_all(&mut self) -> Result<(), B::Error> {
        let mut told = Ok(());
        for module in 0..self.addresses.len() {
            let this = self.start(module);
            told = told.and(this);
        }
        told
    }

    /// Number of frames that were no readings of this layout.
    pub const fn foreign(&self) -> u64 {
        self.sorting.foreign
    }

    /// Readings missing from the scans so far; a scan of which nothing came stays unknown.
    pub const fn lost(&self) -> u64 {
        self.sorting.assembler.lost()
    }

    /// Readings missing from one module's scans so far.
    pub fn lost_of(&self, module: usize) -> u64 {
        self.sorting.assembler.lost_of(module)
    }
}

impl Sorting {
    /// Takes one frame off the bus; `None` for a frame that is no reading of this layout.
    #[inline]
    fn take(&mut self, received: &Received, done: &mut TakeScan<'_>) -> Option<()> {
        let (bus, id) = (received.bus, received.frame.id());
        match self.routes.find(bus, id)? {
            Route::Taxel {
                module,
                taxel,
                order,
            } => {
                // Commands are shorter than data; nothing else tells them apart.
                let Reading { x, y, z } = Raw::new(received.frame.data())?.reading();
                let reading = TaxelReading {
                    module,
                    taxel,
                    order,
                    counts: [x, y, z],
                    at: received.at,
                };
                self.assembler.push(&reading, done)
            }
            Route::Triangle {
                module,
                first,
                read,
            } => {
                let message = mtb::Message::decode(&received.frame)?;
                let (from, counts) = message.half.taxels();
                for (place, count) in (from..).zip(counts) {
                    if read >> place & 1 == 0 {
                        continue;
                    }
                    let taxel = first + place;
                    let reading = TaxelReading {
                        module,
                        taxel,
                        order: taxel,
                        counts: [0, 0, u16::from(*count)],
                        at: received.at,
                    };
                    self.assembler.push(&reading, &mut *done)?;
                }
                Some(())
            }
        }
    }
}

impl<B: CanBus> SkinSource for CanSkin<B> {
    type Error = B::Error;

    fn scans(&mut self, now: Instant, take: &mut TakeScan<'_>) -> Result<(), B::Error> {
        let Self { bus, sorting, .. } = self;
        bus.receive_all(&mut |received| {
            if sorting.take(received, take).is_none() {
                sorting.foreign = sorting.foreign.saturating_add(1);
            }
        })?;
        sorting.assembler.flush(now, take);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
