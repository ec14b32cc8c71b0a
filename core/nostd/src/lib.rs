//! Links `palpate-core` into a static library that brings its own panic handler and allocator. If the
//! core pulled in `std`, there would be two panic handlers and this would not build.
#![no_std]

use core::alloc::{GlobalAlloc, Layout};
use core::panic::PanicInfo;

use palpate_core::units::{Clock, Prescale};

struct NoMemory;

// SAFETY: never hands out memory, so there is nothing to uphold.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for NoMemory {
    unsafe fn alloc(&self, _layout: Layout) -> *mut u8 {
        core::ptr::null_mut()
    }
    unsafe fn dealloc(&self, _ptr: *mut u8, _layout: Layout) {}
}

#[global_allocator]
static ALLOCATOR: NoMemory = NoMemory;

#[panic_handler]
fn panic(_info: &PanicInfo<'_>) -> ! {
    loop {}
}

/// Keeps the core linked: the register value of the default PWM frequency.
#[unsafe(no_mangle)]
pub extern "C" fn palpate_default_prescale() -> u8 {
    Prescale::from_hz(Clock::INTERNAL, 200.0).map_or(0, |p| p.get())
}
