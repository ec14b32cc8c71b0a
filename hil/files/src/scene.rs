//! Scenes: what touches which skin, and how it is compressed and projected.

use serde::Deserialize;

use super::{Fault, Felt, FileError, Illusion, Source, Stroke, Touch};

/// A closed list of words.
macro_rules! choice {
    ($(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $text:literal),+ $(,)? }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
        #[cfg_attr(test, derive(schemars::JsonSchema))]
        pub enum $name { $($(#[$variant_doc])* #[serde(rename = $text)] $variant),+ }
    };
}

pub(super) use choice;

choice! { /** A sensor generation: its values at rest. */ Generation {
    /** X and Y near 16.4k, Z 32k to 36k. */ Y2019 = "2019",
    /** X near 48.9k, Y 16.4k, Z 37.4k. */ Y2021 = "2021",
    /** X and Y near 32.8k, Z 37.4k. */ Current = "current",
}}
choice! { /** How a taxel's axes make one weight. */ Norm {
    /** Sum of absolute values. */ L1 = "l1",
    /** Euclidean. */ L2 = "l2",
    /** Largest absolute value. */ Linf = "linf",
}}
choice! { /** The axes that count. */ Axes {
    /** All three. */ Xyz = "xyz",
    /** The normal one. */ Z = "z",
}}
choice! { /** Where the contact threshold comes from. */ ThresholdRule {
    /** The largest value of the first frame after the reference, for all taxels: the thesis's (4.3). */
    Maximum = "maximum",
    /** Six standard deviations of every taxel's own noise. */ PerTaxel = "per-taxel",
}}
choice! { /** Where `kc` and `ki` apply. */ Scope {
    /** To each module. */ Module = "module",
    /** To the whole skin in one plane. */ Skin = "skin",
}}
choice! { /** What a board does when a scan is due and frames of the last one have not left. */ Overload {
    /** The next scan starts at the first tick after the last frame left. */ Wait = "wait",
    /** Every scan replaces what still waits; high identifiers starve. */ Overwrite = "overwrite",
}}

/// Standard deviations of a taxel's noise that its own threshold lies above its reference.
pub const THRESHOLD_SIGMAS: f64 = 6.0;
/// Counts that a recording's thresholds lie above that: fainter differences on real boards are not touch.
pub const THRESHOLD_FLOOR: f64 = 20.0;
/// Time constant of drift following on recordings, seconds: boards drift by about 1000 counts in minutes.
pub const DRIFT_S: f64 = 5.0;

const fn per_taxel() -> ThresholdRule {
    ThresholdRule::PerTaxel
}

/// A scene.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Lower case with hyphens.
    pub name: String,
    /// What happens, in a sentence.
    pub description: String,
    /// Simulated length in seconds.
    pub length_s: f64,
    /// A sensor layout: a built-in name or a file.
    pub layout: String,
    /// The sensor generation.
    pub generation: Generation,
    /// Frames a second.
    pub rate_hz: f64,
    /// Range from which each taxel draws its noise's standard deviation, in counts.
    pub noise_lsb: [f64; 2],
    /// Contact-free frames that make the reference; the next one makes the threshold.
    pub reference_frames: u32,
    /// Where the contact threshold comes from; left out: every taxel's own noise.
    #[serde(default = "per_taxel")]
    pub threshold: ThresholdRule,
    /// Counts added to the threshold.
    pub threshold_margin: f64,
    /// Time constant in seconds with which the reference follows a taxel not in contact; left out: it stays.
    pub drift_s: Option<f64>,
    /// A taxel this many standard deviations from the mean of its axis is faulty; left out: none is.
    pub faulty_deviations: Option<f64>,
    /// The module that drives the display, counted from zero.
    pub drives: usize,
    /// Contacts and levels.
    pub compression: Compression,
    /// Activations and timing.
    pub illusion: Illusion,
    /// From skin to display.
    #[serde(default)]
    pub map: Map,
    /// The sensor boards on their buses.
    #[serde(default)]
    pub boards: Boards,
    /// What touches the skin; nothing if left out.
    #[serde(default)]
    pub touches: Vec<Touch>,
    /// Strokes over the display that are known beforehand; none if left out.
    #[serde(default)]
    pub strokes: Vec<Stroke>,
    /// The texture that is felt; none if left out.
    pub texture: Option<Felt>,
    /// What goes wrong on an emulated bench; nothing if left out.
    #[serde(default)]
    pub faults: Vec<Fault>,
    /// What a test of this scene checks.
    #[serde(default)]
    pub expect: Expect,
}

/// Contact compression.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Compression {
    /// Most contacts a frame.
    pub kc: u32,
    /// Intensity levels.
    pub ki: u32,
    /// Weight = norm to this power.
    pub weight_exponent: f64,
    /// The weight's norm.
    pub norm: Norm,
    /// The axes that count.
    pub axes: Axes,
    /// Where `kc` and `ki` apply.
    pub scope: Scope,
    /// Most iterations of K-means a frame; left out: 32.
    pub iterations: Option<u32>,
}

