//! Search space of the table of laws: one sequence of points that every law is tried at.

use palpate_core::illusion::IllusionModel;
use palpate_core::render::Style;
use palpate_files::Overrides;

/// A knob's range, drawn by its logarithm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) least: f64,
    pub(super) most: f64,
}

impl Range {
    fn at(&self, part: f64) -> f64 {
        self.least * (self.most / self.least).powf(part)
    }
}

/// Time between onsets, stimulus duration, pulse width at full activation, and frequency of the pulses.
pub(super) const RANGES: [Range; 4] = [
    range("`soa_ms`", "ms", 58.5, 240.0),
    range("`tau_d_ms`", "ms", 5.0, 48.8),
    range("pulse width (`beta` / `pwm_hz`)", "us", 30.0, 184.0),
    range("`bench.drive.pwm_hz`", "Hz", 60.0, 200.0),
];

const fn range(name: &'static str, unit: &'static str, least: f64, most: f64) -> Range {
    Range {
        name,
        unit,
        least,
        most,
    }
}

/// Settings that were found for `energy` by hand, without a limiter event: 0.010 of a period of 66 Hz.
const BY_HAND: Knobs = Knobs {
    values: [117.0, 20.0, 0.010 / 66.0 * 1e6, 66.0],
    shape: None,
};
/// Points before the drawn ones: the law's own settings, and those found by hand.
pub(super) const GIVEN: u32 = 2;
/// Root of x^6 = x + 1: its inverse powers are the steps of the sequence with the least gaps in five dimensions.
const STEP: f64 = 1.134_724_138_401_519_5;

/// Duration below which `inverse` chooses the frequency of its pulses: half of the points.
pub(super) const FREE_BELOW_MS: f64 = 15.6;

/// A point of the search space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Knobs {
    /// Values in the order and units of [`RANGES`].
    pub(super) values: [f64; 4],
    /// Part of the range of a law's own fifth knob; `None` for the law's own value.
    shape: Option<f64>,
}

/// Point `n` of the sequence; `None` for a law's own settings, without a change.
pub(super) fn point(n: u32) -> Option<Knobs> {
    let drawn = |dimension: i32| (0.5 + f64::from(n) * STEP.powi(-dimension)).fract();
    match n {
        0 => None,
        1 => Some(BY_HAND),
        _ => Some(Knobs {
            values: [1, 2, 3, 4].map(|d: i32| RANGES[(d - 1) as usize].at(drawn(d))),
            shape: Some(drawn(5)),
        }),
    }
}

/// Range of a law's shape; `None` for a law without one.
pub(super) fn shapes(law: IllusionModel) -> Option<Range> {
    match law {
        IllusionModel::Phantom => Some(range("s", "", 0.25, 4.0)),
        IllusionModel::Balanced => Some(range("exponent", "", 0.4, 1.2)),
        IllusionModel::Gaussian => Some(range("sigma over gap", "", 0.3, 1.2)),
        _ => None,
    }
}

impl Knobs {
    /// Value of the fifth knob as a file has it, with its key; `None` where the law has none or keeps its own.
    pub(super) fn fifth(&self, law: IllusionModel) -> Option<(&'static str, String)> {
        let part = self.shape?;
        if law == IllusionModel::Inverse {
            let style = if part < 0.5 {
                Style::Smooth
            } else {
                Style::Tap
            };
            return Some(("render", style.name().into()));
        }
        shapes(law).map(|range| ("shape", format!("{:.3}", range.at(part))))
    }
}

/// Changes that a law and a point make to a scene and its bench.
pub(super) fn overrides(law: IllusionModel, knobs: Option<&Knobs>) -> Overrides {
    let mut overrides = Overrides::default();
    overrides.scene("laws", "illusion.model", law.name());
    if let Some(knobs) = knobs {
        let [soa_ms, tau_d_ms, pulse_us, pwm_hz] = knobs.values;
        let beta = pulse_us * 1e-6 * pwm_hz;
        overrides.scene("laws", "illusion.soa_ms", format!("{soa_ms:.3}"));
        overrides.scene("laws", "illusion.beta", format!("{beta:.6}"));
        // `inverse` finds its duration, and refuses one: that knob says whether it finds the frequency as well.
        let finds = law == IllusionModel::Inverse;
        if !finds {
            overrides.scene("laws", "illusion.tau_d_ms", format!("{tau_d_ms:.3}"));
        }
        if !(finds && tau_d_ms < FREE_BELOW_MS) {
            overrides.bench("laws", "drive.pwm_hz", format!("{pwm_hz:.3}"));
        }
        if let Some((key, value)) = knobs.fifth(law) {
            overrides.scene("laws", &format!("illusion.{key}"), value);
        }
    }
    overrides
}
