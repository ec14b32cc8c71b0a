//! Benches: which hardware a scene runs on, and what drives its wires.

use std::path::PathBuf;

use serde::Deserialize;

use super::{FileError, Source};

/// A bench.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Bench {
    /// Lower case with hyphens.
    pub name: String,
    /// What it is, in a sentence.
    pub description: String,
    /// What stands behind the buses.
    pub kind: BenchKind,
    /// The buses of a real bench.
    pub real: Option<Real>,
    /// A display layout: a built-in name or a file.
    pub display: String,
    /// A limit table: a built-in name or a file. Left out: the hard limits.
    pub limits: Option<String>,
    /// The display's wires.
    pub wire: Wire,
    /// What drives them.
    pub drive: Drive,
    /// What turns the chip's pulses into current; left out: instant, without loss, and never short of voltage.
    #[serde(default)]
    pub amplifier: Amplifier,
    /// One entry a wire, in the display's order.
    pub outputs: Vec<Output>,
}

/// What stands behind the buses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum BenchKind {
    /// Emulated boards, chips, wires and finger. Such a bench never opens a device.
    Emulated,
    /// Devices of this computer: CAN interfaces, I2C adapters, and people's skin.
    Real,
}

/// The buses of a real bench, and how it is watched.
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
    /// Somebody or something touches the skin as the scenes say: `hil test` then runs scenes with touches.
    #[serde(default)]
    pub touch: bool,
    /// Real-time priority and locked memory: true insists, false does without. Left out: where allowed.
    pub realtime: Option<bool>,
    /// The guardian switches off when it has not heard from the loop for this long.
    #[serde(default = "heartbeat_ms")]
    pub heartbeat_ms: u32,
    /// A transfer that takes longer than this has failed: a backstop for adapters that know no limit of
    /// their own.
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
    60
}

const fn transfer_ms() -> u32 {
    500
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

/// A wire and what it is made of.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Wire {
    /// A wire: a built-in name or a file.
    pub kind: String,
    /// An alloy: a built-in name or a file.
    pub alloy: String,
}

/// Current, supply and PWM.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Current through a wire that is on.
    pub current_ma: f64,
    /// Most current the supply gives at any instant.
    pub supply_limit_ma: f64,
    /// Frequency asked for; the chip's divider makes the nearest it can.
    pub pwm_hz: f64,
    /// The chip's oscillator over its nominal 25 MHz.
    pub oscillator: f64,
}

/// The amplifiers and the supply that feeds them all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Amplifier {
    /// From no current to all of it and back, microseconds.
    #[serde(default)]
    pub rise_us: f64,
    /// Resistance of a transistor that is on, Ohm.
    #[serde(default)]
    pub on_ohm: f64,
    /// The supply's voltage without load; left out: it always suffices.
    pub supply_v: Option<f64>,
    /// Resistance of supply and leads: how far the voltage sags, Ohm.
    #[serde(default)]
    pub supply_ohm: f64,
}

/// Where a wire is connected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// Which of a real bench's I2C adapters the chip is on, zero-based.
    #[serde(default)]
    pub bus: u8,
    /// The chip's I2C address, 0x40 to 0x7F.
    pub board: u8,
    /// The chip's output, 0 to 15.
    pub channel: u8,
}

impl Real {
    /// Checks it; returns how many I2C adapters there are.
    fn check(&self, source: &Source) -> Result<u8, FileError> {
        // One board listens on each address of a bus, and a bench has at most 16.
        let adapters = u8::try_from(self.i2c.len()).unwrap_or(u8::MAX);
        source.range("real.i2c", adapters, 1..=16, "adapters")?;
        let interfaces = u8::try_from(self.can.len()).unwrap_or(u8::MAX);
        source.range("real.can", interfaces, 1..=16, "interfaces")?;
        source.range("real.heartbeat_ms", self.heartbeat_ms, 10..=1000, "ms")?;
        source.range("real.transfer_ms", self.transfer_ms, 1..=10_000, "ms")?;
        Ok(adapters)
    }
}

impl Bench {
    /// Reads and checks a bench by itself; [`crate::Setup`] checks it against its display.
    ///
    /// # Errors
    /// Names the line and key of what cannot be.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let bench: Self = source.read()?;
        source.heading(&bench.name, &bench.description)?;
        let drive = &bench.drive;
        source.range("drive.current_ma", drive.current_ma, 1.0..=5000.0, "mA")?;
        source.range(
            "drive.supply_limit_ma",
            drive.supply_limit_ma,
            1.0..=1e5,
            "mA",
        )?;
        if drive.supply_limit_ma < drive.current_ma {
            let expected = format!("at least the current of one wire, {} mA", drive.current_ma);
            return Err(source.bad("drive.supply_limit_ma", expected));
        }
        // What dividers 3 to 255 make of 25 MHz.
        source.range("drive.pwm_hz", drive.pwm_hz, 24.0..=1526.0, "Hz")?;
        source.range("drive.oscillator", drive.oscillator, 0.8..=1.2, "")?;
        let adapters = match (bench.kind, &bench.real) {
            (BenchKind::Emulated, None) => 1,
            (BenchKind::Emulated, Some(_)) => {
                return Err(source.bad("real", "nothing: this bench is of kind \"emulated\""));
            }
            (BenchKind::Real, None) => {
                return Err(source.bad("kind", "a [real] table that names the buses"));
            }
            (BenchKind::Real, Some(real)) => real.check(source)?,
        };
        let amplifier = &bench.amplifier;
        source.range("amplifier.rise_us", amplifier.rise_us, 0.0..=100.0, "us")?;
        source.range("amplifier.on_ohm", amplifier.on_ohm, 0.0..=100.0, "Ohm")?;
        if let Some(volts) = amplifier.supply_v {
            source.range("amplifier.supply_v", volts, 0.1..=60.0, "V")?;
        }
        let ohm = amplifier.supply_ohm;
        source.range("amplifier.supply_ohm", ohm, 0.0..=100.0, "Ohm")?;
        for (index, output) in bench.outputs.iter().enumerate() {
            let key = format!("outputs[{index}]");
            let last = adapters - 1;
            source.range(&format!("{key}.bus"), output.bus, 0..=last, "")?;
            source.range(
                &format!("{key}.board"),
                output.board,
                0x40..=0x7F,
                "(0x40 to 0x7F)",
            )?;
            source.range(&format!("{key}.channel"), output.channel, 0..=15, "")?;
            if bench.outputs[..index].contains(output) {
                return Err(source.bad(
                    &format!("{key}.channel"),
                    "an output of its own for every wire",
                ));
            }
        }
        Ok(bench)
    }
}
