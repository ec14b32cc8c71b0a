//! The interface of a chip to its bus.

use crate::display::dac7578::Dac7578;
use crate::display::pca9685::Pca9685;
use crate::haptic::drv2605::Drv2605;
use crate::haptic::tca9548a::Tca9548a;
use crate::time::Nanos;

/// The bus face of a chip. Every call comes at the instant of its ACK.
pub(super) trait Target {
    /// Tells whether the chip answers to a 7-bit address.
    fn answers(&self, address: u8, read: bool) -> bool;

    /// START with an address byte; returns the ACK.
    fn start(&mut self, at: Nanos, address: u8, read: bool) -> bool;

    /// A byte from the controller; returns the ACK.
    fn write(&mut self, at: Nanos, byte: u8) -> bool;

    /// A byte to the controller.
    fn read(&mut self, at: Nanos) -> u8;

    /// STOP.
    fn stop(&mut self, at: Nanos);
}

/// A chip's own methods are its face.
macro_rules! targets {
    ($($chip:ty),+) => {$(
        impl Target for $chip {
            fn answers(&self, address: u8, read: bool) -> bool {
                Self::answers(self, address, read)
            }

            fn start(&mut self, at: Nanos, address: u8, read: bool) -> bool {
                Self::start(self, at, address, read)
            }

            fn write(&mut self, at: Nanos, byte: u8) -> bool {
                Self::write(self, at, byte)
            }

            fn read(&mut self, at: Nanos) -> u8 {
                Self::read(self, at)
            }

            fn stop(&mut self, at: Nanos) {
                Self::stop(self, at);
            }
        }
    )+};
}

targets!(Pca9685, Dac7578, Drv2605, Tca9548a);
