//! Time, rest and the watchdog.

use core::mem::MaybeUninit;
use core::ptr::addr_of_mut;
use core::sync::atomic::{Ordering, compiler_fence};

use cortex_m::asm;
use palpate_core::units::{Duration, Instant};
use palpate_image::{Processor, Register};

use crate::ethernet::Ethernet;

/// Run-mode clock: system divider 4, used: 50 MHz in QEMU, 20 ns per tick.
const RCC: Register = Register(0x400F_E060);
const DIVIDER_4: u32 = 3 << 23 | 1 << 22;
const TICK_NS: u64 = 20;

const WATCHDOG_LOAD: Register = Register(0x4000_0000);
const WATCHDOG_CONTROL: Register = Register(0x4000_0008);
const WATCHDOG_CLEAR: Register = Register(0x4000_000C);
/// The watchdog resets the second time that it runs out, so that a hang lasts for 40 ms at most.
const WATCHDOG_TICKS: u32 = 1_000_000;

const SYSTICK_CONTROL: Register = Register(0xE000_E010);
const SYSTICK_RELOAD: Register = Register(0xE000_E014);
const SYSTICK_VALUE: Register = Register(0xE000_E018);
/// All 24 bits: 0.34 s per lap.
const LAP: u32 = 0x00FF_FFFF;

const TIMER_CONFIG: Register = Register(0x4003_0000);
const TIMER_MODE: Register = Register(0x4003_0004);
const TIMER_CONTROL: Register = Register(0x4003_000C);
const TIMER_MASK: Register = Register(0x4003_0018);
const TIMER_CLEAR: Register = Register(0x4003_0024);
const TIMER_LOAD: Register = Register(0x4003_0028);
const TIMER_INTERRUPT: usize = 19;
const ETHERNET_INTERRUPT: usize = 42;
/// Registers of the interrupt controller.
const ENABLE: usize = 0xE000_E100;
const DISABLE: usize = 0xE000_E180;
const UNPEND: usize = 0xE000_E280;

/// What the clock has counted. It lies outside what a start clears: after a reset by the watchdog it goes on, and with it
/// the rig's chips, which were not reset.
#[derive(Clone, Copy)]
struct Counted {
    /// Twice, each with its complement: a reset can come while one is being written. Anything else after power-on.
    ticks: [(u64, u64); 2],
    /// SysTick at the last look.
    value: u32,
}

impl Counted {
    fn write(&mut self, ticks: u64) {
        for copy in &mut self.ticks {
            *copy = (ticks, !ticks);
            // In this order.
            compiler_fence(Ordering::SeqCst);
        }
    }

    fn known(&self) -> u64 {
        let whole = self.ticks.iter().filter(|(ticks, check)| *check == !*ticks);
        whole.map(|(ticks, _)| *ticks).max().unwrap_or(0)
    }
}

#[unsafe(link_section = ".uninit.counted")]
static mut COUNTED: MaybeUninit<Counted> = MaybeUninit::zeroed();

fn counted() -> &'static mut Counted {
    // SAFETY: one thread, no interrupt handler, and no reference is kept; any bytes are integers.
    unsafe { (*addr_of_mut!(COUNTED)).assume_init_mut() }
}

/// Ticks of 20 ns since power-on.
pub fn ticks() -> u64 {
    let counted = counted();
    let value = SYSTICK_VALUE.read();
    let ticks = counted.ticks[0].0 + u64::from(counted.value.wrapping_sub(value) & LAP);
    counted.value = value;
    counted.write(ticks);
    ticks
}

/// The same in nanoseconds.
pub fn now_ns() -> u64 {
    ticks() * TICK_NS
}

/// The same as the unit counts it.
pub fn now() -> Instant {
    Instant::from_micros(ticks() / (1000 / TICK_NS))
}

/// Nanoseconds of two instructions, as QEMU counts them: one round of a delay.
const ROUND_NS: u64 = 64;

/// The machine's clock, alarm and watchdog.
#[derive(Debug)]
pub struct Machine(());

impl Machine {
    /// Starts them, the watchdog first.
    pub(crate) fn start() -> Self {
        RCC.write(DIVIDER_4);
        WATCHDOG_LOAD.write(WATCHDOG_TICKS);
        WATCHDOG_CONTROL.write(0b11);
        SYSTICK_RELOAD.write(LAP);
        SYSTICK_VALUE.write(0);
        SYSTICK_CONTROL.write(0b101);
        let counted = counted();
        counted.write(counted.known());
        counted.value = SYSTICK_VALUE.read();
        TIMER_CONFIG.write(0);
        TIMER_MODE.write(1);
        TIMER_MASK.write(1);
        // Interrupts wake the processor; no handler runs, for a Cortex-M0's table ends before the Ethernet's.
        cortex_m::interrupt::disable();
        Self(())
    }

    /// What the clock counts, for a measurement: 20 ns each.
    pub fn ticks() -> u32 {
        ticks() as u32
    }

    /// Writes the bits of the interrupts that end a rest to one of the interrupt controller's sets of registers.
    fn interrupts(set: usize) {
        for interrupt in [TIMER_INTERRUPT, ETHERNET_INTERRUPT] {
            Register(set + 4 * (interrupt / 32)).write(1 << (interrupt % 32));
        }
    }
}

impl Processor for Machine {
    fn now(&self) -> Instant {
        now()
    }

    fn rest(&mut self, until: Instant) {
        let span = until.since(self.now()).min(Duration::from_millis(100));
        if span == Duration::ZERO {
            return;
        }
        TIMER_CLEAR.write(1);
        // Bits from before would end the rest at once; from here on none is cleared, and none is missed.
        Self::interrupts(UNPEND);
        Self::interrupts(ENABLE);
        TIMER_LOAD.write(span.as_micros() as u32 * (1000 / TICK_NS as u32));
        TIMER_CONTROL.write(1);
        if !Ethernet::is_waiting() {
            asm::wfi();
        }
        Self::interrupts(DISABLE);
        TIMER_CONTROL.write(0);
    }

    fn feed(&mut self) {
        WATCHDOG_CLEAR.write(1);
    }
}

/// Counts instructions for so many nanoseconds.
pub fn count(ns: u64) {
    asm::delay((ns / ROUND_NS) as u32);
}
