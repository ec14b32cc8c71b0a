//! Faults of haptic drivers, and places that cannot be.

use embedded_hal::i2c::{ErrorKind, NoAcknowledgeSource};

/// Reasons for which haptic drivers cannot have these places and voltages.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum HapticPlanError {
    /// Two drivers share the address without a switch between.
    #[error(
        "actuator {0}: a second DRV2605L at 0x5a without a TCA9548A; give the bus a switch and each driver a channel"
    )]
    NoSwitch(u8),
    /// A channel that the switch lacks, or an address that no switch has.
    #[error(
        "actuator {0}: channel {1} of the switch at {2:#04x} does not exist, expected 0 to 7 at 0x70 to 0x77"
    )]
    NoChannel(u8, u8, u8),
    /// Two drivers on one channel of the switch.
    #[error(
        "actuator {0}: channel {1} of the switch at {2:#04x} is used twice; give each driver a channel of its own"
    )]
    ChannelTwice(u8, u8, u8),
    /// More drivers than an update has channels.
    #[error("{0} actuators, expected at most 16 on one finger")]
    TooMany(usize),
    /// A voltage without a code.
    #[error("actuator {0}: a {1} voltage of {2} V, expected more than zero and at most {3:.2} V")]
    Voltage(u8, &'static str, f64, f64),
    /// A resonance that the drive time cannot follow.
    #[error("actuator {0}: a resonance of {1} Hz, expected 125 to 300 Hz")]
    Resonance(u8, f64),
}

/// Fault of a haptic driver, with its actuator's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HapticFault {
    /// No actuator has this number.
    #[error("actuator {0}: not one of this bench's actuators")]
    NoSuchActuator(u8),
    /// The bus reported this while talking to an actuator's driver or switch.
    #[error("actuator {0}: I2C {1:?} from the {2}{hint}", hint = hint(*.1))]
    Bus(u8, ErrorKind, &'static str),
    /// The switch does not hold the channels that were written: written, read.
    #[error(
        "actuator {0}: the switch reads channels {2:#04x}, expected {1:#04x}: it is stuck; pull its RESET pin low or switch it off and on"
    )]
    Stuck(u8, u8, u8),
    /// The driver of another actuator answers: its number.
    #[error(
        "actuator {0}: the driver of actuator {1} answers; the switch is stuck: pull its RESET pin low or switch it off and on"
    )]
    Elsewhere(u8, u8),
    /// A driver answers while no channel of the switch is connected.
    #[error(
        "actuator {0}: a driver answers while every channel of the switch is closed: it sits beside the switch, or the switch is stuck; move it behind its channel, or pull the switch's RESET pin low"
    )]
    Beside(u8),
    /// The device number is another chip's: read.
    #[error(
        "actuator {0}: device number {1}, expected 7 of a DRV2605L; check which chip is on this channel"
    )]
    Device(u8, u8),
    /// A register does not read back what was written: register, expected, found.
    #[error(
        "actuator {0}: register {1:#04x} reads {3:#04x}, expected {2:#04x}: brown-out, or another program on the bus"
    )]
    Readback(u8, u8, u8, u8),
    /// A calibration failed.
    #[error(
        "actuator {0}: the calibration failed; check that the actuator is connected, free to move and of the stated kind and voltage"
    )]
    Calibration(u8),
    /// A calibration did not end.
    #[error("actuator {0}: the calibration did not end within 1.5 s; switch the driver off and on")]
    Endless(u8),
    /// The chip was too hot since the last look.
    #[error(
        "actuator {0}: its driver is over temperature; switch off and let it cool, then check for a shorted actuator"
    )]
    OverTemperature(u8),
    /// The output was overloaded since the last look.
    #[error(
        "actuator {0}: its driver reports an overcurrent; check for a shorted actuator or cable"
    )]
    OverCurrent(u8),
}

impl HapticFault {
    /// Tells whether the same call may succeed if made again.
    pub const fn is_transient(&self) -> bool {
        matches!(
            self,
            Self::Bus(
                _,
                ErrorKind::ArbitrationLoss | ErrorKind::Bus | ErrorKind::Overrun,
                _
            )
        )
    }
}

/// The end of the message about a bus that failed: where to look.
const fn hint(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::NoAcknowledge(NoAcknowledgeSource::Address) => {
            ": no chip answers at its address; check wiring, power, the EN pin and the address straps"
        }
        ErrorKind::ArbitrationLoss => ": another master is on this bus",
        _ => "",
    }
}
