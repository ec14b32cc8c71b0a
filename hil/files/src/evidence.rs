//! Evidence about wires and people: rows with value, unit, tolerance and source.

use serde::Deserialize;

use super::error::FileError;
use super::near::did_you_mean;
use super::quantity::Quantity;
use super::settings::bounds;
use super::source::Source;
use super::words::choice;

choice! {
    /// Sides of a value on which a quantity may lie.
    Bound {
        /// Near the value.
        Near = "near",
        /// Over the value.
        Over = "over",
        /// Under the value.
        Under = "under",
    }
}

const fn near() -> Bound {
    Bound::Near
}

const fn once() -> u32 {
    1
}

/// Bursts that the wire of a row was driven with.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct EvidenceDrive {
    /// The wire's file; left out: the bench's wire.
    pub wire: Option<String>,
    /// The wire's alloy; left out: `low`.
    pub alloy: Option<String>,
    /// Share of the resistance that is wire; left out: as drawn.
    pub wire_share: Option<f64>,
    /// Current of a pulse, mA.
    pub current_ma: f64,
    /// Pulses of a burst.
    pub pulses: u32,
    /// Width of a pulse, us.
    pub width_us: f64,
    /// Time from pulse to pulse, us.
    pub spacing_us: f64,
    /// Time from burst to burst, ms.
    pub every_ms: f64,
    /// Bursts of a visit.
    pub bursts: u32,
    /// Visits; the last one is measured.
    #[serde(default = "once")]
    pub visits: u32,
    /// Time from the end of a visit to the begin of the next one, ms.
    #[serde(default)]
    pub pause_ms: f64,
}

/// A row of evidence.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[cfg_attr(test, schemars(extend("required" = ["quantity", "value", "unit", "source"])))]
#[serde(deny_unknown_fields)]
pub struct EvidenceRow {
    /// `stroke` or `level` of driven bursts, or a quantity that has a prior.
    pub quantity: String,
    /// Value that was measured or reported.
    pub value: f64,
    /// Unit of the value.
    #[serde(default)]
    pub unit: String,
    /// Standard deviations below and above the value, in the unit.
    pub tolerance: Option<[f64; 2]>,
    /// Standard deviations below and above the value, as factors; in place of `tolerance`.
    pub factor: Option<[f64; 2]>,
    /// Side of the value on which the quantity lies.
    #[serde(default = "near")]
    pub bound: Bound,
    /// Independent observations that agree.
    #[serde(default = "once")]
    pub times: u32,
    /// Publication or measurement that the row comes from.
    #[serde(default)]
    pub source: String,
    /// Bursts that gave a stroke or level.
    pub drive: Option<EvidenceDrive>,
}

/// Kind of a measured quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measured {
    /// Largest stroke of the skin within a burst of the last visit, um.
    Stroke,
    /// Level over the person's threshold in the last visit, dB.
    Level,
    /// The quantity itself.
    Itself(Quantity),
}

impl Measured {
    /// The kind of a row's quantity; `None` where there is no such quantity.
    #[must_use]
    pub fn of_key(key: &str) -> Option<Self> {
        match key {
            "stroke" => Some(Self::Stroke),
            "level" => Some(Self::Level),
            // A wire's own stress tells whether it is taut.
            "taut_stress" => None,
            _ => Quantity::of_key(key).map(Self::Itself),
        }
    }

    /// Unit of the value.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Stroke => "um",
            Self::Level => "dB",
            Self::Itself(quantity) => quantity.unit(),
        }
    }
}

impl EvidenceRow {
    /// The kind of the row's quantity, which reading has checked.
    #[must_use]
    pub fn measured(&self) -> Measured {
        Measured::of_key(&self.quantity).unwrap_or(Measured::Stroke)
    }

