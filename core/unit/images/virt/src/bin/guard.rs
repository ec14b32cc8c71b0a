//! The unit's guard alone, questioned by the rig: its decisions and what they cost.
#![no_std]
#![no_main]

use palpate_image::rig::guard;
use palpate_image_virt::{HEAP, Machine, start};
use riscv_rt::entry;

#[entry]
fn main() -> ! {
    let (mut machine, rig) = start();
    guard(&rig, &HEAP, &mut machine, Machine::ticks)
}
