//! Illusion of a scene: its law, the sharing of wires, strength, timing and wearer.

use palpate_core::illusion::{AHEAD, Distances, IllusionModel, Sharing, TimingLaw};
use palpate_core::render::Style;
use palpate_core::units::Duration;
use serde::Deserialize;

use super::error::FileError;
use super::settings::{bounds, settings};
use super::source::Source;
use super::words;

settings! {
    /// Phantom sensation and its timing.
    pub struct Illusion {
        /// The model.
        #[serde(with = "words::Model")]
        pub model: IllusionModel = IllusionModel::Inverse,
        /// The model's shape: s of `phantom`, the exponent of `balanced`, the width of `gaussian` as a share of
        /// the gap. Left out: the model's own (1, 0.65, 0.6).
        pub shape: Option<f64>,
        /// s_y of (5.2), where it is another than `shape`, which is then s_x; `phantom` over the distances `axes` alone.
        pub shape_y: Option<f64>,
        /// True for `phantom` with the shape that makes midpoints flat, found from the spacings.
        pub flat: bool = false,
        /// Distances; left out: `axes` for `phantom`, else `plane`.
        #[serde(with = "words::distances")]
        #[cfg_attr(test, schemars(with = "Option<words::Distances>"))]
        pub distances: Option<Distances>,
        /// Distance outside the wires at which a contact is still rendered, as a share of the smallest gap; left out:
        /// 0.5.
        pub margin: Option<f64>,
        /// The style in which `inverse` renders a contact.
        #[serde(with = "words::Style")]
        pub render: Style = Style::Smooth,
        /// Strength at which `inverse` lets a contact at the top level and a texture be felt, dB over the wearer's threshold.
        /// Left out: the strongest that the limits permit for a contact, 5 for a texture.
        pub level_db: Option<f64>,
        /// The rule by which several contacts share wires.
        #[serde(with = "words::Sharing")]
        pub sharing: Sharing = Sharing::Strongest,
        /// Duty of a wire that is barely active, a share of the period.
        pub alpha: f64 = 0.0,
        /// Duty added at full activation, a share of the period.
        pub beta: f64 = 100.0 / 4096.0, // of the chip's ticks
        /// The timing law.
        #[serde(with = "words::Timing")]
        pub timing: TimingLaw = TimingLaw::TactileBrush,
        /// Length of a stimulus in milliseconds; left out: by the law from `soa_ms`, 50 at most. `inverse` finds its own.
        pub tau_d_ms: Option<f64>,
        /// Time between onsets in milliseconds; left out: 117 for `inverse`, else by the law from `tau_d_ms`, which
        /// is 35 if that is left out too.
        pub soa_ms: Option<f64>,
        /// Longest time for which a contact is carried on with its velocity to the instant of an onset, milliseconds; 0 leaves it
        /// where its newest frame had it.
        pub ahead_ms: f64 = AHEAD.as_secs_f64() * 1e3,
        /// True if a contact's level reaches the wires.
        pub intensity: bool = true,
        /// The share of beta at the lowest level; the top level has all of it.
        pub intensity_floor: f64 = 0.85,
        /// Weber fraction by which levels differ, from the top down to the floor; left out: evenly spaced.
        pub weber: Option<f64>,
        /// The emulated person who feels it, a built-in name or a file.
        pub person: String = "typical".into(),
        /// The wearer's calibration, a built-in name or a file; left out: none.
        pub wearer: Option<String>,
    }
}

/// Milliseconds in the core's unit.
fn span(ms: f64) -> Duration {
    Duration::from_micros((ms * 1e3).round() as u64)
}

impl Illusion {
    /// The stated duration and onset asynchrony in the core's unit.
    #[must_use]
    pub fn stated(&self) -> (Option<Duration>, Option<Duration>) {
        (self.tau_d_ms.map(span), self.soa_ms.map(span))
    }

    /// Longest time for which a contact is carried on, in the core's unit.
    #[must_use]
    pub fn ahead(&self) -> Duration {
        span(self.ahead_ms)
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
        bounds!(source, "illusion", self; shape: 0.01..=100.0; shape_y: 0.01..=100.0)?;
        if self.shape_y.is_some() && self.shape.is_none() {
            return Err(source.bad("illusion.shape_y", "illusion.shape beside it, for s_x"));
        }
        if self.shape.is_some() && self.flat {
            return Err(source.bad("illusion.flat", "a shape or a flat midpoint, not both"));
        }
        bounds!(source, "illusion", self;
            margin: 0.01..=10.0, "gaps";
            level_db: 0.0..=60.0, "dB over threshold")?;
        if self.level_db.is_some() && self.model != IllusionModel::Inverse {
            let expected = "nothing: only `inverse` aims at a level";
            return Err(source.bad("illusion.level_db", expected));
        }
        bounds!(source, "illusion", self; alpha: 0.0..=1.0; beta: 0.0..=1.0)?;
        if self.alpha + self.beta >= 1.0 {
            return Err(source.bad("illusion.beta", "alpha + beta below 1"));
        }
        bounds!(source, "illusion", self;
            tau_d_ms: 1.0..=1000.0, "ms";
            soa_ms: 1.0..=10_000.0, "ms")?;
        if self.tau_d_ms.is_some_and(|tau| tau > self.onset_ms()) {
            let expected = format!("at most the time between onsets, {} ms", self.onset_ms());
            return Err(source.bad("illusion.tau_d_ms", expected));
        }
        let (duration, soa) = self.stated();
        self.timing
            .timing(duration, soa)
            .map_err(|e| source.bad("illusion.soa_ms", e.to_string()))?;
        bounds!(source, "illusion", self;
            ahead_ms: 0.0..=1000.0, "ms";
            intensity_floor: 0.0..=1.0;
            weber: 0.001..=10.0)
    }
}

/// A straight stroke over the display, which the Tactile Brush planner renders in place of live contacts. A stroke
/// that begins and ends at one place stays there, with an onset every SOA.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SceneStroke {
    /// First onset.
    pub start_s: f64,
    /// Time from end to end, seconds.
    pub length_s: f64,
    /// Beginning of the stroke on the display, mm.
    pub from_mm: [f64; 2],
    /// End of the stroke on the display, mm.
    pub to_mm: [f64; 2],
    /// Strength, as a part of full strength.
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
        if !(free_s..end_s).contains(&self.start_s) {
            let expected =
                format!("from {free_s} s, where the one before ends, to below {end_s} s");
            return Err(source.bad(&format!("{key}.start_s"), expected));
        }
        bounds!(source, key, self;
            length_s: 0.001..=3600.0, "s";
            weight: 0.0..=1.0, "of full strength";
            from_mm: -1e4..=1e4, "mm";
            to_mm: -1e4..=1e4, "mm")
    }
}
