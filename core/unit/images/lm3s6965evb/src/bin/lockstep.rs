//! The driver unit whose datagrams are the rig's: all of its time is virtual, and every run of it is the same.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use embedded_hal::digital::OutputPin;
use palpate_image::rig::{Bus, Network, Oe};
use palpate_image::serve;
use palpate_image_lm3s6965evb::settings::settings;
use palpate_image_lm3s6965evb::{HEAP, start};
use palpate_unit::Unit;

#[entry]
fn main() -> ! {
    let (mut machine, rig) = start();
    let mut oe = Oe(&rig);
    // Outputs off before anything else; the unit then says so to the chips.
    let _ = oe.set_high();
    let boot = rig.boot();
    let mut link = Network::new(&rig);
    let Ok(unit) = Unit::new(&settings(boot), Bus(&rig), oe) else {
        panic!("settings that no unit can have");
    };
    HEAP.close();
    serve(unit, &mut machine, &mut link)
}
