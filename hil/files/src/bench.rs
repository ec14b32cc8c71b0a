//! Benches: the hardware that a scene runs on, and the drive of its wires.

mod audio;
mod dac;
mod displays;
mod haptics;
mod heat;
mod unit;

use std::path::{Path, PathBuf};

use palpate_core::units::{Clock, Duration};
use serde::Deserialize;

use super::address::{check_chip, check_once};
use super::error::FileError;
use super::layout::DisplayLayout;
use super::mount::{BenchMount, BenchTissue};
use super::settings::{bounds, settings};
use super::source::Source;
use super::warmth::SKIN_C;
pub use audio::BenchAudio;
pub use dac::BenchDac;
pub use displays::BenchDisplay;
pub use haptics::{BenchHaptics, HapticDriver, MotorKind};
pub use heat::BenchHeat;
pub use unit::{BenchUnit, Network};

settings! {
    /// A bench. A file states what differs from [`Bench::default`], and its name and description.
    #[cfg_attr(test, schemars(extend("required" = ["name", "description"])))]
    pub struct Bench {
        /// Name, in lower case with hyphens.
        pub name: String,
        /// The bench, in a sentence.
        pub description: String,
        /// The kind of thing behind the buses.
        pub kind: BenchKind = BenchKind::Emulated,
        /// The buses of a real bench.
        pub real: Option<Real>,
        /// A display layout: a built-in name or a file. A real bench states it.
        pub display: String = "thimble-8".into(),
        /// A limit table: a built-in name or a file; `default` has the hard limits.
        pub limits: String = "default".into(),
        /// The display's wires. A real bench states them.
        pub wire: BenchWire,
        /// The seat of the wires on the finger: the part of their motion that reaches it.
        pub mount: BenchMount,
        /// The finger under them.
        pub tissue: BenchTissue,
        /// The pulses and current that drive them.
        pub drive: Drive,
        /// The amplifiers that turn the chip's pulses into current; left out: instant, without loss, and never short
        /// of voltage.
        pub amplifier: Amplifier,
        /// Converters that set the amplifiers' current; left out: it is fixed.
        pub dac: Option<BenchDac>,
        /// One entry per wire, in the display's order; left out: the outputs of one chip after the other, from 0x40 on.
        /// A real bench states them.
        pub outputs: Vec<Output>,
        /// Several displays, a fingertip each, in place of one.
        pub displays: Vec<BenchDisplay>,
        /// A driver unit that has the chips, behind a network; left out: they hang on the host's own bus. Benches of one
        /// display only.
        pub unit: Option<BenchUnit>,
        /// A Peltier module under the fingertip; left out: none.
        pub heat: Option<BenchHeat>,
        /// Vibration motors in place of wires; left out: the display has wires.
        pub haptics: Option<BenchHaptics>,
        /// Level and error over all that is not measured, from `hil calibrate`: a built-in name or a file; left out: not
        /// computed.
        pub band: Option<String>,
    }

    /// The emulated thimble, without a name. Its current is below the published drive, so that a contact that keeps
    /// moving meets no limit.
    default
}

/// Keys that a real bench must state: assumed values would make the guard's model of it wrong.
const HARDWARE: [&str; 4] = [
    "wire.kind",
    "wire.alloy",
    "drive.current_ma",
    "drive.supply_limit_ma",
];
/// Keys that a real bench of one display must state. Of several displays each states its own.
const DISPLAY: [&str; 2] = ["display", "outputs"];

/// Expectation where a real bench leaves them out.
const STATED: &str = "a value: no default stands for a real bench's hardware";

/// Kinds of things behind the buses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema, serde::Serialize))]
#[serde(rename_all = "kebab-case")]
pub enum BenchKind {
    /// Emulated boards, chips, wires and finger. Such a bench never opens a device.
    Emulated,
    /// Devices of this computer: CAN interfaces, I2C adapters, and people's skin.
    Real,
}

