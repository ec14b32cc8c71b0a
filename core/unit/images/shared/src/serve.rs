//! The program of every image: a turn, the watchdog, a rest.

use embedded_hal::digital::OutputPin;
use embedded_hal::i2c::I2c;
use palpate_core::units::{Duration, Instant};
use palpate_unit::{Datagrams, Module, Unit};

/// Longest rest: half of the hardware watchdog's first 20 ms.
const REST: Duration = Duration::from_millis(10);

/// Services of a processor to the program: time, rest and a watchdog.
pub trait Processor {
    /// Time since the start. It never goes back.
    fn now(&self) -> Instant;

    /// Rests until `until` at the latest, or less: until a datagram comes, where the processor can tell.
    fn rest(&mut self, until: Instant);

    /// Feeds the hardware watchdog, which was started before the unit and bites after 2 x 20 ms at most.
    fn feed(&mut self);
}

/// A processor that counts in place of a rest, so that a run repeats. QEMU 7.2 wakes one that rests from another thread.
/// Instructions since its last look at the clock, up to a microsecond of them, have been counted by then or have not.
#[derive(Debug)]
pub struct Awake<P> {
    /// The machine.
    pub machine: P,
    /// Function that counts for this many nanoseconds.
    pub count: fn(u64),
}

impl<P: Processor> Processor for Awake<P> {
    fn now(&self) -> Instant {
        self.machine.now()
    }

    fn rest(&mut self, until: Instant) {
        (self.count)(until.since(self.now()).as_micros() * 1000);
    }

    fn feed(&mut self) {
        self.machine.feed();
    }
}

/// A network whose datagrams the processor may have to look for.
pub trait Link: Datagrams {
    /// Time at which to look for datagrams; at once if some wait.
    fn next(&mut self) -> Option<Instant>;
}

/// Runs a unit for ever.
pub fn serve<I: I2c, P: OutputPin, T: Module>(
    mut unit: Unit<I, P, T>,
    processor: &mut impl Processor,
    link: &mut impl Link,
) -> ! {
    unit.start(processor.now());
    loop {
        let now = processor.now();
        unit.turn(now, link);
        // Here and nowhere else: a loop that hangs is one that does not come by.
        processor.feed();
        let rest = (now + REST).min(unit.next());
        let until = link.next().map_or(rest, |at| at.min(rest));
        processor.rest(until);
    }
}
