//! Limits, the worst that a run came to, and what was left: the one computation of both behind every table.

use serde::ser::{Serialize, SerializeStruct, Serializer};

use crate::model;

/// Quantity that has a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Limited {
    /// Longest stretch of current in a wire.
    Pulse,
    /// Time from the first to the last current of a burst on one wire.
    Burst,
    /// Electrical energy of a burst on one wire.
    BurstEnergy,
    /// Mean power of a wire over a second.
    WirePower1s,
    /// Mean power of a wire over ten seconds.
    WirePower10s,
    /// Mean power of all wires of a fingertip over a second.
    FingertipPower1s,
    /// Mean power of all wires of a fingertip over a minute.
    FingertipPower60s,
    /// Mean power of all fingertips of a hand over a minute.
    HandPower60s,
    /// Current of the supply.
    SupplyCurrent,
    /// Skin 0.1 mm deep, mean over ten seconds.
    SkinMean,
    /// Skin 0.1 mm deep at any time.
    SkinPeak,
    /// Skin 0.4 mm deep at any time.
    SkinDeep,
    /// Damage integral of Henriques and Moritz.
    Henriques,
    /// Minutes at 43 degrees C that would do the same.
    Cem43,
    /// Warmest face of a Peltier module.
    FaceWarm,
    /// Depth of a Peltier module's coldest face under the temperature of skin at rest.
    FaceCold,
    /// Fastest change of a Peltier module's face.
    FaceRamp,
    /// Warmest sink of a Peltier module.
    Sink,
    /// Most current through a Peltier module.
    PeltierCurrent,
    /// Largest voltage on a motor.
    MotorVoltage,
    /// Largest amplitude of a motor's face on the skin.
    MotorTravel,
    /// Largest rise of a motor's coil over the air.
    CoilRise,
}

/// The temperature at rest, from which the used part of a temperature limit counts: 33 degrees C.
const REST_NANO: i64 = 33_000_000_000;
/// Temperature at rest of a sink: the air of a room, 25 degrees C.
const ROOM_NANO: i64 = 25_000_000_000;

impl Limited {
    /// Name, unit, and value when nothing happens in billionths of the unit.
    const fn row(self) -> (&'static str, &'static str, i64) {
        match self {
            Self::Pulse => ("pulse", "us", 0),
            Self::Burst => ("burst", "ms", 0),
            Self::BurstEnergy => ("burst energy", "mJ", 0),
            Self::WirePower1s => ("wire power, 1 s", "mW", 0),
            Self::WirePower10s => ("wire power, 10 s", "mW", 0),
            Self::FingertipPower1s => ("fingertip power, 1 s", "mW", 0),
            Self::FingertipPower60s => ("fingertip power, 60 s", "mW", 0),
            Self::HandPower60s => ("hand power, 60 s", "mW", 0),
            Self::SupplyCurrent => ("supply current", "A", 0),
            Self::SkinMean => ("skin at 0.1 mm, 10 s mean", "C", REST_NANO),
            Self::SkinPeak => ("skin at 0.1 mm", "C", REST_NANO),
            Self::SkinDeep => ("skin at 0.4 mm", "C", REST_NANO),
            Self::Henriques => ("Henriques dose", "Omega", 0),
            Self::Cem43 => ("dose, CEM43", "min", 0),
            Self::FaceWarm => ("face", "C", REST_NANO),
            Self::FaceCold => ("face, under rest", "K", 0),
            Self::FaceRamp => ("face, ramp", "K/s", 0),
            Self::Sink => ("sink", "C", ROOM_NANO),
            Self::PeltierCurrent => ("Peltier current", "A", 0),
            Self::MotorVoltage => ("motor voltage, peak", "V", 0),
            Self::MotorTravel => ("motor amplitude", "um", 0),
            Self::CoilRise => ("coil, over the air", "K", 0),
        }
    }

    /// Name in tables and JSON.
    pub const fn name(self) -> &'static str {
        self.row().0
    }

    /// Unit of its values.
    pub const fn unit(self) -> &'static str {
        self.row().1
    }

    const fn rest_nano(self) -> i64 {
        self.row().2
    }
}

/// A limit and the worst that came, in billionths of the unit: the doses are that small, and a trace is integers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Margin {
    /// Quantity that is limited.
    pub of: Limited,
    /// The worst of the run.
    pub worst_nano: i64,
    /// The limit in force.
    pub limit_nano: i64,
}

