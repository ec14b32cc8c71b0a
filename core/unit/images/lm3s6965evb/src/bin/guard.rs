//! The unit's guard alone, questioned by the rig: its decisions and what they cost.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use palpate_image::rig::guard;
use palpate_image_lm3s6965evb::{HEAP, Machine, start};

#[entry]
fn main() -> ! {
    let (mut machine, rig) = start();
    guard(&rig, &HEAP, &mut machine, Machine::ticks)
}