/// The buses of a real bench, and the watch over it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Real {
    /// CAN interfaces, in the order of the layout's bus numbers.
    pub can: Vec<String>,
    /// I2C adapters, in the order of the outputs' bus numbers.
    pub i2c: Vec<PathBuf>,
    /// The line that cuts all outputs, if one is wired.
    pub oe: Option<OutputEnable>,
    /// True if a person or a machine touches the skin as the scenes state: `hil test` then runs scenes with touches.
    #[serde(default)]
    pub touch: bool,
    /// Real-time priority and locked memory: true insists, false does without. Left out: where allowed.
    pub realtime: Option<bool>,
    /// Silence of the loop after which the guardian switches off, milliseconds. A burst must still be within its
    /// limit then.
    #[serde(default = "heartbeat_ms")]
    pub heartbeat_ms: u32,
    /// Longest time of a transfer, milliseconds; one that takes longer has failed. It is a backstop for adapters
    /// without a limit of their own. A burst must still be within its limit then.
    #[serde(default = "transfer_ms")]
    pub transfer_ms: u32,
}

/// A GPIO line on the chips' OE pins. High cuts the outputs.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OutputEnable {
    /// The GPIO chip's device.
    pub chip: PathBuf,
    /// The line's offset on that chip.
    pub line: u32,
}

const fn heartbeat_ms() -> u32 {
    30
}

const fn transfer_ms() -> u32 {
    30
}

impl Real {
    /// A bench of these buses and nothing else.
    pub fn new(can: Vec<String>, i2c: Vec<PathBuf>) -> Self {
        Self {
            can,
            i2c,
            oe: None,
            touch: false,
            realtime: None,
            heartbeat_ms: heartbeat_ms(),
            transfer_ms: transfer_ms(),
        }
    }
}

settings! {
    /// A wire and its alloy.
    #[derive(Eq)]
    pub struct BenchWire {
        /// A wire: a built-in name or a file.
        pub kind: String = "final-75um".into(),
        /// An alloy: a built-in name or a file.
        pub alloy: String = "low".into(),
    }
}

settings! {
    /// Current, supply and PWM.
    #[derive(Copy)]
    pub struct Drive {
        /// Current through a wire that is on, mA; with `[dac]` the most that it can be set to. A real bench states
        /// it.
        pub current_ma: f64 = 990.0,
        /// Most current of the supply at any instant, mA. A real bench states it.
        pub supply_limit_ma: f64 = 4000.0, // at 1.97 A two wires may overlap, three may not
        /// Frequency asked for; the chip's divider makes the nearest it can, 196.89 Hz for 200. Left out: 200, but with the
        /// illusion `inverse` and no texture, which choose their own.
        pub pwm_hz: Option<f64>,
        /// Time between onsets in milliseconds where the illusion is `inverse` and a scene states none; left out:
        /// 117.
        pub soa_ms: Option<f64>,
        /// A hot pass of wires that begin `cold`, before the scene: each is heated once until it is austenite.
        pub hot_pass: bool = true,
        /// Speed of the clock that counts, over its nominal frequency: the chip's oscillator, or `clock`. Emulated
        /// benches only.
        pub oscillator: f64 = 1.0,
        /// A clock on the chips' EXTCLK pins; left out: each chip counts by its own oscillator of about 25 MHz.
        pub clock: Option<ExternalClock>,
    }
}

/// A clock on the EXTCLK pin of every chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ExternalClock {
    /// Nominal frequency, Hz.
    pub hz: u32,
    /// Largest deviation from that at any time, parts per million.
    pub tolerance_ppm: u32,
}

/// The amplifiers and the supply that feeds them all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Amplifier {
    /// Time from no current to all of it and back, microseconds.
    pub rise_us: f64,
    /// Resistance of a transistor that is on, Ohm.
    pub on_ohm: f64,
    /// Voltage of the supply without load, V; left out: it always suffices.
    pub supply_v: Option<f64>,
    /// Resistance of supply and leads, by which the voltage sags, Ohm.
    pub supply_ohm: f64,
}

/// Connection of a wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// The I2C adapter of a real bench that the chip is on, zero-based.
    #[serde(default)]
    pub bus: u8,
    /// The chip's I2C address, 0x40 to 0x77 without 0x70, 0x71, 0x72 and 0x74, which several chips may answer.
    pub board: u8,
    /// The chip's output, 0 to 15.
    pub channel: u8,
}

