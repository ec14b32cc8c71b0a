//! The driver unit: datagrams by UDP.
#![no_std]
#![no_main]

use core::ptr::addr_of_mut;

use cortex_m_rt::entry;
use palpate_image::rig::unit;
use palpate_image::udp::{Bytes, GUEST, Memory, NO_BYTES, Udp};
use palpate_image_lm3s6965evb::{Ethernet, HEAP, KEY, now, start};

static mut MEMORY: Memory = Memory::new();
static mut BYTES: Bytes = NO_BYTES;

#[entry]
fn main() -> ! {
    let (mut machine, rig) = start();
    unit(&rig, &HEAP, &mut machine, &KEY, |_| {
        // SAFETY: the one use of each.
        let memory = unsafe { (&mut *addr_of_mut!(MEMORY), &mut *addr_of_mut!(BYTES)) };
        Udp::start(Ethernet::start(), now, GUEST, memory)
    })
}
