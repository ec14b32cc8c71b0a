//! Joints of the hand that a skin is on: their angles over time, and the conditions of a scene that depend on them.

use std::ops::RangeInclusive;

use palpate_core::statistics::interpolated;
use serde::Deserialize;

use super::error::FileError;
use super::settings::bounds;
use super::source::Source;

/// Largest angle of a joint, degrees either way.
pub const MOST_DEG: f64 = 360.0;

/// A joint's angle over time.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// The joint's name: letters, digits, `_` and `-`.
    pub name: String,
    /// Times in seconds, ascending, and angles in degrees; straight lines between, and the ends hold.
    pub points_s_deg: Vec<[f64; 2]>,
}

impl Joint {
    /// The angle at a time in seconds, degrees; 0 for a joint without a point.
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        interpolated(&self.points_s_deg, t_s).unwrap_or(0.0)
    }

    fn check(&self, source: &Source, key: &str) -> Result<(), FileError> {
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if self.name.is_empty() || !self.name.chars().all(letter) {
            let expected = "a name of letters, digits, `_` and `-`";
            return Err(source.bad(&format!("{key}.name"), expected));
        }
        let (key, most) = (format!("{key}.points_s_deg"), -MOST_DEG..=MOST_DEG);
        check_points(&self.points_s_deg, source, &key, (most, "degrees"))
    }
}

/// Checks points over time: one at least, times in seconds that ascend, and values in a range of this unit.
pub(super) fn check_points(
    points: &[[f64; 2]],
    source: &Source,
    key: &str,
    (range, unit): (RangeInclusive<f64>, &str),
) -> Result<(), FileError> {
    if points.is_empty() {
        let expected = format!("at least one point: [seconds, {unit}]");
        return Err(source.bad(key, expected));
    }
    let mut from = 0.0;
    for (index, [t_s, value]) in points.iter().enumerate() {
        let key = format!("{key}[{index}]");
        source.range(&key, t_s, 0.0..=86_400.0, "s")?;
        source.range(&key, value, range.clone(), unit)?;
        if index > 0 && *t_s <= from {
            return Err(source.bad(&key, format!("a time after {from} s")));
        }
        from = *t_s;
    }
    Ok(())
}

/// Checks all joints of a scene.
pub(super) fn check(joints: &[Joint], source: &Source) -> Result<(), FileError> {
    for (index, joint) in joints.iter().enumerate() {
        let key = format!("joints[{index}]");
        joint.check(source, &key)?;
        if joints[..index].iter().any(|j| j.name == joint.name) {
            return Err(source.bad(&format!("{key}.name"), "a name of its own"));
        }
    }
    Ok(())
}

/// Condition under which a finger is felt: a joint's angle is in a range.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct When {
    /// The joint's name.
    pub joint: String,
    /// Felt above this angle, degrees; left out: no lower bound.
    pub above_deg: Option<f64>,
    /// Felt below this angle, degrees; left out: no upper bound.
    pub below_deg: Option<f64>,
}

impl When {
    /// Checks the bounds by themselves.
    pub(super) fn check(&self, source: &Source, key: &str) -> Result<(), FileError> {
        bounds!(source, key, self;
            above_deg: -MOST_DEG..=MOST_DEG, "degrees";
            below_deg: -MOST_DEG..=MOST_DEG, "degrees")?;
        match (self.above_deg, self.below_deg) {
            (None, None) => Err(source.bad(key, "above_deg, below_deg or both")),
            (Some(above), Some(below)) if above >= below => {
                let expected = format!("more than above_deg, {above} degrees");
                Err(source.bad(&format!("{key}.below_deg"), expected))
            }
            _ => Ok(()),
        }
    }
}

/// A condition on one of a scene's joints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gate {
    /// The joint, counted from zero.
    pub joint: usize,
    /// Open above this, degrees.
    pub above_deg: f64,
    /// Open below this, degrees.
    pub below_deg: f64,
}

impl Gate {
    /// The gate of a condition, on these joints.
    pub(super) fn new(
        when: &When,
        joints: &[Joint],
        source: &Source,
        key: &str,
    ) -> Result<Self, FileError> {
        let joint = joints.iter().position(|j| j.name == when.joint);
        let joint = joint.ok_or_else(|| {
            let names: Vec<&str> = joints.iter().map(|j| &*j.name).collect();
            let there = match names.as_slice() {
                [] => "there is none".to_owned(),
                names => names.join(", "),
            };
            let expected = format!(
                "a joint of [[joints]], or of a recording with a column joint_NAME: {there}"
            );
            source.bad_found(
                &format!("{key}.joint"),
                expected,
                format!("`{}`", when.joint),
            )
        })?;
        Ok(Self {
            joint,
            above_deg: when.above_deg.unwrap_or(f64::NEG_INFINITY),
            below_deg: when.below_deg.unwrap_or(f64::INFINITY),
        })
    }

    /// Returns true if a finger is felt at a time in seconds.
    #[must_use]
    pub fn is_open(&self, joints: &[Joint], t_s: f64) -> bool {
        let angle = joints.get(self.joint).map(|joint| joint.at(t_s));
        angle.is_some_and(|deg| deg > self.above_deg && deg < self.below_deg)
    }
}