impl Output {
    /// Connection of wire `index` if the file states none: chips of sixteen outputs, one after the other.
    const fn nth(index: usize) -> Self {
        Self {
            bus: 0,
            board: 0x40 + (index / 16) as u8, // a display has at most 256 wires
            channel: (index % 16) as u8,
        }
    }
}

impl Drive {
    /// Time between onsets where a scene states none, in the core's unit.
    pub fn soa(&self) -> Option<Duration> {
        let us = |ms: f64| Duration::from_micros((ms * 1e3).round() as u64);
        self.soa_ms.map(us)
    }

    /// The clock on an emulated bench's EXTCLK pins as it truly runs, Hz; 0 for none.
    pub fn external_hz(&self) -> u32 {
        let hz = self.clock.map_or(0, |clock| clock.hz);
        (f64::from(hz) * self.oscillator).round() as u32
    }

    fn check(&self, source: &Source) -> Result<(), FileError> {
        bounds!(source, "drive", self;
            current_ma: 1.0..=5000.0, "mA";
            supply_limit_ma: 1.0..=1e5, "mA")?;
        if self.supply_limit_ma < self.current_ma {
            let expected = format!("at least the current of one wire, {} mA", self.current_ma);
            return Err(source.bad("drive.supply_limit_ma", expected));
        }
        bounds!(source, "drive", self; soa_ms: 1.0..=10_000.0, "ms")?;
        let Some(clock) = self.clock else {
            return bounds!(source, "drive", self;
                // These are the frequencies that dividers 3 to 255 make of 25 MHz.
                pwm_hz: 24.0..=1526.0, "Hz";
                oscillator: 0.8..=1.2);
        };
        bounds!(source, "drive.clock", clock;
            hz: 100_000..=Clock::MOST_HZ, "Hz";
            tolerance_ppm: 0..=Clock::MOST_PPM, "ppm")?;
        let divided = |by: f64| f64::from(clock.hz) / 4096.0 / by;
        // With a clock other than the bench states, the guard would count too few pulses.
        let off = f64::from(clock.tolerance_ppm) * 1e-6;
        bounds!(source, "drive", self;
            pwm_hz: divided(256.0)..=divided(4.0), "Hz";
            oscillator: 1.0 - off..=1.0 + off)
    }
}

impl Real {
    /// Checks the bench; returns the number of its I2C adapters.
    fn check(&self, source: &Source, unit: bool) -> Result<u8, FileError> {
        // One board listens on each address of a bus, and a bench has at most 16.
        let adapters = u8::try_from(self.i2c.len()).unwrap_or(u8::MAX);
        match unit {
            true => source.range("real.i2c", &adapters, 0..=0, "adapters: the unit has them")?,
            false => source.range("real.i2c", &adapters, 1..=16, "adapters")?,
        }
        let interfaces = u8::try_from(self.can.len()).unwrap_or(u8::MAX);
        source.range("real.can", &interfaces, 1..=16, "interfaces")?;
        check_once(source, "real.i2c", self.i2c.iter().map(PathBuf::as_path))?;
        check_once(source, "real.can", self.can.iter().map(Path::new))?;
        bounds!(source, "real", self;
            heartbeat_ms: 5..=1000, "ms";
            transfer_ms: 1..=10_000, "ms")?;
        Ok(adapters.max(1))
    }
}

