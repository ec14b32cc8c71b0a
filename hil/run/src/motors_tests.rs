//! Motors from a bench file to emulated chips: the driver of core over the emulated bus, and whole runs.

use embedded_hal::delay::DelayNs;
use palpate_core::driver::HapticChannel;

use super::*;
use crate::{Input, run};

/// A setup on a bench of motors, and its motors.
fn lra_8() -> (Setup, BenchHaptics) {
    let setup = Setup::load("sphere-along", "lra-8").unwrap();
    let haptics = setup.bench.value.haptics.clone().unwrap();
    (setup, haptics)
}

/// Motors at rest on the bus of a bench, with their drivers, which are awake.
fn worn() -> (WornMotors, Haptics<I2cHandle>, Vec<HapticChannel>) {
    let (setup, haptics) = lra_8();
    let (motor, contact) = (motors::motor(&haptics), motors::contact(&haptics));
    let worn = WornMotors::new(&motor, contact, &motors::places(&setup, &haptics));
    let channels = motors::channels(&haptics);
    worn.bus().delay_ms(1);
    let driver = Haptics::new(worn.bus(), &channels).unwrap();
    (worn, driver, channels)
}

#[test]
fn the_stored_calibration_is_the_one_that_every_chip_finds() {
    let (worn, mut driver, channels) = worn();
    for (number, channel) in (0..).zip(&channels) {
        let found = driver.calibrate(number, &mut worn.bus()).unwrap();
        assert_eq!(found, channel.calibration, "actuator {number}");
    }
}
