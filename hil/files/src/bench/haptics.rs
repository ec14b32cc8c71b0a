//! A bench's `[haptics]`: vibration motors behind DRV2605L drivers, or voice coils on a sound card, in place of wires.

use std::ops::RangeInclusive;

use palpate_core::codec::tca9548a::{ADDRESSES, CHANNELS};
use serde::Deserialize;

use super::{Bench, BenchAudio, Real, STATED};
use crate::bench::BenchKind;
use crate::error::FileError;
use crate::settings::{bounds, settings};
use crate::source::Source;

palpate_core::listed! {
    /// Kinds of motors.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
    #[cfg_attr(test, derive(schemars::JsonSchema, serde::Serialize))]
    #[serde(rename_all = "kebab-case")]
    pub enum MotorKind: name {
        /// A linear resonant actuator.
        Lra = "lra",
        /// An eccentric rotating mass.
        Erm = "erm",
        /// A voice coil on a channel of a sound card.
        VoiceCoil = "voice-coil",
    }
}

/// The place of one driver behind a multiplexer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct HapticDriver {
    /// Address of its TCA9548A, 0x70 to 0x77; left out: the driver is alone on the bus.
    pub switch: Option<u8>,
    /// Channel of that switch, 0 to 7.
    #[serde(default)]
    pub channel: u8,
}

settings! {
    /// Equal vibration motors, each behind a DRV2605L or on a channel of a sound card, in place of wires. Benches of one display.
    /// A real bench states its motors. Left out: the display has wires.
    pub struct BenchHaptics {
        /// Kind of the motors.
        pub kind: MotorKind = MotorKind::Lra,
        /// Rated voltage: V RMS of a resonant actuator, V of a rotating motor.
        pub rated_v: f64 = 1.8,
        /// Voltage of the highest level, as `rated_v` and at most that: the strongest that is to be felt.
        pub full_v: f64 = 0.3,
        /// Largest voltage while a motor starts or brakes, V peak.
        pub overdrive_v: f64 = 2.7,
        /// Longest time of it at either end of a burst, ms.
        pub overdrive_ms: f64 = 25.0,
        /// Resonance, Hz.
        pub resonance_hz: f64 = 235.0,
        /// Moving mass, g.
        pub moving_g: f64 = 0.5,
        /// Mass of the case without it, g.
        pub case_g: f64 = 0.7,
        /// Quality of the resonance with an open coil.
        pub quality: f64 = 20.0,
        /// Force per current, N/A, and back-EMF per speed, V s/m.
        pub force_n_a: f64 = 0.3,
        /// Resistance of the coil, Ohm.
        pub ohm: f64 = 25.0,
        /// Diameter of the face on the skin, mm.
        pub face_mm: f64 = 8.0,
        /// Stiffness of the skin under it, N/m.
        pub skin_n_m: f64 = 1000.0,
        /// Damping of the skin under it, N s/m.
        pub skin_ns_m: f64 = 1.0,
        /// Largest amplitude of the face, um.
        pub travel_um: f64 = 300.0,
        /// Largest rise of the coil, K.
        pub coil_rise_k: f64 = 15.0,
        /// Longest burst, ms.
        pub burst_ms: f64 = 500.0,
        /// Largest part of ten seconds for which a motor may be on, 0 to 1.
        pub duty: f64 = 0.8,
        /// Results of the drivers' calibration: losses, back-EMF and its gain.
        pub calibration: [u8; 3] = [232, 166, 3],
        /// One entry per motor, in the display's order; left out: the channels of one switch after the other, from 0x70 on.
        pub drivers: Vec<HapticDriver>,
        /// The sound card of voice coils, in place of the keys of drivers: `drivers`, `calibration`, `overdrive_v` and
        /// `overdrive_ms`.
        pub audio: Option<BenchAudio>,
    }

    /// Coins of 8 mm: every figure is assumed, of the size that data sheets of such coins state.
    default
}

/// Keys that a real bench of motors must state: assumed values would make the guard's model of them wrong.
const MOTORS: [&str; 9] = [
    "haptics.kind",
    "haptics.rated_v",
    "haptics.full_v",
    "haptics.overdrive_v",
    "haptics.resonance_hz",
    "haptics.ohm",
    "haptics.travel_um",
    "haptics.calibration",
    "haptics.drivers",
];

/// Most motors of one finger.
const MOST: usize = 16;

impl BenchHaptics {
    fn check(&self, source: &Source) -> Result<(), FileError> {
        bounds!(source, "haptics", self;
            rated_v: 0.1..=5.0, "V";
            full_v: 0.05..=self.rated_v, "V";
            overdrive_v: 0.1..=5.4, "V";
            overdrive_ms: 1.0..=100.0, "ms";
            resonance_hz: self.resonances(), "Hz";
            moving_g: 0.01..=100.0, "g";
            case_g: 0.01..=100.0, "g";
            quality: 1.0..=200.0;
            force_n_a: 0.01..=10.0, "N/A";
            ohm: 1.0..=1000.0, "Ohm";
            face_mm: 1.0..=50.0, "mm";
            skin_n_m: 10.0..=1e5, "N/m";
            skin_ns_m: 0.01..=100.0, "N s/m";
            travel_um: 1.0..=2000.0, "um";
            coil_rise_k: 0.1..=60.0, "K";
            burst_ms: 10.0..=10_000.0, "ms";
            duty: 0.01..=1.0)?;
        source.range("haptics.drivers", &self.drivers.len(), 1..=MOST, "drivers")
    }

