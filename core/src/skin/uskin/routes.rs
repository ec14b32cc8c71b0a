//! Routes of all identifiers: precomputed once, so that a frame off the bus costs one look-up.

use alloc::boxed::Box;
use alloc::vec::Vec;

use crate::codec::mtb;
use crate::codec::uskin::sender;
use crate::skin::layout::{Address, Layout, Module, Protocol};

/// Meaning of an identifier.
#[derive(Clone, Copy, Debug)]
pub(super) enum Route {
    /// One taxel of a uSkin module.
    Taxel {
        /// Module, zero-based.
        module: u16,
        /// Taxel within the module.
        taxel: u16,
        /// Place in the module's order on the bus.
        order: u16,
    },
    /// A triangle of an MTB board.
    Triangle {
        /// Module, zero-based.
        module: u16,
        /// First taxel of the triangle within the module.
        first: u16,
        /// Taxels that are read, a bit each: two of the triangle's twelve places may be thermal pads.
        read: u16,
    },
}

/// Precomputed meaning of every identifier on every bus.
#[derive(Debug)]
pub(super) struct Routes(Vec<Box<[Option<Route>]>>);

/// Identifiers of a bus: 11 bits.
const IDENTIFIERS: u16 = 1 << 11;

impl Routes {
    /// Routes to the modules of a layout whose boards can carry them. The first of several modules under one board's
    /// number counts.
    pub(super) fn new(layout: &Layout) -> Self {
        let senders: Vec<_> = (0..)
            .zip(layout.modules())
            .filter_map(|(index, module)| Some((index, module, module.address()?)))
            .collect();
        let buses = senders.iter().map(|(_, _, address)| address.bus).max();
        let of_bus = |bus: u8| {
            let sent_by = |id: u16| {
                let named = |(_, module, address): &&(u16, &Module, Address)| {
                    address.bus == bus && number(module.protocol(), id) == Some(address.board)
                };
                let (index, module, _) = senders.iter().find(named)?;
                route(id, *index, module)
            };
            (0..IDENTIFIERS).map(sent_by).collect()
        };
        Self(buses.map_or_else(Vec::new, |last| (0..=last).map(of_bus).collect()))
    }

    pub(super) fn find(&self, bus: u8, id: u16) -> Option<Route> {
        *self.0.get(usize::from(bus))?.get(usize::from(id))?
    }
}

/// The number of the board that sends under `id` by this protocol.
fn number(protocol: Protocol, id: u16) -> Option<u8> {
    match protocol {
        Protocol::Uskin => Some(sender(id).0),
        Protocol::Mtb => mtb::sender(id).map(|(board, _)| board),
    }
}

/// Finds the meaning of `id` among the frames that a module's board sends.
fn route(id: u16, module: u16, of: &Module) -> Option<Route> {
    match of.protocol() {
        Protocol::Uskin => {
            let (wiring, (_, place)) = (of.wiring()?, sender(id));
            Some(Route::Taxel {
                module,
                taxel: wiring.taxel(place)?.1 as u16, // a board has at most 64 taxels
                order: wiring.order(place)? as u16,
            })
        }
        Protocol::Mtb => {
            let first = usize::from(mtb::sender(id)?.1) * mtb::TAXELS;
            let active = of.active().get(first..)?.iter().take(mtb::TAXELS);
            let read = active.zip(0..).map(|(read, bit)| u16::from(*read) << bit);
            Some(Route::Triangle {
                module,
                first: first as u16, // at most 180
                read: read.sum(),
            })
        }
    }
}

#[cfg(test)]
#[path = "routes_tests.rs"]
mod tests;
