//! The display end: I2C segment, PWM chips, converters, amplifiers, supply, wires and the finger that they warm.

pub mod amplifier;
pub mod dac7578;
pub mod finger;
pub mod i2c;
pub mod observed;
pub mod pca9685;
pub mod peltier;
pub mod solver;
pub mod wire;

#[cfg(test)]
mod tests;
