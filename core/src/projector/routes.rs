//! Who sends under which identifier: a table made once, so that a frame off the bus costs one look.

use alloc::boxed::Box;
use alloc::vec::Vec;

use crate::skin::Address;
use crate::wire::uskin::{IdProfile, Wiring};

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
    /// For modules by index, address and wiring. Of several under one board's number the first counts, and under a
    /// profile whose identifiers name no board the first of the bus.
    pub(super) fn new(profile: IdProfile, modules: &[(u16, Address, Wiring)]) -> Self {
        let buses = modules.iter().map(|(_, address, _)| address.bus).max();
        let of_bus = |bus: u8| {
            let modules = || modules.iter().filter(move |m| m.1.bus == bus);
            let route = |id: u16| {
                let (board, place) = profile.place(id)?;
                let sender = modules().find(|m| board.is_none_or(|b| b == m.1.board));
                let (module, _, wiring) = *sender?;
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
mod tests {
    use super::*;
    use crate::wire::can::CanFrame;
    use crate::wire::uskin::{Message, decode};

    /// The long way: what the frame says, the first module that it names, the place of its chip.
    fn meant(
        profile: IdProfile,
        modules: &[(u16, Address, Wiring)],
        bus: u8,
        id: u16,
    ) -> Option<(u16, u16, u16)> {
        let frame = CanFrame::new(id, &[0; 8])?;
        let Ok(Message::Data(data)) = decode(profile, &frame) else {
            return None;
        };
        let of_bus = modules.iter().filter(|m| m.1.bus == bus);
        let named = |m: &&(u16, Address, Wiring)| data.board.is_none_or(|b| b == m.1.board);
        let (module, _, wiring) = of_bus.clone().find(named)?;
        let taxel = wiring.taxel(data.place)?.1;
        let order = wiring.order(data.place)?;
        Some((*module, taxel as u16, order as u16))
    }

    #[test]
    fn every_identifier_leads_where_decoding_it_leads() {
        let at = |bus, board| Address { bus, board };
        let two = Wiring::new(2, 4, 2).unwrap();
        let modules = [
            (0, at(0, 3), Wiring::FLAT),
            (1, at(0, 4), Wiring::CURVED),
            (2, at(2, 3), two),
            (3, at(0, 3), Wiring::CURVED), // a number that is taken
            (4, at(2, 15), Wiring::FLAT),
        ];
        let mut found = 0;
        for profile in [IdProfile::Current, IdProfile::Older, IdProfile::Base700] {
            let routes = Routes::new(profile, &modules);
            for bus in 0..=3 {
                for id in 0..=0x7FF {
                    let got = routes.find(bus, id).map(|r| (r.module, r.taxel, r.order));
                    assert_eq!(
                        got,
                        meant(profile, &modules, bus, id),
                        "{profile:?} {bus} {id}"
                    );
                    found += usize::from(got.is_some());
                }
            }
        }
        assert_eq!(found, 160, "16 + 24 + 16 + 16, 16 + 24 + 16, and 16 + 16");
        assert!(Routes::new(IdProfile::Current, &[]).find(0, 3).is_none());
    }
}