impl Bench {
    /// Reads and checks a bench by itself; [`crate::Setup`] checks it against its display.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let mut bench: Self = source.read()?;
        source.heading(&bench.name, &bench.description)?;
        bench.drive.check(source)?;
        let adapters = bench.adapters(source)?;
        bounds!(source, "amplifier", bench.amplifier;
            rise_us: 0.0..=100.0, "us";
            on_ohm: 0.0..=100.0, "Ohm";
            supply_v: 0.1..=60.0, "V";
            supply_ohm: 0.0..=100.0, "Ohm")?;
        bounds!(source, "mount", bench.mount;
            sag_um: 1.0..=10_000.0, "um";
            preload_mn: 0.0..=100.0, "mN";
            compliance_um_per_mn: 0.0..=1000.0, "um/mN")?;
        bench.tissue.check(source)?;
        bench.check_unit(source)?;
        bench.check_heat(source)?;
        bench.check_outputs(source, adapters)?;
        bench.join_displays(source, adapters)?;
        if bench.outputs.is_empty() {
            let (display, _) = DisplayLayout::named(&bench.display, source, "display")?;
            bench.outputs = (0..display.wires_mm.len()).map(Output::nth).collect();
        }
        bench.check_haptics(source, bench.outputs.len())?;
        bench.check_dac(source)?;
        Ok(bench)
    }

    /// Address at which the driver unit listens, if that is not emulated.
    #[must_use]
    pub fn unit_address(&self) -> Option<&str> {
        self.unit.as_ref()?.address.as_deref()
    }

    /// Returns true if any part is hardware, or may be: devices of this computer, or a driver unit on a network.
    #[must_use]
    pub fn is_hardware(&self) -> bool {
        self.kind == BenchKind::Real || self.unit_address().is_some()
    }

    fn check_unit(&self, source: &Source) -> Result<(), FileError> {
        let Some(unit) = &self.unit else {
            return Ok(());
        };
        if self.kind == BenchKind::Real && unit.address.is_none() {
            let expected =
                "the address of a unit: this bench is of kind \"real\", and emulates none";
            return Err(source.bad("unit.address", expected));
        }
        if !self.displays.is_empty() {
            return Err(source.bad("unit", "one display: a unit has a guard of one fingertip"));
        }
        unit.check(source)
    }

    fn check_heat(&self, source: &Source) -> Result<(), FileError> {
        let Some(heat) = &self.heat else {
            return Ok(());
        };
        let without = match (self.kind, &self.unit, self.displays.as_slice()) {
            (BenchKind::Real, None, _) => {
                "an emulated bench, or a driver unit: this program drives no bridge"
            }
            (.., [_, ..]) => "one display: a module warms one fingertip",
            _ => {
                heat.check(source)?;
                if self.tissue.rest_c == SKIN_C && self.tissue.guarded_c() == SKIN_C {
                    return Ok(());
                }
                let key = match self.tissue.rest_c == SKIN_C {
                    true => "tissue.warmest_c",
                    false => "tissue.rest_c",
                };
                let expected =
                    format!("{SKIN_C} with [heat]: the module is modelled on such a finger");
                return Err(source.bad(key, expected));
            }
        };
        Err(source.bad("heat", without))
    }

    /// Counts the I2C adapters, and checks that the kind of bench has what it needs.
    fn adapters(&self, source: &Source) -> Result<u8, FileError> {
        match (self.kind, &self.real) {
            (BenchKind::Emulated, None) => Ok(1),
            (BenchKind::Emulated, Some(_)) => {
                Err(source.bad("real", "nothing: this bench is of kind \"emulated\""))
            }
            (BenchKind::Real, None) => {
                Err(source.bad("kind", "a [real] table that names the buses"))
            }
            (BenchKind::Real, Some(real)) => {
                let (wires, display) = match (&self.haptics, self.displays.is_empty()) {
                    // Motors have drivers in place of outputs, and `check_haptics` asks for theirs.
                    (Some(_), _) => (&HARDWARE[..0], &DISPLAY[..1]),
                    (None, true) => (&HARDWARE[..], &DISPLAY[..]),
                    (None, false) => (&HARDWARE[..], &DISPLAY[..0]),
                };
                let mut needed = wires.iter().chain(display);
                let missing = needed.find(|key| !source.states(key));
                let unit = self.unit.is_some();
                missing.map_or_else(
                    || real.check(source, unit),
                    |key| Err(source.bad(key, STATED)),
                )
            }
        }
    }

    fn check_outputs(&self, source: &Source, adapters: u8) -> Result<(), FileError> {
        for (index, output) in self.outputs.iter().enumerate() {
            let at = |key: &str| format!("outputs[{index}].{key}");
            source.range(&at("bus"), &output.bus, 0..=adapters - 1, "")?;
            check_chip(source, &at("board"), output.board)?;
            source.range(&at("channel"), &output.channel, 0..=15, "")?;
            if let Some(wire) = self.outputs[..index].iter().position(|o| o == output) {
                let expected =
                    format!("an output of its own: wire {wire} has this channel of this board");
                return Err(source.bad(&at("channel"), expected));
            }
        }
        Ok(())
    }
}
