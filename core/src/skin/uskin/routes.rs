//! Who sends under which identifier: a table made once, so that a frame off the bus costs one look.

use alloc::boxed::Box;
use alloc::vec::Vec;

use crate::codec::uskin::{Wiring, sender};
use crate::skin::layout::Address;

/// The taxel that an identifier is about.
#[derive(Clone, Copy, Debug)]
pub(super) struct Route {
    pub(super) module: u16,
    pub(super) taxel: u16,
    pub(super) order: u16,
}

/// What every identifier means on every bus, worked out beforehand.
#[derive(Debug)]
pub(super) struct Routes(Vec<Box<[Option<Route>]>>);

/// Identifiers of a bus: 11 bits.
const IDENTIFIERS: u16 = 1 << 11;

impl Routes {
    /// For modules by index, address and wiring. Of several under one board's number the first counts.
    pub(super) fn new(modules: &[(u16, Address, Wiring)]) -> Self {
        let buses = modules.iter().map(|(_, address, _)| address.bus).max();
        let of_bus = |bus: u8| {
            let modules = || modules.iter().filter(move |m| m.1.bus == bus);
            let route = |id: u16| {
                let (board, place) = sender(id);
                let (module, _, wiring) = *modules().find(|m| board == m.1.board)?;
                Some(Route {
                    module,
                    taxel: wiring.taxel(place)?.1 as u16, // a board has at most 64 taxels a module
                    order: wiring.order(place)? as u16,
                })
            };
            (0..IDENTIFIERS).map(route).collect()
        };
        Self(buses.map_or_else(Vec::new, |last| (0..=last).map(of_bus).collect()))
    }

    pub(super) fn find(&self, bus: u8, id: u16) -> Option<Route> {
        *self.0.get(usize::from(bus))?.get(usize::from(id))?
    }
}

#[cfg(test)]
#[path = "routes_tests.rs"]
mod tests;
