//! A skin and an actuator of one's own on the real loop: a sensor of 16 taxels that a finger presses at 0.5 s, and a board
//! that prints what the guard lets through.

#![allow(clippy::print_stdout)] // its output is the point

use std::convert::Infallible;
use std::error::Error;

use palpate_core::driver::Actuators;
use palpate_core::guard::Guarded;
use palpate_core::illusion::{Display, DisplayWire};
use palpate_core::projector::{Cause, Projector};
use palpate_core::skin::{Layout, Module, ModuleScan, SkinSource};
use palpate_core::units::{Board, Channel, Instant, Point};

/// A sensor that is read every 10 ms.
struct Pad(u64);

impl SkinSource for Pad {
    type Error = Infallible;

    fn scans(
        &mut self,
        now: Instant,
        take: &mut dyn FnMut(&ModuleScan<'_>),
    ) -> Result<(), Infallible> {
        while self.0 <= now.as_micros() {
            let mut counts = [[32_768, 32_768, 40_000]; 16];
            if self.0 > 500_000 {
                counts[5][2] += 600;
            }
            take(&ModuleScan::whole(0, Instant::from_micros(self.0), &counts));
            self.0 += 10_000;
        }
        Ok(())
    }
}

/// A board on paper.
struct Paper;

impl Actuators for Paper {
    type Error = Infallible;

    fn apply(&mut self, update: &Guarded) -> Result<(), Infallible> {
        let channels = update.channels().iter().enumerate();
        for (channel, setting) in channels.filter_map(|(n, setting)| Some((n, (*setting)?))) {
            let (ms, ticks) = (update.at().as_micros() / 1000, setting.off - setting.on);
            println!("{ms:>4} ms  channel {channel}  {ticks:>3} of 4096");
        }
        Ok(())
    }

    fn all_off(&mut self) -> Result<(), Infallible> {
        println!("all off");
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let layout = Layout::single(Module::grid("pad", 4, 4, 4.7)?)?; // 4.7 mm apart
    let wire = |n: u8| DisplayWire {
        place: Point::new(11.0 * f32::from(n), 0.0),
        board: Board(0),
        channel: Channel(n),
    };
    let display = Display::new(&[wire(0), wire(1)])?;
    let mut projector = Projector::builder(layout, display).build()?;
    let (mut pad, mut now) = (Pad(0), Instant::ZERO);
    while now < Instant::from_micros(1_000_000) {
        projector.poll(now, &mut pad, &mut Paper, &mut ())?;
        let reading = Instant::from_micros(pad.0);
        now = projector.next().min(reading); // on hardware: wait until then
    }
    projector.all_off(now, Cause::End, &mut Paper, &mut ())?;
    Ok(())
}
