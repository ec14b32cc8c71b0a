//! A scene's illusion: which law, how contacts share wires, how strong, when, for whom.

use palpate_core::illusion::{Distances, IllusionModel, Sharing, TimingLaw};
use palpate_core::render::Style;
use palpate_core::units::Duration;
use serde::Deserialize;

use super::error::FileError;
use super::source::Source;
use super::words;

/// Phantom sensation and its timing.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Illusion {
    /// The model.
    #[serde(with = "words::Model")]
    pub model: IllusionModel,
    /// The model's shape: s of `phantom`, the exponent of `balanced`, the width of `gaussian` as a share of
    /// the gap. Left out: the model's own (1, 0.65, 0.6).
    pub shape: Option<f64>,
    /// `phantom` with the shape that makes midpoints flat, found from the spacings.
    pub flat: bool,
    /// Distances; left out: `axes` for `phantom`, else `plane`.
    #[serde(with = "words::distances")]
    #[cfg_attr(test, schemars(with = "Option<words::Distances>"))]
    pub distances: Option<Distances>,
    /// How far outside the wires a contact is still rendered, as a share of the smallest gap; left out: 0.5.
    pub margin: Option<f64>,
    /// How `inverse` renders a contact.
    #[serde(with = "words::Style")]
    pub render: Style,
    /// How strongly `inverse` lets a contact at the top level be felt, dB over the wearer's threshold. Left out: as
    /// strongly as the limits let it.
    pub level_db: Option<f64>,
    /// How several contacts share wires.
    #[serde(with = "words::Sharing")]
    pub sharing: Sharing,
    /// Duty of a wire that is barely active, a share of the period.
    pub alpha: f64,
    /// Duty added at full activation, a share of the period.
    pub beta: f64,
    /// The timing law.
    #[serde(with = "words::Timing")]
    pub timing: TimingLaw,
    /// Length of a stimulus in milliseconds; left out: by the law from `soa_ms`, 50 at most. `inverse` finds its own.
    pub tau_d_ms: Option<f64>,
    /// Between onsets in milliseconds; left out: 117 for `inverse`, else by the law from `tau_d_ms`, which is 35 if that is
    /// left out too.
    pub soa_ms: Option<f64>,
    /// Whether a contact's level reaches the wires.
    pub intensity: bool,
    /// The share of beta at the lowest level; the top level has all of it.
    pub intensity_floor: f64,
    /// Weber fraction by which levels differ, from the top down to the floor; left out: evenly spaced.
    pub weber: Option<f64>,
    /// The emulated person who feels it, a built-in name or a file.
    pub person: String,
    /// The wearer's calibration, a built-in name or a file; left out: every wire as it comes.
    pub wearer: Option<String>,
}

impl Default for Illusion {
    fn default() -> Self {
        Self {
            model: IllusionModel::Inverse,
            shape: None,
            flat: false,
            distances: None,
            margin: None,
            render: Style::Smooth,
            level_db: None,
            sharing: Sharing::Strongest,
            alpha: 0.0,
            beta: 100.0 / 4096.0, // of the chip's ticks
            timing: TimingLaw::TactileBrush,
            tau_d_ms: None,
            soa_ms: None,
            intensity: true,
            intensity_floor: 0.85,
            weber: None,
            person: "typical".into(),
            wearer: None,
        }
    }
}

impl Illusion {
    /// The stated duration and onset asynchrony in the core's unit.
    #[must_use]
    pub fn stated(&self) -> (Option<Duration>, Option<Duration>) {
        let span = |ms: f64| Duration::from_micros((ms * 1e3).round() as u64);
        (self.tau_d_ms.map(span), self.soa_ms.map(span))
    }

    /// Time between onsets in milliseconds.
    #[must_use]
    pub fn onset_ms(&self) -> f64 {
        let (_, soa) = self.stated();
        let usual = self.tau_d_ms.unwrap_or(35.0);
        match (soa, self.timing) {
            (Some(soa), _) => soa.as_micros() as f64 * 1e-3,
            (None, TimingLaw::TactileBrush) => 0.32 * usual + 47.3,
            (None, TimingLaw::Fingerpad) => 115.0,
        }
    }

