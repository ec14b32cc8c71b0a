//! Touches of the skin: their place and force at any time. Pure: the same time gives the same bits everywhere.

mod hand;

use core::f64::consts::TAU;

use serde::Deserialize;

use super::error::FileError;
use super::settings::bounds;
use super::source::Source;
pub use hand::{HandSample, MOST_SAMPLES, check_sample};

/// One sphere on one module.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Touch {
    /// The touched module, counted from zero.
    #[serde(default)]
    pub module: usize,
    /// The sphere's diameter in millimetres.
    #[serde(default = "sphere_mm")]
    pub diameter_mm: f64,
    /// First contact in seconds.
    pub start_s: f64,
    /// Last contact in seconds; left out: the end of the scene.
    #[serde(default = "with_the_scene")]
    pub end_s: f64,
    /// Time over which the force rises and falls smoothly at either end, seconds.
    #[serde(default = "ramp_s")]
    pub ramp_s: f64,
    /// The path of its centre.
    pub path: Path,
    /// The force; a hand's samples state it themselves.
    #[serde(default = "no_force")]
    pub force_n: Force,
}

/// The sphere of the published measurements.
pub(super) const fn sphere_mm() -> f64 {
    19.45
}

/// End without a statement of a file: [`Touch::last`] puts the scene's length in its place.
const fn with_the_scene() -> f64 {
    f64::INFINITY
}

const fn ramp_s() -> f64 {
    0.2
}

const fn wave_s() -> f64 {
    1.0
}

/// Force of a hand, which its samples state; [`Touch::check`] refuses any other touch without a force.
const fn no_force() -> Force {
    Force {
        mean: 0.0,
        amplitude: 0.0,
        period_s: wave_s(),
    }
}

/// Path of a touch, in the module's millimetres.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Path {
    /// The path's shape.
    pub kind: PathKind,
    /// Points of the path: one for hold, two for line, two or more for polyline.
    #[serde(default)]
    pub points_mm: Vec<[f64; 2]>,
    /// Centre of a circle; left out: the module's.
    pub centre_mm: Option<[f64; 2]>,
    /// Radius of a circle.
    pub radius_mm: Option<f64>,
    /// Period of a path: there and back for line and polyline, one turn for circle. Left out: once, from start to
    /// end.
    pub period_s: Option<f64>,
    /// Samples of a hand, `[t_us, x_um, y_um, force_mn, diameter_um]` each: each holds until the next one.
    #[serde(default)]
    pub samples: Vec<HandSample>,
}

/// The shapes of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum PathKind {
    /// One point.
    Hold,
    /// A straight line at constant speed, there and back.
    Line,
    /// A way along corners at constant speed, there and back.
    Polyline,
    /// A circle, anticlockwise from the right.
    Circle,
    /// A person's motion: its place, force and width by its samples, without ramps.
    Hand,
}

/// Force of mean + amplitude sin(2 pi t / period), t from the touch's start.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Force {
    /// Mean force, newtons.
    pub mean: f64,
    /// Amplitude, newtons, at most the mean.
    #[serde(default)]
    pub amplitude: f64,
    /// Period, seconds.
    #[serde(default = "wave_s")]
    pub period_s: f64,
}

/// A touch at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TouchPoint {
    /// Distance to the right of the module's centre, mm.
    pub x_mm: f64,
    /// Distance up from the module's centre, mm.
    pub y_mm: f64,
    /// Force, newtons; zero at the very first and last instant.
    pub force_n: f64,
    /// Diameter of the sphere, mm.
    pub diameter_mm: f64,
}

impl Touch {
    /// A touch by hand on a module, which begins with its first sample and has no other yet. It does not end.
    #[must_use]
    pub fn by_hand(module: usize, first: HandSample) -> Self {
        Self {
            module,
            diameter_mm: sphere_mm(),
            start_s: first[0] as f64 / 1e6,
            end_s: with_the_scene(),
            ramp_s: ramp_s(),
            path: Path {
                kind: PathKind::Hand,
                points_mm: Vec::new(),
                centre_mm: None,
                radius_mm: None,
                period_s: None,
                samples: vec![first],
            },
            force_n: no_force(),
        }
    }

    /// Goes on with a sample of a hand; one that changes nothing is left out.
    pub(super) fn follow(&mut self, sample: HandSample) {
        let samples = &mut self.path.samples;
        if samples.last().is_none_or(|last| last[1..] != sample[1..]) {
            samples.push(sample);
        }
    }

    /// The touch at `t_s` seconds of the scene; none before its start and after its end.
    #[must_use]
    pub fn at(&self, t_s: f64) -> Option<TouchPoint> {
        if !(self.start_s..=self.end_s).contains(&t_s) {
            return None;
        }
        if self.path.kind == PathKind::Hand {
            return hand::at(&self.path.samples, t_s);
        }
        let since = t_s - self.start_s;
        let [x_mm, y_mm] = self.path.at(since, self.end_s - self.start_s);
        let ramp = smooth(since / self.ramp_s) * smooth((self.end_s - t_s) / self.ramp_s);
        let wave = libm::sin(TAU * since / self.force_n.period_s);
        Some(TouchPoint {
            x_mm,
            y_mm,
            force_n: ramp * (self.force_n.mean + self.force_n.amplitude * wave),
            diameter_mm: self.diameter_mm,
        })
    }