    /// Resonances that what drives the motors can have, Hz: a DRV2605L tracks no others.
    const fn resonances(&self) -> RangeInclusive<f64> {
        match self.kind {
            MotorKind::VoiceCoil => 10.0..=1000.0,
            MotorKind::Lra | MotorKind::Erm => 125.0..=300.0,
        }
    }

    /// Checks that nothing of DRV2605L drivers stands beside a sound card, and no card beside drivers.
    fn check_plants(&mut self, source: &Source, actuators: usize) -> Result<(), FileError> {
        if self.kind != MotorKind::VoiceCoil {
            return match self.audio {
                None => Ok(()),
                Some(_) => {
                    let expected = "no sound card beside DRV2605L drivers: a finger has actuators of one kind; `kind = \"voice-coil\"` has one";
                    Err(source.bad("haptics.audio", expected))
                }
            };
        }
        for key in ["drivers", "calibration", "overdrive_v", "overdrive_ms"] {
            let key = format!("haptics.{key}");
            if source.states(&key) {
                let expected = "nothing of DRV2605L drivers beside voice coils, which are on a sound card: [haptics.audio]";
                return Err(source.bad(&key, expected));
            }
        }
        let full_v = self.full_v;
        self.audio
            .get_or_insert_default()
            .check(source, actuators, full_v)
    }

    /// Checks that motors on hardware are what this program can drive there, and that the file states what the guard counts by.
    fn check_hardware(&self, source: &Source, real: Option<&Real>) -> Result<(), FileError> {
        if self.kind == MotorKind::VoiceCoil {
            let expected = "\"lra\" or \"erm\" on a real bench: this program opens no sound card, and `--wav -` of an emulated bench feeds one";
            return Err(source.bad_found("haptics.kind", expected, "\"voice-coil\""));
        }
        if let Some(key) = MOTORS.into_iter().find(|key| !source.states(key)) {
            return Err(source.bad(key, STATED));
        }
        let real = real.map_or((0, false), |real| (real.i2c.len(), real.oe.is_some()));
        match real {
            (.., true) => Err(source.bad(
                "real.oe",
                "nothing with [haptics]: drivers of motors have no line in common",
            )),
            (1, _) => Ok(()),
            (count, _) => {
                Err(source.bad_found("real.i2c", "one adapter with [haptics]", count.to_string()))
            }
        }
    }

    /// Place of motor `index` if the file states none: eight behind each switch.
    const fn nth(index: usize) -> HapticDriver {
        HapticDriver {
            switch: Some(*ADDRESSES.start() + (index / 8) as u8), // at most two switches
            channel: (index % 8) as u8,
        }
    }

    fn check_drivers(&self, source: &Source) -> Result<(), FileError> {
        for (index, driver) in self.drivers.iter().enumerate() {
            let at = |key: &str| format!("haptics.drivers[{index}].{key}");
            let Some(switch) = driver.switch else {
                if self.drivers.len() > 1 {
                    let expected = "the address of a TCA9548A: every DRV2605L answers at 0x5a, so two need a switch and a channel each";
                    return Err(source.bad(&at("switch"), expected));
                }
                continue;
            };
            source.range(&at("switch"), &switch, ADDRESSES, "")?;
            source.range(&at("channel"), &driver.channel, 0..=CHANNELS - 1, "")?;
            let before = self.drivers[..index].iter();
            if let Some(motor) = before.clone().position(|other| other == driver) {
                let expected =
                    format!("a channel of its own: motor {motor} has this channel of this switch");
                return Err(source.bad(&at("channel"), expected));
            }
        }
        Ok(())
    }
}

impl Bench {
    /// A key by which the bench says something of wires.
    fn of_wires(&self) -> Option<&'static str> {
        let plain = Self::default();
        [
            ("wire", self.wire != plain.wire),
            ("mount", self.mount != plain.mount),
            ("drive", self.drive != plain.drive),
            ("amplifier", self.amplifier != plain.amplifier),
            ("dac", self.dac.is_some()),
            ("unit", self.unit.is_some()),
            ("heat", self.heat.is_some()),
            ("displays", !self.displays.is_empty()),
            ("band", self.band.is_some()),
        ]
        .into_iter()
        .find_map(|(key, stated)| stated.then_some(key))
    }

    /// Checks the motors of a bench of `actuators`, and that nothing of wires stands beside them.
    pub(super) fn check_haptics(
        &mut self,
        source: &Source,
        actuators: usize,
    ) -> Result<(), FileError> {
        let of_wires = self.of_wires();
        let Some(haptics) = &mut self.haptics else {
            return Ok(());
        };
        if let Some(key) = of_wires.or_else(|| source.states("outputs").then_some("outputs")) {
            let expected = "nothing beside [haptics]: a finger has actuators of one kind, and this is of wires";
            return Err(source.bad(key, expected));
        }
        if self.kind == BenchKind::Real {
            haptics.check_hardware(source, self.real.as_ref())?;
        }
        haptics.check_plants(source, actuators)?;
        if haptics.drivers.is_empty() {
            haptics.drivers = (0..actuators).map(BenchHaptics::nth).collect();
        }
        haptics.check(source)?;
        haptics.check_drivers(source)?;
        if haptics.drivers.len() == actuators {
            return Ok(());
        }
        let found = haptics.drivers.len().to_string();
        let expected = format!(
            "{actuators} drivers, one for each place of `{}`",
            self.display
        );
        Err(source.bad_found("haptics.drivers", expected, found))
    }
}