    pub(super) fn check(&self, source: &Source) -> Result<(), FileError> {
        if let Some(shape) = self.shape {
            source.range("illusion.shape", shape, 0.01..=100.0, "")?;
            if self.flat {
                return Err(source.bad("illusion.flat", "a shape or a flat midpoint, not both"));
            }
        }
        if let Some(margin) = self.margin {
            source.range("illusion.margin", margin, 0.01..=10.0, "gaps")?;
        }
        if let Some(level) = self.level_db {
            source.range("illusion.level_db", level, 0.0..=60.0, "dB over threshold")?;
            if self.model != IllusionModel::Inverse {
                let expected = "nothing: only `inverse` aims at a level";
                return Err(source.bad("illusion.level_db", expected));
            }
        }
        source.range("illusion.alpha", self.alpha, 0.0..=1.0, "")?;
        source.range("illusion.beta", self.beta, 0.0..=1.0, "")?;
        if self.alpha + self.beta >= 1.0 {
            return Err(source.bad("illusion.beta", "alpha + beta below 1"));
        }
        if let Some(tau) = self.tau_d_ms {
            source.range("illusion.tau_d_ms", tau, 1.0..=1000.0, "ms")?;
        }
        if let Some(soa) = self.soa_ms {
            source.range("illusion.soa_ms", soa, 1.0..=10_000.0, "ms")?;
        }
        if self.tau_d_ms.is_some_and(|tau| tau > self.onset_ms()) {
            let expected = format!("at most the time between onsets, {} ms", self.onset_ms());
            return Err(source.bad("illusion.tau_d_ms", expected));
        }
        let (duration, soa) = self.stated();
        self.timing
            .timing(duration, soa)
            .map_err(|e| source.bad("illusion.soa_ms", e.to_string()))?;
        let floor = self.intensity_floor;
        source.range("illusion.intensity_floor", floor, 0.0..=1.0, "")?;
        if let Some(weber) = self.weber {
            source.range("illusion.weber", weber, 0.001..=10.0, "")?;
        }
        Ok(())
    }
}

/// A straight stroke over the display, rendered by the Tactile Brush planner in place of live contacts. Where it begins and
/// ends at one place it stays there, with an onset every SOA.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SceneStroke {
    /// First onset.
    pub start_s: f64,
    /// How long it takes from end to end.
    pub length_s: f64,
    /// Where it begins, on the display.
    pub from_mm: [f64; 2],
    /// Where it ends.
    pub to_mm: [f64; 2],
    /// How strong, as a part of full strength.
    #[serde(default = "full")]
    pub weight: f64,
}

const fn full() -> f64 {
    1.0
}

impl SceneStroke {
    /// Checks the strokes of one display, one after the other.
    pub(super) fn check_all(
        all: &[Self],
        source: &Source,
        key: &str,
        end_s: f64,
    ) -> Result<(), FileError> {
        let mut free_s = 0.0;
        for (index, stroke) in all.iter().enumerate() {
            stroke.check(source, &format!("{key}[{index}]"), free_s, end_s)?;
            free_s = stroke.start_s + stroke.length_s;
        }
        Ok(())
    }

    fn check(&self, source: &Source, key: &str, free_s: f64, end_s: f64) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        if !(free_s..end_s).contains(&self.start_s) {
            let expected =
                format!("from {free_s} s, where the one before ends, to below {end_s} s");
            return Err(source.bad(&at("start_s"), expected));
        }
        source.range(&at("length_s"), self.length_s, 0.001..=3600.0, "s")?;
        source.range(&at("weight"), self.weight, 0.0..=1.0, "of full strength")?;
        for (name, place) in [("from_mm", self.from_mm), ("to_mm", self.to_mm)] {
            for (axis, value) in place.into_iter().enumerate() {
                source.range(&at(&format!("{name}[{axis}]")), value, -1e4..=1e4, "mm")?;
            }
        }
        Ok(())
    }
}
