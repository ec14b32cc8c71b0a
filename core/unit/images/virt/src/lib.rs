//! QEMU's RISC-V `virt` as a driver unit: its clock, its watchdog by the timer's interrupt, and its network card. The boards
//! are the rig's.
#![no_std]

mod clock;
mod ethernet;

pub use clock::{Machine, count, now};
pub use ethernet::Ethernet;

use palpate_image::rig::{Pipes, Rig};
use palpate_image::{Arena, burnt_key};

/// The key, burnt in.
pub static KEY: [u8; 32] = burnt_key!();
/// Heap in which the unit is built: the guard takes most of it.
#[global_allocator]
pub static HEAP: Arena<{ 6 * 1024 }> = Arena::new();

/// The rig of this machine.
pub type Bench = Rig<Pipes, fn() -> u64>;

/// Starts the machine, its watchdog first of all, and its rig.
pub fn start() -> (Machine, Bench) {
    paint();
    let machine = Machine::start();
    let clock: fn() -> u64 = clock::now_ns;
    (machine, Rig::new(Pipes::open(), clock))
}

/// Fills what the stack has not used with the pattern of cortex-m-rt, so that its depth can be seen.
fn paint() {
    unsafe extern "C" {
        static mut __eheap: u32;
    }
    let mut at = core::ptr::addr_of_mut!(__eheap);
    let here = 0u32;
    // Below what this function itself may use.
    let end = (&raw const here).wrapping_sub(64).cast_mut();
    while at < end {
        // SAFETY: between the variables and the stack lies memory that nothing uses.
        unsafe { at.write_volatile(0xCCCC_CCCC) };
        at = at.wrapping_add(1);
    }
}

/// A program that failed begins anew, with everything off.
#[panic_handler]
fn failed(_: &core::panic::PanicInfo<'_>) -> ! {
    clock::reset()
}

/// A program that met an exception begins anew, with everything off.
#[unsafe(export_name = "ExceptionHandler")]
fn exception(_: &riscv_rt::TrapFrame) -> ! {
    clock::reset()
}
