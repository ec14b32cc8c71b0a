//! Tests of `mod.rs`.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use embedded_can::ErrorKind;

use super::*;
use crate::codec::can::CanFrame;
use crate::codec::mtb::{Message, halves};
use crate::codec::uskin::{Wiring, encode};
use crate::skin::{Module, ModuleScan};

/// Frames to come, and what was sent; a bus that does not exist takes nothing.
#[derive(Default)]
struct Bench {
    frames: VecDeque<Received>,
    sent: Vec<(u8, u16, [u8; 2])>,
}

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("no bus")]
struct NoBus;

impl embedded_can::Error for NoBus {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl CanBus for Bench {
    type Error = NoBus;

    fn receive(&mut self) -> Result<Option<Received>, NoBus> {
        Ok(self.frames.pop_front())
    }

    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), NoBus> {
        if bus == 7 {
            return Err(NoBus);
        }
        let data = [frame.data()[0], frame.data()[1]];
        self.sent.push((bus, frame.id(), data));
        Ok(())
    }
}

fn skin() -> CanSkin<Bench> {
    let at = |bus, board| Address { bus, board };
    let pad = |name| Module::grid(name, 4, 4, 4.7).unwrap();
    let modules = alloc::vec![
        pad("lost").with_address(at(7, 2)).unwrap(),
        pad("bare"),
        pad("tip").with_address(at(0, 4)).unwrap(),
    ];
    CanSkin::new(&Layout::new(modules).unwrap(), Bench::default())
}

#[test]
fn frames_become_scans_and_what_is_foreign_or_lost_is_counted() {
    let mut skin = skin();
    let frame = |n: u16, board| {
        let place = Wiring::FLAT.nth(usize::from(n)).unwrap();
        let (x, y, z) = (n, 100 + n, 200 + n);
        Received {
            at: Instant::from_micros(116 * u64::from(n)),
            bus: 0,
            frame: encode(board, place, Reading { x, y, z }).unwrap(),
        }
    };
    let scan = (0..16).filter(|n| *n != 5).map(|n| frame(n, 4));
    skin.bus_mut().frames.extend(scan.chain([frame(0, 9)]));
    let mut taken = Vec::new();
    let mut take = |s: &ModuleScan<'_>| {
        taken.push((s.module, s.at, s.counts.to_vec(), s.fresh.unwrap().to_vec()));
    };
    skin.scans(Instant::ZERO, &mut take).unwrap();
    let [(module, at, counts, fresh)] = &taken[..] else {
        panic!("{taken:?}");
    };
    assert_eq!((*module, *at), (2, Instant::from_micros(15 * 116)));
    for n in (0..16).filter(|n| *n != 5) {
        let place = Wiring::FLAT.nth(n).unwrap();
        let taxel = Wiring::FLAT.taxel(place).unwrap().1;
        let n = n as u16;
        assert_eq!((counts[taxel], fresh[taxel]), ([n, 100 + n, 200 + n], true));
    }
    assert_eq!(fresh.iter().filter(|f| !**f).count(), 1);
    assert_eq!((skin.foreign(), skin.lost()), (1, 1));
    assert_eq!((skin.lost_of(2), skin.lost_of(0)), (1, 0));
}

#[test]
fn every_board_is_told_also_behind_one_that_cannot_be_reached() {
    let mut skin = skin();
    assert_eq!(skin.start_all(), Err(NoBus));
    assert_eq!(skin.start(2), Ok(()));
    assert_eq!((skin.start(1), skin.start(9)), (Ok(()), Ok(())));
    let told = [(0, 0x204, [7, 0]); 2];
    assert_eq!(skin.bus().sent, told);
}

#[test]
fn triangles_become_scans_without_their_thermal_pads_and_a_lost_half_is_counted() {
    let mut active = [true; 24];
    (active[6], active[10]) = (false, false);
    let patch = Module::grid("patch", 2, 12, 6.5)
        .and_then(|m| m.with_active(&active))
        .and_then(|m| m.with_address(Address { bus: 0, board: 2 }))
        .unwrap();
    let layout = Layout::single(patch.with_protocol(Protocol::Mtb)).unwrap();
    let mut skin = CanSkin::new(&layout, Bench::default());
    let triangle = |scan: u64, triangle: u8| {
        let taxels = core::array::from_fn(|t| 100 + 12 * triangle + t as u8);
        let both = halves(&taxels).into_iter().zip(0..);
        both.map(move |(half, n)| {
            let message = Message {
                board: 2,
                triangle,
                half,
            };
            Received {
                at: Instant::from_micros(20_000 * scan + 500 * u64::from(triangle) + 130 * n),
                bus: 0,
                frame: message.encode().unwrap(),
            }
        })
    };
    // The second scan lacks the second half of its first triangle.
    let whole = triangle(0, 0).chain(triangle(0, 1));
    let torn = triangle(1, 0).take(1).chain(triangle(1, 1));
    skin.bus_mut().frames.extend(whole.chain(torn));
    let mut taken = Vec::new();
    let mut take = |s: &ModuleScan<'_>| {
        taken.push((s.counts.to_vec(), s.fresh.unwrap().to_vec()));
    };
    skin.scans(Instant::ZERO, &mut take).unwrap();
    assert_eq!(taken.len(), 2);
    let (counts, fresh) = &taken[0];
    assert_eq!(fresh[..], active);
    for (taxel, counts) in (0..24).zip(counts).filter(|(t, _)| active[*t as usize]) {
        assert_eq!(*counts, [0, 0, 100 + taxel]);
    }
    let missing = (0..24).filter(|&t| active[t] && !taken[1].1[t]);
    assert_eq!(missing.collect::<Vec<_>>(), [7, 8, 9, 11]);
    assert_eq!((skin.lost(), skin.foreign()), (4, 0));
    assert_eq!(skin.start(0), Ok(()), "it sends by itself");
    assert!(skin.bus().sent.is_empty());
}
