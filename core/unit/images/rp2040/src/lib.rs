//! Boards with an RP2040, such as a Raspberry Pi Pico, as a driver unit: datagrams over USB, boards on I2C.
#![no_std]

mod bridge;
mod bus;
mod serial;
mod settings;
mod slip;

pub use bridge::{Bridge, STEPS};
pub use bus::Settled;
pub use serial::Serial;
pub use settings::{regulator, settings};

use palpate_core::units::Instant;
use palpate_image::{Arena, Processor, Register};
use rp2040_hal::Watchdog;

/// Heap in which the unit is built: the guard takes most of it.
#[global_allocator]
pub static HEAP: Arena<{ 6 * 1024 }> = Arena::new();

/// Microseconds since the start, as two words without a latch.
const TIME: [Register; 2] = [Register(0x4005_4028), Register(0x4005_4024)];
/// The watchdog's control; its top bit resets.
const WATCHDOG: Register = Register(0x4005_8000);
const RESET: u32 = 1 << 31;

/// Time since the start.
pub fn now() -> Instant {
    loop {
        let high = TIME[1].read();
        let low = TIME[0].read();
        if TIME[1].read() == high {
            return Instant::from_micros(u64::from(high) << 32 | u64::from(low));
        }
    }
}

/// The processor, with its watchdog, which runs already.
pub struct Machine(pub Watchdog);

impl Processor for Machine {
    fn now(&self) -> Instant {
        now()
    }

    // The port has to be looked at all the time, and it brings the power.
    fn rest(&mut self, _: Instant) {}

    fn feed(&mut self) {
        self.0.feed();
    }
}

/// A program that failed begins anew, with everything off.
#[panic_handler]
fn failed(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        WATCHDOG.write(RESET);
    }
}
