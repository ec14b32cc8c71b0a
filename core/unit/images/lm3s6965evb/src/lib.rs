//! QEMU's lm3s6965evb as a driver unit: its clock, watchdog and Ethernet. The boards are the rig's.
#![no_std]

mod clock;
mod ethernet;

pub use clock::{Machine, count, now};
pub use ethernet::Ethernet;

use palpate_image::rig::{Pipes, Rig};
use palpate_image::{Arena, burnt_key};

/// The key, burnt in.
pub static KEY: [u8; 32] = burnt_key!();
/// What the unit is built in: the guard takes most of it.
#[global_allocator]
pub static HEAP: Arena<{ 6 * 1024 }> = Arena::new();

/// The rig of this machine.
pub type Bench = Rig<Pipes, fn() -> u64>;

/// Starts the machine, its watchdog first of all, and its rig.
pub fn start() -> (Machine, Bench) {
    let machine = Machine::start();
    let clock: fn() -> u64 = clock::now_ns;
    (machine, Rig::new(Pipes::open(), clock))
}

/// A program that failed begins anew, with everything off.
#[panic_handler]
fn failed(_: &core::panic::PanicInfo<'_>) -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}
