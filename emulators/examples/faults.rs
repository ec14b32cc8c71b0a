//! Drivers of one's own on buses that fail when they are told to. Does an I2C driver try again, and is the output right
//! afterwards? What does a CAN decoder notice of frames that are lost, garbled or cut, and of a board that is bus-off?
//!
//! `cargo run -p palpate-emulators --example faults`
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use std::collections::BTreeMap;
use std::error::Error;

use embedded_hal::i2c::I2c;
use palpate_core::bus::CanBus;
use palpate_core::codec::can::CanFrame;
use palpate_emulators::display::i2c::fault::{I2cFault, I2cFaultKind, I2cFaults, Shared};
use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment};
use palpate_emulators::display::pca9685::{Config, Pca9685};
use palpate_emulators::sensor::board::BoardConfig;
use palpate_emulators::sensor::can::faults::{Faulty, Rates};
use palpate_emulators::sensor::rig::{Handle, SkinBus};
use palpate_emulators::sensor::{EmulatedModule, ModuleConfig};
use palpate_emulators::time::Nanos;

/// The I2C driver under test: output 0 on for so many ticks of 4096, tried three times.
fn set<I: I2c>(bus: &mut I, ticks: u16) -> Result<u32, I::Error> {
    let [low, high] = ticks.to_le_bytes();
    let mut failed = 0;
    loop {
        match bus.write(0x40, &[0x06, 0, 0, low, high]) {
            Ok(()) => return Ok(failed),
            Err(error) if failed == 2 => return Err(error),
            Err(_) => failed += 1,
        }
    }
}

fn i2c() -> Result<(), Box<dyn Error>> {
    let chip = Pca9685::new(Config::new(0x40));
    let bus = I2cHandle::new(I2cSegment::new(BusClock::Fast, vec![chip]));
    let mut faulty = Shared::new(I2cFault::new(bus.clone(), I2cFaults::default(), 1, "bus"));
    faulty.clone().write(0x40, &[0x00, 0x21])?; // awake, with auto-increment

    for (kind, ticks) in I2cFaultKind::ALL.into_iter().zip((1..).map(|n| 256 * n)) {
        faulty.with(|layer| layer.strike(kind));
        let outcome = match set(&mut faulty, ticks) {
            Ok(failed) => format!("done, {failed} failed"),
            Err(error) => format!("given up: {error}"),
        };
        faulty.with(I2cFault::free);
        let chip = |segment: &mut I2cSegment| {
            let chip = segment.chips().first();
            chip.map(|chip| u16::from_le_bytes([chip.register(0x08), chip.register(0x09)]))
        };
        let held = bus.with(chip)?.ok_or("no chip")?;
        println!("{kind:?}: {outcome}; the chip holds {held} of {ticks} ticks");
    }
    Ok(())
}

/// The CAN decoder under test: the newest normal count of each taxel.
#[derive(Default)]
struct Decoder {
    counts: BTreeMap<u16, u16>,
    taken: u32,
    short: u32,
    jumped: u32,
}

impl Decoder {
    fn take(&mut self, frame: &CanFrame) {
        let &[_, _, _, _, _, high, low, ..] = frame.data() else {
            self.short += 1;
            return;
        };
        let count = u16::from_be_bytes([high, low]);
        let held = self.counts.entry(frame.id()).or_insert(count);
        if held.abs_diff(count) > 100 {
            self.jumped += 1; // nothing presses this skin
        } else {
            *held = count;
            self.taken += 1;
        }
    }
}

fn can() -> Result<(), Box<dyn Error>> {
    let mut bus = SkinBus::new(1_000_000); // bit/s
    let board = BoardConfig {
        autostart: true, // 16 taxels at 100 Hz
        ..BoardConfig::default()
    };
    bus.add_board(board, vec![EmulatedModule::new(ModuleConfig::default())])?;
    let rig = Handle::new(vec![bus]);
    let mut faulty = Faulty::new(rig.clone(), 1, "can");
    faulty.set_rates(Rates {
        lost: 0.05,
        corrupted: 0.03, // behind the controller: no checksum sees it
        short: 0.02,
        ..Rates::default()
    });
    rig.advance(Nanos::from_micros(999_000));
    let mut decoder = Decoder::default();
    while let Some(received) = faulty.receive()? {
        decoder.take(&received.frame);
    }
    let (hit, took) = (faulty.counts(), decoder);
    println!(
        "{} lost, {} garbled, {} cut: {} taken, {} too short, {} jumped",
        hit.lost, hit.corrupted, hit.short, took.taken, took.short, took.jumped
    );

    // The board's controller leaves the bus, and comes back by itself.
    rig.with(|buses| {
        let node = buses[0].boards()[0].node();
        buses[0].segment_mut().force_bus_off(node);
    });
    let silent = (1..1000).find(|ms| {
        rig.advance(Nanos::from_micros(999_000 + 1000 * ms));
        matches!(faulty.receive(), Ok(Some(_)))
    });
    let silent = silent.ok_or("the board stays away")?;
    println!("the board is bus-off, and silent for {silent} ms");
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    i2c()?;
    can()
}