impl Margin {
    /// A margin from a value and its limit in the unit of `of`. NaN counts as the largest value there is, which no
    /// limit is. Minus infinity, the largest of nothing, counts as rest.
    pub fn new(of: Limited, worst: f64, limit: f64) -> Self {
        Self {
            of,
            worst_nano: nano(worst).unwrap_or_else(|| of.rest_nano()),
            limit_nano: nano(limit).unwrap_or(0),
        }
    }

    /// The worst, in the unit.
    pub fn worst(&self) -> f64 {
        self.worst_nano as f64 / 1e9
    }

    /// The limit, in the unit.
    pub fn limit(&self) -> f64 {
        self.limit_nano as f64 / 1e9
    }

    /// Part of the limit that was left, in the unit; negative beyond the limit.
    pub fn left(&self) -> f64 {
        self.limit_nano.saturating_sub(self.worst_nano) as f64 / 1e9
    }

    /// Part of the limit that was used, counted from rest, in thousandths of a percent; `None` for a limit at rest.
    pub fn used_milli_percent(&self) -> Option<i64> {
        let rest = i128::from(self.of.rest_nano());
        share_milli_percent(
            i128::from(self.worst_nano) - rest,
            i128::from(self.limit_nano) - rest,
        )
    }

    /// Part of the limit that was used, counted from rest, 1 for all of it; infinite for a limit at rest.
    pub fn used(&self) -> f64 {
        self.used_milli_percent()
            .map_or(f64::INFINITY, |used| used as f64 / 1e5)
    }

    /// The part that was used, for people: percent, above ten times the limit `x`, and never wide.
    pub fn used_words(&self) -> String {
        used_words(self.used_milli_percent())
    }

    /// Tells whether the worst value is a temperature beyond the model.
    pub fn is_beyond(&self) -> bool {
        self.of.unit() == "C" && model::known(self.worst(), model::TISSUE_C).is_none()
    }

    /// Tells whether the limit was passed.
    pub const fn over(&self) -> bool {
        self.worst_nano > self.limit_nano
    }
}

/// A used part in thousandths of a percent as [`Margin::used_words`] says it; `None` is a limit at rest.
pub fn used_words(milli_percent: Option<i64>) -> String {
    match milli_percent {
        Some(used) if used < 1_000_000 => format!("{:.0} %", (used.max(0) as f64) * 1e-3),
        Some(used) if used <= 100_000_000_000 => format!("{:.0} x", used as f64 * 1e-5),
        _ => "> 1e6 x".to_owned(),
    }
}

/// Billionths, rounded; `None` for minus infinity.
fn nano(value: f64) -> Option<i64> {
    if value.is_nan() {
        return Some(i64::MAX);
    }
    // A cast keeps what does not fit at the end of the range.
    (value > f64::NEG_INFINITY).then_some((value * 1e9).round() as i64)
}

/// Thousandths of a percent that a part is of a whole, rounded; `None` for a whole of nothing.
fn share_milli_percent(part: i128, whole: i128) -> Option<i64> {
    if whole <= 0 {
        return None;
    }
    let twice = part.saturating_mul(200_000);
    let share = (twice + whole * part.signum()) / (2 * whole);
    Some(i64::try_from(share).unwrap_or(i64::MAX))
}

/// Puts the margin that was used up most first.
pub fn sort(margins: &mut [Margin]) {
    let key = |m: &Margin| m.used_milli_percent().unwrap_or(i64::MAX);
    margins.sort_by(|a, b| {
        let used = key(b).cmp(&key(a));
        used.then(a.of.name().cmp(b.of.name()))
    });
}

/// The object of `hil run --json`: numbers in the unit.
impl Serialize for Margin {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut object = serializer.serialize_struct("Margin", 6)?;
        object.serialize_field("name", self.of.name())?;
        object.serialize_field("worst", &self.worst())?;
        object.serialize_field("limit", &self.limit())?;
        object.serialize_field("unit", self.of.unit())?;
        object.serialize_field("margin", &self.left())?;
        object.serialize_field("used", &self.used())?;
        object.end()
    }
}

#[cfg(test)]
#[path = "margin_tests.rs"]
mod tests;
