//! Amplifiers whose current a bench's converters set.

use embedded_hal::i2c::I2c;
use palpate_core::driver::Banks;
use palpate_core::guard::{CurrentControl, Guard};
use palpate_core::schedule::Share;
use palpate_core::units::{Duration, Milliamps, Prescale, Ticks};
use palpate_emulators::unit::Converters;
use palpate_files::Bench;

use super::{boards, milliamps};

/// Bus time of one current at 400 kbit/s: written, read back, and read once more by a look at all boards: 38, 48 and 48
/// bits.
const EACH: Duration = Duration::from_micros(335);

/// Tolerances of the amplifiers' set currents, for the guard; `None` where the amplifiers have one current.
pub(super) fn control(bench: &Bench) -> Option<CurrentControl> {
    let dac = bench.dac.as_ref()?;
    Some(CurrentControl {
        full_scale: milliamps(bench.drive.current_ma),
        gain_ppm: (dac.gain_tolerance * 1e6).ceil() as u32,
        offset: Milliamps(dac.offset_tolerance_ma.ceil() as u32),
    })
}

/// Longest time for which writes of currents hold up a board that is to be switched off.
pub(super) fn wait(bench: &Bench) -> Duration {
    let wires = bench.dac.as_ref().map_or(0, |_| bench.outputs.len());
    Duration::from_micros(current_wait(wires))
}

/// Longest time for which the currents of `wires` wires take a bus, microseconds: each written, read back and looked
/// at.
pub(crate) const fn current_wait(wires: usize) -> u64 {
    EACH.as_micros() * wires as u64
}

/// Split of a level into width and current: pulses that the limits bear are no shorter than the bench says.
pub(super) fn share(bench: &Bench, guard: &Guard, peak: Milliamps) -> Share {
    let Some(dac) = &bench.dac else {
        return Share::width(peak);
    };
    let ticks = (dac.shortest_us * 1e3 / guard.prescale().tick_ns() as f64).round();
    Share {
        peak,
        narrowest: Ticks::new(ticks as u16).min(guard.widest()),
    }
}

/// The driver of a bench's boards on one bus, and of their converters where there are any.
pub fn banks<I: I2c>(bench: &Bench, i2c: I, prescale: Prescale) -> Banks<I> {
    with_converters(bench, Banks::new([(i2c, &*boards(bench))], prescale))
}

/// A driver with the converters of a bench's boards, where there are any.
#[must_use]
pub fn with_converters<I: I2c>(bench: &Bench, banks: Banks<I>) -> Banks<I> {
    match &bench.dac {
        Some(dac) => banks.with_converters(&dac.addresses, milliamps(bench.drive.current_ma)),
        None => banks,
    }
}

/// Converters of a bench's boards, as a driver unit is told of them.
pub fn converters(bench: &Bench) -> Option<Converters<'_>> {
    let addresses = bench.dac.as_ref().map(|dac| &*dac.addresses)?;
    control(bench).map(|control| Converters { addresses, control })
}