    fn check(&self, source: &Source, at: &str) -> Result<(), FileError> {
        let key = |name: &str| format!("{at}.{name}");
        let Some(measured) = Measured::of_key(&self.quantity) else {
            let names = ["stroke", "level"].into_iter();
            let names: Vec<&str> = names.chain(Quantity::ALL.map(Quantity::key)).collect();
            let meant = did_you_mean(&self.quantity, names.iter().copied());
            let expected = format!("one of {}", names.join(", "));
            let found = format!("\"{}\"{meant}", self.quantity);
            return Err(source.bad_found(&key("quantity"), expected, found));
        };
        if self.unit != measured.unit() {
            let expected = format!("\"{}\", the unit of {}", measured.unit(), self.quantity);
            return Err(source.bad(&key("unit"), expected));
        }
        if self.source.trim().is_empty() {
            let expected = "the publication or measurement that the value comes from";
            return Err(source.bad(&key("source"), expected));
        }
        let (low, high) = match measured {
            Measured::Stroke => (1e-3, 1e4),
            Measured::Level => (-100.0, 100.0),
            Measured::Itself(quantity) => quantity.bounds(),
        };
        source.range(&key("value"), &self.value, low..=high, measured.unit())?;
        source.range(&key("times"), &self.times, 1..=1000, "observations")?;
        match (&self.tolerance, &self.factor) {
            (Some(sides), None) => {
                source.range(&key("tolerance"), sides, 1e-9..=1e6, measured.unit())?;
            }
            (None, Some(sides)) => {
                source.range(&key("factor"), sides, 1.000_001..=1e3, "")?;
                if self.value <= 0.0 {
                    return Err(source.bad(&key("value"), "more than 0 beside `factor`"));
                }
            }
            _ => {
                let expected = "`tolerance` or `factor`, and not both: standard deviations below and above, such as tolerance = [0.5, 0.5]";
                return Err(source.bad_found(at, expected, "none or both"));
            }
        }
        match (&self.drive, measured) {
            (None, Measured::Stroke | Measured::Level) => {
                let expected = "a table `drive`: the bursts that gave the value";
                Err(source.bad_found(at, expected, "none"))
            }
            (Some(_), Measured::Itself(_)) => {
                let expected = "no bursts: a quantity by itself has none";
                Err(source.bad_found(&key("drive"), expected, "a table"))
            }
            (Some(drive), _) => drive.check(source, &key("drive")),
            (None, _) => Ok(()),
        }
    }
}

impl EvidenceDrive {
    /// Alloy of the wire.
    #[must_use]
    pub fn alloy(&self) -> &str {
        self.alloy.as_deref().unwrap_or("low")
    }

    fn check(&self, source: &Source, at: &str) -> Result<(), FileError> {
        bounds!(source, at, self;
            wire_share: 0.01..=1.0;
            current_ma: 1.0..=5000.0, "mA";
            pulses: 1..=100;
            width_us: 1.0..=1000.0, "us";
            spacing_us: 500.0..=100_000.0, "us";
            every_ms: 1.0..=10_000.0, "ms";
            bursts: 1..=100;
            visits: 1..=10;
            pause_ms: 0.0..=60_000.0, "ms")?;
        let burst_us = f64::from(self.pulses - 1) * self.spacing_us + self.width_us;
        if self.width_us >= self.spacing_us {
            let expected = format!("less than spacing_us, {}", self.spacing_us);
            return Err(source.bad(&format!("{at}.width_us"), expected));
        }
        if burst_us > self.every_ms * 1e3 {
            let expected = format!("at least {:.1}: a burst is as long", burst_us / 1e3);
            return Err(source.bad(&format!("{at}.every_ms"), expected));
        }
        if self.alloy.is_some() && self.wire.is_none() {
            return Err(source.bad(&format!("{at}.alloy"), "it beside a wire"));
        }
        Ok(())
    }
}

/// Rows of evidence.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct EvidenceFile {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The evidence, in a sentence.
    pub description: String,
    /// The rows.
    pub row: Vec<EvidenceRow>,
}

impl EvidenceFile {
    /// Reads and checks evidence.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let file: Self = source.read()?;
        source.heading(&file.name, &file.description)?;
        for (index, row) in file.row.iter().enumerate() {
            row.check(source, &format!("row[{index}]"))?;
        }
        Ok(file)
    }
}
