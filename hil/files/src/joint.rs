//! Joints of the hand that a skin is on: their angles over time, and the conditions of a scene that depend on them.

use std::ops::RangeInclusive;

use palpate_core::statistics::interpolated;
use serde::Deserialize;

use super::error::FileError;
use super::settings::bounds;
use super::source::Source;
use super::touch::{MOST_SAMPLES, Touch, TouchPoint, sphere_mm};

/// Largest angle of a joint, degrees either way.
pub const MOST_DEG: f64 = 360.0;
/// Farthest place of a press from its module's centre, mm.
const MOST_MM: f64 = 1e3;
/// Largest force of a press, N.
const MOST_N: f64 = 20.0;
/// Samples of a joint's press in a second.
const SAMPLES_HZ: f64 = 100.0;

/// A joint's angle over time.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// The joint's name: letters, digits, `_` and `-`.
    pub name: String,
    /// Times in seconds, ascending, and angles in degrees; straight lines between, and the ends hold.
    pub points_s_deg: Vec<[f64; 2]>,
    /// Press of the emulated hand's skin as the joint bends; none if left out.
    pub press: Option<JointPress>,
}

/// Press of a module by a thing at rest that the finger meets as its joint bends.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct JointPress {
    /// The pressed module, counted from zero.
    #[serde(default)]
    pub module: usize,
    /// Angle at which the finger meets the thing, degrees.
    pub from_deg: f64,
    /// Force per degree beyond that angle, N; a press has at most 20 N.
    pub n_per_deg: f64,
    /// Place of the first contact, mm from the module's centre.
    #[serde(default)]
    pub from_mm: [f64; 2],
    /// Way of the contact over the module per degree, mm.
    #[serde(default)]
    pub mm_per_deg: [f64; 2],
    /// Diameter of the thing, mm.
    #[serde(default = "sphere_mm")]
    pub diameter_mm: f64,
}

impl JointPress {
    /// The press at an angle, degrees; a force of zero before the finger meets the thing.
    #[must_use]
    pub fn at(&self, deg: f64) -> TouchPoint {
        let beyond = (deg - self.from_deg).max(0.0);
        let [x_mm, y_mm] = [0, 1].map(|axis| self.from_mm[axis] + self.mm_per_deg[axis] * beyond);
        TouchPoint {
            x_mm: x_mm.clamp(-MOST_MM, MOST_MM),
            y_mm: y_mm.clamp(-MOST_MM, MOST_MM),
            force_n: (self.n_per_deg * beyond).min(MOST_N),
            diameter_mm: self.diameter_mm,
        }
    }

    fn check(&self, source: &Source, key: &str) -> Result<(), FileError> {
        bounds!(source, key, self;
            from_deg: -MOST_DEG..=MOST_DEG, "degrees";
            n_per_deg: 0.0..=MOST_N, "N per degree";
            diameter_mm: 0.5..=500.0, "mm")?;
        for axis in 0..2 {
            let [from, way] = ["from_mm", "mm_per_deg"].map(|name| format!("{key}.{name}[{axis}]"));
            source.range(&from, &self.from_mm[axis], -MOST_MM..=MOST_MM, "mm")?;
            source.range(
                &way,
                &self.mm_per_deg[axis],
                -MOST_MM..=MOST_MM,
                "mm per degree",
            )?;
        }
        Ok(())
    }
}

impl Joint {
    /// The angle at a time in seconds, degrees; 0 for a joint without a point.
    #[must_use]
    pub fn at(&self, t_s: f64) -> f64 {
        interpolated(&self.points_s_deg, t_s).unwrap_or(0.0)
    }

    /// The touch that the joint's press makes over a scene's length in seconds; `None` where it never presses.
    fn touch(&self, length_s: f64) -> Option<Touch> {
        let press = self.press?;
        let mut made: Option<Touch> = None;
        for n in 0..=(length_s * SAMPLES_HZ) as i64 {
            let t_us = (n as f64 * 1e6 / SAMPLES_HZ).round() as i64;
            let point = press.at(self.at(t_us as f64 * 1e-6));
            let thousandths = |value: f64| (value * 1e3).round() as i64;
            let [x_mm, y_mm, wide_mm] = [point.x_mm, point.y_mm, point.diameter_mm];
            let [x, y, force, wide] = [x_mm, y_mm, point.force_n, wide_mm].map(thousandths);
            let sample = [t_us, x, y, force, wide];
            match &mut made {
                None if force > 0 => made = Some(Touch::by_hand(press.module, sample)),
                None => {}
                Some(touch) => touch.follow(sample),
            }
        }
        made.as_mut()?.last(length_s);
        made
    }

    /// Checks the joint that stands under `key`, of a scene that lasts `length_s` and presses nothing before `quiet_s`.
    fn check(
        &self,
        source: &Source,
        key: &str,
        (quiet_s, length_s): (f64, f64),
    ) -> Result<(), FileError> {
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if self.name.is_empty() || !self.name.chars().all(letter) {
            let expected = "a name of letters, digits, `_` and `-`";
            return Err(source.bad(&format!("{key}.name"), expected));
        }
        let (points, most) = (format!("{key}.points_s_deg"), -MOST_DEG..=MOST_DEG);
        check_points(&self.points_s_deg, source, &points, (most, "degrees"))?;
        let Some(press) = &self.press else {
            return Ok(());
        };
        let key = format!("{key}.press");
        press.check(source, &key)?;
        if length_s * SAMPLES_HZ >= MOST_SAMPLES as f64 {
            let most_s = MOST_SAMPLES as f64 / SAMPLES_HZ;
            let expected = format!("no press in a scene longer than {most_s} s");
            return Err(source.bad_found(&key, expected, format!("a press over {length_s} s")));
        }
        let early = self.touch(length_s).filter(|t| t.start_s < quiet_s);
        early.map_or(Ok(()), |touch| {
            let expected = format!("an angle that presses nothing until {quiet_s} s");
            Err(source.bad_found(&key, expected, format!("a press at {} s", touch.start_s)))
        })
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

/// Touches of all joints that press, over a scene's length in seconds.
pub(super) fn touches(joints: &[Joint], length_s: f64) -> impl Iterator<Item = Touch> {
    joints.iter().filter_map(move |joint| joint.touch(length_s))
}

/// Checks all joints of a scene, which presses nothing until the first of two times and ends at the second, s.
pub(super) fn check(
    joints: &[Joint],
    source: &Source,
    span_s: (f64, f64),
) -> Result<(), FileError> {
    for (index, joint) in joints.iter().enumerate() {
        let key = format!("joints[{index}]");
        joint.check(source, &key, span_s)?;
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

#[cfg(test)]
#[path = "joint_tests.rs"]
mod tests;
