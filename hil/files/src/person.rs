//! Two independent files about a person: the calibration of the wearer, which the loop reads, and the emulated person
//! who feels the result.

use serde::Deserialize;

use super::error::FileError;
use super::settings::bounds;
use super::source::Source;

/// The largest threshold that a file may state, um.
const MOST_UM: f64 = 1e3;

/// A person's value, and the range of nine in ten people.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Value of this person.
    pub value: f64,
    /// Value that one in twenty people is below.
    pub low: f64,
    /// Value that one in twenty people is above.
    pub high: f64,
}

impl Spread {
    fn check(&self, source: &Source, key: &str, most: f64, unit: &str) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        source.range(&at("low"), &self.low, 1e-3..=most, unit)?;
        source.range(&at("high"), &self.high, self.low..=most, unit)?;
        source.range(&at("value"), &self.value, self.low..=self.high, unit)
    }
}

/// One channel of a fingertip.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FeltChannel {
    /// Displacement that is just felt, um: for `vibration` the amplitude of a long sine at 250 Hz, for `flutter` the
    /// peak of the filtered displacement.
    pub threshold_um: Spread,
    /// Exponent by which the sensation grows with the displacement.
    pub growth: Spread,
    /// Area of the contact for which the threshold of `vibration` holds, cm2: strip on the skin times length. Left out:
    /// it holds for a wire of the bench, whatever its area.
    pub area_cm2: Option<f64>,
    /// Exponent by which that threshold falls with the area, up to 0.1 cm2; left out: 1/2, which is 3 dB per doubling.
    pub summation: Option<f64>,
}

/// The channel NP II of a fingertip.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FeltPeak {
    /// Peak of the displacement after the Pacinian filter that is just felt, um.
    pub threshold_um: Spread,
}

impl FeltChannel {
    fn check(&self, source: &Source, key: &str) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        let threshold = at("threshold_um");
        self.threshold_um.check(source, &threshold, MOST_UM, "um")?;
        self.growth.check(source, &at("growth"), 10.0, "")?;
        bounds!(source, key, self;
            area_cm2: 1e-5..=10.0, "cm2";
            summation: 0.0..=1.0, "")?;
        match (self.area_cm2, self.summation) {
            (None, Some(_)) => Err(source.bad(
                &at("summation"),
                "no exponent, or area_cm2 beside it: the area for which the threshold holds",
            )),
            _ => Ok(()),
        }
    }
}

/// The emulated person, who feels a part of the wires' motion.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PersonFile {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The person, in a sentence.
    pub description: String,
    /// The values that are fitted or assumed; reports flag it.
    pub assumed: Option<String>,
    /// The Pacinian channel, best at 250 Hz.
    pub vibration: FeltChannel,
    /// The channel NP I, best at 40 Hz.
    pub flutter: FeltChannel,
    /// The channel NP II, which feels short vibrations of small areas. Left out: a person without it.
    pub np2: Option<FeltPeak>,
}

impl PersonFile {
    /// Reads and checks a person.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let file: Self = source.read()?;
        source.heading(&file.name, &file.description)?;
        file.vibration.check(source, "vibration")?;
        file.flutter.check(source, "flutter")?;
        if file.flutter.area_cm2.is_some() {
            let expected = "no area: this channel does not add up over it";
            return Err(source.bad("flutter.area_cm2", expected));
        }
        if let Some(np2) = &file.np2 {
            np2.threshold_um
                .check(source, "np2.threshold_um", MOST_UM, "um")?;
        }
        Ok(file)
    }
}

/// A wearer's calibration: one gain and one threshold a wire, in the display's order.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Wearer {
    /// Name, in lower case with hyphens.
    pub name: String,
    /// The wearer, in a sentence.
    pub description: String,
    /// The part of full drive at which this wire feels as strong as the weakest one at full drive.
    pub gain: Vec<f64>,
    /// The part of full drive at which this person begins to feel the wire.
    pub threshold: Vec<f64>,
    /// Interval of each wire's gain, low and high, that holds 95 % of what is held for possible; the loop does not
    /// read it.
    pub gain_interval: Option<Vec<[f64; 2]>>,
    /// Interval of each wire's threshold, low and high, with 95 % of what is held for possible.
    pub threshold_interval: Option<Vec<[f64; 2]>>,
    /// Displacement that this wearer just feels as vibration, um: the amplitude of a long sine at 250 Hz. `level_db`
    /// of a scene counts from it. It holds for a wire of the wearer's bench. Left out: that of the person `typical`.
    pub vibration_um: Option<f64>,
    /// Displacement that this wearer just feels as flutter or tap, um: the peak of the filtered displacement.
    pub flutter_um: Option<f64>,
}

impl Wearer {
    /// Reads and checks a calibration by itself; [`crate::Setup`] checks it against the display.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let file: Self = source.read()?;
        source.heading(&file.name, &file.description)?;
        bounds!(source, "", file;
            vibration_um: 1e-3..=MOST_UM, "um";
            flutter_um: 1e-3..=MOST_UM, "um")?;
        if file.threshold.len() != file.gain.len() {
            let expected = format!("{} thresholds, one a gain", file.gain.len());
            let found = file.threshold.len().to_string();
            return Err(source.bad_found("threshold", expected, found));
        }
        for (wire, (gain, threshold)) in file.gain.iter().zip(&file.threshold).enumerate() {
            source.range(&format!("gain[{wire}]"), gain, 0.01..=1.0, "of full scale")?;
            if !(0.0..*gain).contains(threshold) {
                let expected = format!("from 0 to below the wire's full scale, its gain of {gain}");
                return Err(source.bad(&format!("threshold[{wire}]"), expected));
            }
        }
        for (key, intervals) in [
            ("gain_interval", &file.gain_interval),
            ("threshold_interval", &file.threshold_interval),
        ] {
            let intervals = intervals.as_deref().unwrap_or_default();
            if !intervals.is_empty() && intervals.len() != file.gain.len() {
                let expected = format!("{} intervals, one a gain", file.gain.len());
                return Err(source.bad_found(key, expected, intervals.len().to_string()));
            }
            let unit = "of full drive";
            for (wire, [low, high]) in intervals.iter().enumerate() {
                source.range(&format!("{key}[{wire}][0]"), low, 0.0..=1.0, unit)?;
                source.range(&format!("{key}[{wire}][1]"), high, *low..=1.0, unit)?;
            }
        }
        Ok(file)
    }

    /// Holds the calibration against a display of so many wires.
    pub(super) fn fits(&self, source: &Source, wires: usize) -> Result<(), FileError> {
        if self.gain.len() == wires {
            return Ok(());
        }
        let expected = format!("{wires} gains, one a wire");
        Err(source.bad_found("gain", expected, self.gain.len().to_string()))
    }
}
