//! The driver unit whose datagrams are the rig's: all of its time is virtual, and every run of it is the same.
#![no_std]
#![no_main]

use palpate_image::Awake;
use palpate_image::rig::lockstep;
use palpate_image_virt::{HEAP, KEY, count, start};
use riscv_rt::entry;

#[entry]
fn main() -> ! {
    let (machine, rig) = start();
    lockstep(&rig, &HEAP, &mut Awake { machine, count }, &KEY)
}
