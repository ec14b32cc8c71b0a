//! Tests of `routes.rs`.

use super::*;
use crate::codec::can::CanFrame;
use crate::codec::uskin::{Message, decode};

/// The long way: what the frame says, the first module that it names, the place of its chip.
fn meant(modules: &[(u16, Address, Wiring)], bus: u8, id: u16) -> Option<(u16, u16, u16)> {
    let frame = CanFrame::new(id, &[0; 8])?;
    let Ok(Message::Data(data)) = decode(&frame) else {
        return None;
    };
    let of_bus = modules.iter().filter(|m| m.1.bus == bus);
    let named = |m: &&(u16, Address, Wiring)| data.board == m.1.board;
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
    let routes = Routes::new(&modules);
    for bus in 0..=3 {
        for id in 0..=0x7FF {
            let got = routes.find(bus, id).map(|r| (r.module, r.taxel, r.order));
            assert_eq!(got, meant(&modules, bus, id), "{bus} {id}");
            found += usize::from(got.is_some());
        }
    }
    assert_eq!(found, 72, "16 + 24 + 16 + 16");
    assert!(Routes::new(&[]).find(0, 3).is_none());
}