/// The linear map from skin to display.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Map {
    /// Sensor rectangle (left, bottom, right, top) that fills the display; left out: the taxels' hull.
    pub sensor_mm: Option<[f64; 4]>,
    /// The display layout this scene needs; left out: whatever the bench carries.
    pub display: Option<String>,
}

/// The sensor boards of an emulated skin.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Boards {
    /// Puts every board on this bus; left out: as the layout says.
    pub bus: Option<u8>,
    /// Boards on an overloaded bus; left out: they wait.
    pub overload: Option<Overload>,
}

/// Bounds that a test of this scene checks; those left out are not checked.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Expect {
    /// Largest root mean square error of the contact path.
    pub path_rmse_mm: Option<f64>,
    /// Largest single error of the contact path.
    pub path_max_mm: Option<f64>,
    /// Largest root mean square error of the felt path.
    pub felt_rmse_mm: Option<f64>,
    /// Most contacts in any frame.
    pub contacts_max: Option<u32>,
    /// Most events of the limiter.
    pub limiter_events_max: Option<u32>,
    /// The emulated hardware passes a limit, as after a fault that no software can end; left out: it may pass none.
    #[serde(default)]
    pub over_limit: bool,
}

impl Scene {
    /// Reads and checks a scene by itself; [`crate::Setup`] checks it against its layout and bench.
    ///
    /// # Errors
    /// Names the line and key of what cannot be.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let scene: Self = source.read()?;
        source.heading(&scene.name, &scene.description)?;
        source.range("length_s", scene.length_s, 0.01..=86_400.0, "s")?;
        source.range("rate_hz", scene.rate_hz, 0.1..=10_000.0, "Hz")?;
        let [low, high] = scene.noise_lsb;
        source.range("noise_lsb", low, 0.0..=1000.0, "counts")?;
        source.range("noise_lsb", high, low..=1000.0, "counts (the lower end)")?;
        source.range("reference_frames", scene.reference_frames, 1..=100_000, "")?;
        source.range(
            "threshold_margin",
            scene.threshold_margin,
            0.0..=65_535.0,
            "counts",
        )?;
        if let Some(constant) = scene.drift_s {
            source.range("drift_s", constant, 0.01..=86_400.0, "s")?;
        }
        if let Some(k) = scene.faulty_deviations {
            source.range("faulty_deviations", k, 0.1..=1000.0, "")?;
        }
        source.range("compression.kc", scene.compression.kc, 1..=1024, "")?;
        source.range("compression.ki", scene.compression.ki, 1..=256, "")?;
        source.range(
            "compression.weight_exponent",
            scene.compression.weight_exponent,
            0.0..=16.0,
            "",
        )?;
        if let Some(most) = scene.compression.iterations {
            source.range("compression.iterations", most, 1..=1000, "")?;
        }
        scene.illusion.check(source)?;
        scene.check_map(source)?;
        let quiet_s = f64::from(scene.reference_frames + 1) / scene.rate_hz;
        for (index, touch) in scene.touches.iter().enumerate() {
            let key = format!("touches[{index}]");
            touch.check(source, &key, scene.length_s)?;
            if touch.start_s < quiet_s {
                let expected = format!(
                    "at least {quiet_s} s: reference and threshold frames are contact-free"
                );
                return Err(source.bad(&format!("{key}.start_s"), expected));
            }
        }
        if let Some(texture) = &scene.texture {
            texture.check(source, quiet_s, scene.length_s)?;
        }
        let mut free_s = 0.0;
        for (index, stroke) in scene.strokes.iter().enumerate() {
            stroke.check(source, &format!("strokes[{index}]"), free_s, scene.length_s)?;
            free_s = stroke.start_s + stroke.length_s;
        }
        for (index, fault) in scene.faults.iter().enumerate() {
            fault.check(source, &format!("faults[{index}]"), scene.length_s)?;
        }
        scene.expect.check(source)?;
        Ok(scene)
    }

    fn check_map(&self, source: &Source) -> Result<(), FileError> {
        let Some([left, bottom, right, top]) = self.map.sensor_mm else {
            return Ok(());
        };
        for (corner, value) in [left, bottom, right, top].into_iter().enumerate() {
            source.range(&format!("map.sensor_mm[{corner}]"), value, -1e4..=1e4, "mm")?;
        }
        if left >= right || bottom >= top {
            return Err(source.bad("map.sensor_mm", "[left, bottom, right, top] with an area"));
        }
        Ok(())
    }
}

impl Expect {
    fn check(&self, source: &Source) -> Result<(), FileError> {
        for (key, value) in [
            ("expect.path_rmse_mm", self.path_rmse_mm),
            ("expect.path_max_mm", self.path_max_mm),
            ("expect.felt_rmse_mm", self.felt_rmse_mm),
        ] {
            if let Some(value) = value {
                source.range(key, value, 0.0..=1e4, "mm")?;
            }
        }
        Ok(())
    }
}
