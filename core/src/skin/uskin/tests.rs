//! Tests of `mod.rs`.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use embedded_can::ErrorKind;

use super::*;
use crate::codec::can::CanFrame;
use crate::codec::uskin::{Wiring, encode};
use crate::skin::Module;

/// Frames to come, and what was sent; a bus that does not exist takes nothing.
#[derive(Default)]
struct Bench {
    frames: VecDeque<Received>,
    sent: Vec<(u8, u16, [u8; 2])>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
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

fn skin() -> UskinCan<Bench> {
    let at = |bus, board| Address { bus, board };
    let pad = |name| Module::grid(name, 4, 4, 4.7).unwrap();
    let modules = alloc::vec![
        pad("lost").with_address(at(7, 2)).unwrap(),
        pad("bare"),
        pad("tip").with_address(at(0, 4)).unwrap(),
    ];
    UskinCan::new(&Layout::new(modules).unwrap(), Bench::default())
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
    assert_eq!(skin.stop_all(), Err(NoBus));
    assert_eq!(skin.start(2), Ok(()));
    assert_eq!((skin.start(1), skin.start(9)), (Ok(()), Ok(())));
    let told = [(0, 0x204, [7, 0]), (0, 0x204, [7, 1]), (0, 0x204, [7, 0])];
    assert_eq!(skin.bus().sent, told);
}
