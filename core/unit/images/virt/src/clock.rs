//! Time, rest and a watchdog. The machine has none: the timer's interrupt resets it, unless the loop comes by.

use palpate_core::units::{Duration, Instant};
use palpate_image::{Processor, Register};
use riscv::register::{mcycle, mie, mstatus};
use riscv_rt::core_interrupt;

use crate::ethernet::Ethernet;

/// The timer counts 10 MHz.
const TICKS_PER_US: u64 = 10;
const TIME: [Register; 2] = [Register(0x0200_BFF8), Register(0x0200_BFFC)];
/// The timer's interrupt waits as long as the time is at least this.
const ALARM: [Register; 2] = [Register(0x0200_4000), Register(0x0200_4004)];
/// Writing [`RESET`] here resets the machine.
const FINISH: Register = Register(0x0010_0000);
const RESET: u32 = 0x7777;
/// Count of the clock, and its complement, in memory that the image is not linked to. After a reset the count goes on,
/// and with it the rig's chips, which were not reset.
const COUNTED: [Register; 4] = [
    Register(0x8040_0000),
    Register(0x8040_0004),
    Register(0x8040_0008),
    Register(0x8040_000C),
];
/// A hang lasts for 40 ms at most, as with a hardware watchdog of 2 x 20 ms.
const WATCHDOG: u64 = 40_000 * TICKS_PER_US;

/// Nanoseconds of an instruction, as QEMU counts it.
const INSTRUCTION_NS: u64 = 8;

/// The machine's clock, alarm and watchdog.
#[derive(Debug)]
pub struct Machine {
    /// Time at which the watchdog bites, by the timer.
    bites: u64,
}

fn timer() -> u64 {
    loop {
        let high = TIME[1].read();
        let low = TIME[0].read();
        if TIME[1].read() == high {
            return join(low, high);
        }
    }
}

const fn join(low: u32, high: u32) -> u64 {
    (high as u64) << 32 | low as u64
}

fn set_alarm(at: u64) {
    // Never early in between, and never far: QEMU 7.2 stands still after a reset with an alarm that the clock never reaches.
    ALARM[0].write(u32::MAX);
    ALARM[1].write((at >> 32) as u32);
    ALARM[0].write(at as u32);
}

/// Count of the clock before the last reset; it is written down after each look at the clock.
static mut BEFORE: u64 = 0;

fn before() -> u64 {
    // SAFETY: one thread; the interrupt's handler never returns to it.
    unsafe { BEFORE }
}

fn ticks() -> u64 {
    let ticks = before() + timer();
    let (low, high) = (ticks as u32, (ticks >> 32) as u32);
    for (register, word) in COUNTED.iter().zip([low, high, !low, !high]) {
        register.write(word);
    }
    ticks
}

/// Nanoseconds since power-on.
pub fn now_ns() -> u64 {
    ticks() * (1000 / TICKS_PER_US)
}

/// Time since power-on as the unit counts it.
pub fn now() -> Instant {
    Instant::from_micros(ticks() / TICKS_PER_US)
}

/// Resets the machine.
pub fn reset() -> ! {
    // What this interrupts may be half written down.
    let _ = ticks();
    FINISH.write(RESET);
    loop {
        core::hint::spin_loop();
    }
}

/// The watchdog bit.
#[core_interrupt(riscv::interrupt::Interrupt::MachineTimer)]
fn bite() {
    reset()
}

impl Machine {
    /// Starts clock, alarm and watchdog, the watchdog first.
    pub(crate) fn start() -> Self {
        let mut machine = Self { bites: 0 };
        machine.feed();
        // SAFETY: the one handler is ready, and the trap vector was set before `main`.
        unsafe {
            mie::set_mtimer();
            mstatus::set_mie();
        }
        let [low, high, not_low, not_high] = COUNTED.map(Register::read);
        if (low, high) == (!not_low, !not_high) {
            // A reset sets the timer to zero.
            // SAFETY: as in `before`.
            unsafe { BEFORE = join(low, high).saturating_sub(timer()) };
        }
        machine
    }

    /// Count for measurements: nanoseconds of instructions.
    pub fn ticks() -> u32 {
        mcycle::read() as u32
    }
}

impl Processor for Machine {
    fn now(&self) -> Instant {
        now()
    }

    fn rest(&mut self, until: Instant) {
        let span = until.since(self.now());
        if span == Duration::ZERO {
            return;
        }
        // Interrupts end the rest, and no handler runs.
        // SAFETY: they are on again below.
        unsafe { mstatus::clear_mie() };
        set_alarm(self.bites.min(timer() + span.as_micros() * TICKS_PER_US));
        Ethernet::listen();
        if !Ethernet::is_waiting() {
            riscv::asm::wfi();
        }
        Ethernet::ignore();
        set_alarm(self.bites);
        // SAFETY: as at the start.
        unsafe { mstatus::set_mie() };
    }

    fn feed(&mut self) {
        self.bites = timer() + WATCHDOG;
        set_alarm(self.bites);
    }
}

/// Counts instructions for so many nanoseconds.
pub fn count(ns: u64) {
    riscv::asm::delay((ns / INSTRUCTION_NS) as u32);
}
