//! Settings burnt into this unit: two fingertips of eight wires, and a Peltier module.

use palpate_core::guard::{HARD, Limits, Plant};
use palpate_core::illusion::DisplayWire;
use palpate_core::peltier::Regulator;
use palpate_core::physics::{PeltierParameters, Thermistor};
use palpate_core::units::Milliamps;
use palpate_image::{burnt_key, fingertips};
use palpate_unit::Settings;

/// The key.
static KEY: [u8; 32] = burnt_key!();
/// The wires.
static WIRES: [DisplayWire; 16] = fingertips(8);
/// 7-bit addresses of the boards.
const ADDRESSES: [u8; 2] = [0x40, 0x41];
/// Limits: a supply of 3 A, else the hard ones.
const LIMITS: Limits = Limits {
    supply: Milliamps(3000),
    ..HARD
};

/// `true` where a Peltier module is wired.
const MODULE: bool = true;

/// Regulator of the module, if there is one: 10 kOhm thermistors, B 3950 K, under 10 kOhm.
pub fn regulator() -> Option<Regulator> {
    MODULE.then(|| Regulator::new(PeltierParameters::default(), Thermistor::default()))
}

/// The unit's settings; `boot` is a number that no start had before.
pub fn settings(boot: u64) -> Settings<'static> {
    Settings {
        key: &KEY,
        boot,
        wires: &WIRES,
        addresses: &ADDRESSES,
        limits: LIMITS,
        plant: Plant::default(),
        // Software doubles would take 11 ms per stimulus.
        worn: None,
        converters: None,
    }
}