    /// Ends with the scene where the file states no end.
    pub(super) const fn last(&mut self, length_s: f64) {
        if self.end_s.is_infinite() {
            self.end_s = length_s;
        }
    }

    /// Checks the touch that stands under `key`.
    pub(super) fn check(&self, source: &Source, key: &str, length_s: f64) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        bounds!(source, key, self;
            diameter_mm: 0.5..=500.0, "mm";
            start_s: 0.0..=length_s, "s";
            end_s: 0.0..=length_s, "s (the scene's length)")?;
        if self.end_s <= self.start_s {
            return Err(source.bad(
                &at("end_s"),
                format!("more than start_s = {}", self.start_s),
            ));
        }
        if self.path.kind == PathKind::Hand {
            return hand::check(self, source, key, length_s);
        }
        if !self.path.samples.is_empty() {
            return Err(source.bad(&at("path.samples"), "this key for a hand only"));
        }
        if !source.states(&at("force_n")) {
            return Err(source.bad(&at("force_n"), "a force, such as { mean = 0.7 }"));
        }
        let longest = (self.end_s - self.start_s) / 2.0;
        bounds!(source, key, self;
            ramp_s: 0.001..=longest, "s";
            force_n.mean: 0.0..=20.0, "N";
            force_n.amplitude: 0.0..=self.force_n.mean, "N (the mean)";
            force_n.period_s: 0.01..=3600.0, "s")?;
        self.path.check(source, &at("path"))
    }
}

impl Path {
    fn at(&self, since: f64, whole: f64) -> [f64; 2] {
        let period = self.period_s;
        match self.kind {
            PathKind::Hand => [0.0; 2], // its samples say where
            PathKind::Hold => self.points_mm.first().copied().unwrap_or_default(),
            PathKind::Circle => {
                let [x, y] = self.centre_mm.unwrap_or_default();
                let radius = self.radius_mm.unwrap_or_default();
                let angle = TAU * since / period.unwrap_or(whole);
                [x + radius * libm::cos(angle), y + radius * libm::sin(angle)]
            }
            PathKind::Line | PathKind::Polyline => {
                let along = period.map_or(since / whole, |period| {
                    let turns = since / period;
                    let phase = 2.0 * (turns - libm::floor(turns));
                    if phase < 1.0 { phase } else { 2.0 - phase }
                });
                along_corners(&self.points_mm, along)
            }
        }
    }

    fn check(&self, source: &Source, key: &str) -> Result<(), FileError> {
        let at = |name: &str| format!("{key}.{name}");
        let circle = self.kind == PathKind::Circle;
        let (points, expected) = match self.kind {
            PathKind::Hold => (1..=1, "one point for a hold"),
            PathKind::Line => (2..=2, "two points for a line"),
            PathKind::Polyline => (2..=1000, "2 to 1000 points for a polyline"),
            PathKind::Circle => (0..=0, "no points for a circle"),
            PathKind::Hand => (0..=0, "no points for a hand, whose samples say where"),
        };
        if !points.contains(&self.points_mm.len()) {
            return Err(source.bad(&at("points_mm"), expected));
        }
        bounds!(source, key, self; points_mm: -1e3..=1e3, "mm")?;
        let moves = self
            .points_mm
            .windows(2)
            .any(|pair| distance(pair[0], pair[1]) > 0.0);
        if self.points_mm.len() > 1 && !moves {
            return Err(source.bad(&at("points_mm"), "points apart from one another"));
        }
        if circle && self.radius_mm.is_none() {
            return Err(source.bad(&at("radius_mm"), "a value for a circle"));
        }
        for (name, given) in [
            ("centre_mm", self.centre_mm.is_some()),
            ("radius_mm", self.radius_mm.is_some()),
        ] {
            if given && !circle {
                return Err(source.bad(&at(name), "this key for circles only"));
            }
        }
        bounds!(source, key, self;
            centre_mm: -1e3..=1e3, "mm";
            radius_mm: 0.01..=1e3, "mm")?;
        if self.period_s.is_some() && self.kind == PathKind::Hold {
            return Err(source.bad(&at("period_s"), "no period for a hold"));
        }
        bounds!(source, key, self; period_s: 0.01..=3600.0, "s")
    }
}

/// The point a share of the way (0 to 1) along the corners, by length.
fn along_corners(points: &[[f64; 2]], share: f64) -> [f64; 2] {
    let total: f64 = points
        .windows(2)
        .map(|pair| distance(pair[0], pair[1]))
        .sum();
    let mut left = share * total;
    for pair in points.windows(2) {
        let length = distance(pair[0], pair[1]);
        if left <= length && length > 0.0 {
            let part = left / length;
            return [0, 1].map(|axis| pair[0][axis] + part * (pair[1][axis] - pair[0][axis]));
        }
        left -= length;
    }
    points.last().copied().unwrap_or_default()
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(b[0] - a[0], b[1] - a[1])
}

/// Step from 0 to 1 with a level start and end.
fn smooth(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}
