//! States of the pins: OE x OUTNE x OUTDRV x INVRT (data sheet 7.4, table 6).

use palpate_core::codec::pca9685::mode2;
use palpate_core::units::Channel;

use crate::time::Nanos;

/// The state of an output pin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pin {
    /// Driven low.
    #[default]
    Low,
    /// Driven high (totem pole only).
    High,
    /// An undriven pin: the level is that of the pull resistor on the board.
    HighZ,
}

/// A change of an output pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Time of the change.
    pub at: Nanos,
    /// Output that changes.
    pub channel: Channel,
    /// The state from then on.
    pub pin: Pin,
}

/// The state of a pin whose channel's logic stands at `on` (data sheet 7.4).
///
/// OE low: the logic level, inverted by INVRT, through a totem pole or an open drain. OE high: OUTNE
/// decides and INVRT does not count.
pub fn pin(on: bool, mode2: u8, oe_high: bool) -> Pin {
    let totem_pole = mode2 & mode2::OUTDRV != 0;
    let high = if totem_pole { Pin::High } else { Pin::HighZ };
    if oe_high {
        return match mode2 & mode2::OUTNE {
            0 => Pin::Low,
            1 => high,
            _ => Pin::HighZ,
        };
    }
    if on != (mode2 & mode2::INVRT != 0) {
        high
    } else {
        Pin::Low
    }
}

/// Tells whether switching the outputs "off" with OE would drive every wire at once: OUTNE = 01, totem pole.
pub(super) fn oe_drives_all(mode2: u8) -> bool {
    mode2 & mode2::OUTNE == 1 && mode2 & mode2::OUTDRV != 0
}

/// Something a chip did as told and should not have been told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Hazard {
    /// OE went high with OUTNE = 01 and totem pole: every wire is driven (data sheet 7.4).
    OutputEnableDrivesAll,
    /// RESTART was written with 1 before SLEEP had been clear for 500 us; ignored (data sheet 7.3.1.1).
    RestartTooEarly,
    /// The TESTMODE register was written: unpredictable on silicon, ignored here (data sheet table 4).
    TestRegisterWritten,
}
