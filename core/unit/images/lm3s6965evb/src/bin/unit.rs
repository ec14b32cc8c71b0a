//! The driver unit: datagrams by UDP.
#![no_std]
#![no_main]

use core::ptr::addr_of_mut;

use cortex_m_rt::entry;
use embedded_hal::digital::OutputPin;
use palpate_core::codec::link::MOST;
use palpate_image::rig::{Bus, Oe};
use palpate_image::serve;
use palpate_image_lm3s6965evb::settings::settings;
use palpate_image_lm3s6965evb::{Bytes, HEAP, Memory, Udp, start};
use palpate_unit::Unit;

static mut MEMORY: Memory = Memory::new();
static mut BYTES: Bytes = ([0; 2 * MOST], [0; MOST]);

#[entry]
fn main() -> ! {
    let (mut machine, rig) = start();
    let mut oe = Oe(&rig);
    // Outputs off before anything else; the unit then says so to the chips.
    let _ = oe.set_high();
    let boot = rig.boot();
    // SAFETY: the one use of each.
    let (memory, bytes) = unsafe { (&mut *addr_of_mut!(MEMORY), &mut *addr_of_mut!(BYTES)) };
    let mut link = Udp::start(memory, bytes, boot);
    let Ok(unit) = Unit::new(&settings(boot), Bus(&rig), oe) else {
        panic!("settings that no unit can have");
    };
    HEAP.close();
    serve(unit, &mut machine, &mut link)
}
