//! Place of a channel's pulse in the PWM period.

use crate::units::{Channel, Ticks};

/// ON and OFF ticks of a pulse of `width` on `channel`: wires start staggered by 256 ticks, so that
/// eight wires of 100 ticks never draw current together, and no pulse wraps the period (a wrapping
/// pulse costs a blank period at each update of the chip). A pulse too wide for its place starts
/// earlier.
pub const fn stagger(channel: Channel, width: Ticks) -> (u16, u16) {
    let slot = 256 * (channel.0 as u16 % 16);
    let latest = Ticks::PER_PERIOD - width.get();
    let on = if slot < latest { slot } else { latest };
    (on, on + width.get())
}

#[cfg(test)]
#[path = "stagger_tests.rs"]
mod tests;
