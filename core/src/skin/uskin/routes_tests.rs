//! Tests of `routes.rs`.

use super::*;
use crate::codec::can::CanFrame;
use crate::codec::uskin::{Message, decode};

fn at(bus: u8, board: u8) -> Address {
    Address { bus, board }
}

fn pad(name: &str, columns: u16, address: Address) -> Module {
    let pad = Module::grid(name, 4, columns, 4.7).unwrap();
    pad.with_address(address).unwrap()
}

/// The long way: what the frame says, the module that it names, the place of its chip.
fn meant(modules: &[Module], bus: u8, id: u16) -> Option<(u16, u16, u16)> {
    let frame = CanFrame::new(id, &[0; 8])?;
    let Ok(Message::Data(data)) = decode(&frame) else {
        return None;
    };
    let named = |m: &&Module| m.address() == Some(at(bus, data.board));
    let module = modules.iter().position(|m| named(&m))?;
    let wiring = modules[module].wiring()?;
    let taxel = wiring.taxel(data.place)?.1;
    let order = wiring.order(data.place)?;
    Some((module as u16, taxel as u16, order as u16))
}

#[test]
fn every_identifier_leads_where_decoding_it_leads() {
    let modules = alloc::vec![
        pad("flat", 4, at(0, 3)),
        pad("curved", 6, at(0, 4)),
        pad("far", 4, at(2, 15)),
    ];
    let layout = Layout::new(modules.clone()).unwrap();
    let mut found = 0;
    let routes = Routes::new(&layout);
    for bus in 0..=3 {
        for id in 0..=0x7FF {
            let got = routes.find(bus, id).map(|route| match route {
                Route::Taxel {
                    module,
                    taxel,
                    order,
                } => (module, taxel, order),
                Route::Triangle { .. } => panic!("no board here sends triangles"),
            });
            assert_eq!(got, meant(&modules, bus, id), "{bus} {id}");
            found += usize::from(got.is_some());
        }
    }
    assert_eq!(found, 56, "16 + 24 + 16");
    let bare = Module::grid("bare", 4, 4, 4.7).unwrap();
    let none = Layout::single(bare).unwrap();
    assert!(Routes::new(&none).find(0, 3).is_none());
}

#[test]
fn a_triangle_knows_its_place_and_which_of_its_taxels_are_read() {
    let mut active = [true; 20];
    (active[6], active[10], active[19]) = (false, false, false);
    let patch = Module::grid("patch", 2, 10, 6.5)
        .and_then(|m| m.with_active(&active))
        .and_then(|m| m.with_address(at(1, 9)))
        .unwrap();
    let layout = Layout::single(patch.with_protocol(Protocol::Mtb)).unwrap();
    let routes = Routes::new(&layout);
    let triangle = |id| match routes.find(1, id) {
        Some(Route::Triangle {
            module: 0,
            first,
            read,
        }) => Some((first, read)),
        _ => None,
    };
    assert_eq!(triangle(0x490), Some((0, 0b1011_1011_1111)));
    assert_eq!(triangle(0x491), Some((12, 0b0111_1111)));
    for id in [0x492, 0x480, 0x590, 0x390] {
        assert_eq!(triangle(id), None, "{id:x}");
    }
}
