//! Scenes: touches of a skin, their compression and their projection.

use palpate_core::contact::{Norm, Scope};
use palpate_core::skin::{Axes, ThresholdRule};
use serde::Deserialize;

use super::error::FileError;
use super::fault::Fault;
use super::felt::Felt;
use super::finger::SceneFinger;
use super::illusion::{Illusion, SceneStroke};
use super::joint::{self, Joint};
use super::seat::{self, Seat};
use super::settings::{bounds, settings};
use super::source::Source;
use super::stream::Stream;
use super::touch::Touch;
use super::wants;
use super::warmth::SceneMaterial;
use super::words::{self, choice};

choice! { /** A sensor generation: its values at rest. */ Generation {
    /** X and Y near 16.4k, Z 32k to 36k. */ Y2019 = "2019",
    /** X near 48.9k, Y 16.4k, Z 37.4k. */ Y2021 = "2021",
    /** X and Y near 32.8k, Z 37.4k. */ Current = "current",
}}
choice! { /** Rules that find the contact threshold. */ ThresholdFrom {
    /** The largest value of the first frame after the reference, for all taxels: the thesis's (4.3). */
    Maximum = "maximum",
    /** Six standard deviations of every taxel's own noise. */ PerTaxel = "per-taxel",
}}
choice! { /** Reactions of a board to a scan that is due before all frames of the last one have left. */ Overload {
    /** The next scan starts at the first tick after the last frame left. */ Wait = "wait",
    /** Every scan replaces what still waits; high identifiers starve. */ Overwrite = "overwrite",
}}

choice! { /** Rules that find intensity levels. */ LevelsFrom {
    /** Levels over the whole input: an emulated or replayed run has a pass more, a real one goes by the scene's touches. */
    Static = "static",
    /** Levels anew in every frame, among its contacts: the strongest has the top level. */ Dynamic = "dynamic",
}}

/// Distance of a taxel's own threshold from its reference, standard deviations of its noise.
pub const THRESHOLD_SIGMAS: f64 = 6.0;
/// Counts added to a recording's thresholds: fainter differences on real boards are no touch.
pub const THRESHOLD_FLOOR: f64 = 20.0;
/// Time constant of drift following on recordings, seconds: boards drift by about 1000 counts in minutes.
pub const DRIFT_S: f64 = 5.0;

/// Rows that make the reference of a recording or stream; the reference follows drift from there.
pub const REFERENCE_ROWS: u32 = 10;

settings! {
    /// A scene. A file states what differs from [`Scene::default`], and its name and description.
    #[cfg_attr(test, schemars(extend("required" = ["name", "description"])))]
    pub struct Scene {
        /// Name, in lower case with hyphens.
        pub name: String,
        /// The events of the scene, in a sentence.
        pub description: String,
        /// The thing that the bench must have: `unit` (a driver unit), `warmth` (a Peltier module), `fingers`
        /// (several displays), or the name of a bench that ships. Left out: nothing but a display.
        #[cfg_attr(test, schemars(extend("examples" = ["unit", "warmth", "fingers"])))]
        pub wants: Option<String>,
        /// Simulated length in seconds.
        pub length_s: f64 = 10.0,
        /// A sensor layout: a built-in name or a file.
        pub layout: String = "uskin-4x4".into(),
        /// The sensor generation.
        pub generation: Generation = Generation::Current,
        /// Frames per second.
        pub rate_hz: f64 = 100.0,
        /// Range from which each taxel draws its noise's standard deviation, in counts.
        pub noise_lsb: [f64; 2] = [1.0, 2.3],
        /// Contact-free frames that make the reference; the next one makes the threshold.
        pub reference_frames: u32 = 50,
        /// The rule that finds the contact threshold.
        pub threshold: ThresholdFrom = ThresholdFrom::PerTaxel,
        /// Excess of the threshold, counts.
        pub threshold_margin: f64 = 10.0,
        /// Time constant in seconds with which the reference follows a taxel that nothing touches; left out: it
        /// stays.
        pub drift_s: Option<f64>,
        /// Deviation from the mean of its axis beyond which a taxel is faulty, standard deviations; left out: none
        /// is.
        pub faulty_deviations: Option<f64>,
        /// The module that drives a bench's only display, counted from zero.
        pub drives: usize = 0,
        /// The modules of each of a bench's several displays, in place of `drives`.
        pub fingers: Vec<SceneFinger>,
        /// Angles of joints over time, kept in records; a finger may depend on them. None if left out.
        pub joints: Vec<Joint>,
        /// Contacts and levels.
        pub compression: Compression,
        /// Activations and timing.
        pub illusion: Illusion,
        /// The map from skin to display.
        pub map: Map,
        /// The sensor boards on their buses.
        pub boards: Boards,
        /// The way of readings that another machine takes and sends; left out: boards on buses, where the layout has any.
        pub stream: Option<Stream>,
        /// Touches of the skin; none if left out.
        pub touches: Vec<Touch>,
        /// Materials of the things touched, for a bench with a Peltier module; skin at rest where none is stated.
        pub materials: Vec<SceneMaterial>,
        /// Strokes over the only display of a bench that are known beforehand; none if left out.
        pub strokes: Vec<SceneStroke>,
        /// The texture that is felt on the only display of a bench; none if left out.
        pub texture: Option<Felt>,
        /// Contact of single wires with the emulated finger over time; left out: all lie on it evenly.
        pub seats: Vec<Seat>,
        /// Faults of an emulated bench; none if left out.
        pub faults: Vec<Fault>,
        /// Expectations that a test of this scene checks.
        pub expect: Expect,
    }

    /// The scene of ten seconds of a flat module that nothing touches, without a name.
    default
}

settings! {
    /// Contact compression.
    #[derive(Copy)]
    pub struct Compression {
        /// Most contacts per frame.
        pub kc: u32 = 1,
        /// Most that `kc` grows to on an emulated skin, with the touches that press.
        pub kc_touches: u32 = 1,
        /// Intensity levels.
        pub ki: u32 = 10,
        /// The rule that finds levels.
        pub levels: LevelsFrom = LevelsFrom::Static,
        /// True for intensities and levels along x, y and z in place of their magnitudes, (4.9) to (4.15).
        pub vectors: bool = false,
        /// Exponent of the norm in the weight.
        pub weight_exponent: f64 = 2.0,
        /// The weight's norm.
        #[serde(with = "words::Norm")]
        pub norm: Norm = Norm::L2,
        /// The axes that count.
        #[serde(with = "words::axes")]
        #[cfg_attr(test, schemars(with = "words::Axes"))]
        pub axes: Axes = Axes::XYZ,
        /// The part of the skin over which `kc` and `ki` apply.
        #[serde(with = "words::Scope")]
        pub scope: Scope = Scope::Module,
        /// Most iterations of K-means per frame.
        pub iterations: u32 = 32,
        /// zeta_C of (4.8), mm: half the summed moves of the centroids at which K-means ends.
        pub stop_mm: f64 = 0.001,
    }
}

settings! {
    /// The linear map from skin to display. Contacts outside its rectangle are not felt.
    pub struct Map {
        /// Sensor rectangle (left, bottom, right, top) that fills the display; left out: the taxels' hull.
        pub sensor_mm: Option<[f64; 4]>,
        /// Width and height, mm, of a window that follows the contacts on a larger skin and fills the display; left
        /// out: it stays.
        pub window_mm: Option<[f64; 2]>,
        /// Share by which a contact outside must exceed all inside together to move the window.
        pub hysteresis: f64 = 0.25,
        /// The display layout this scene needs; left out: whatever the bench carries.
        pub display: Option<String>,
    }
}

impl Compression {
    /// The most contacts of a frame, whatever touches.
    #[must_use]
    pub fn most_contacts(&self) -> u32 {
        self.kc.max(self.kc_touches)
    }
}

/// The sensor boards of an emulated skin.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Boards {
    /// Bus of every board; left out: as the layout states.
    pub bus: Option<u8>,
    /// Boards on an overloaded bus; left out: they wait.
    pub overload: Option<Overload>,
}

/// Bounds that a test of this scene checks; bounds left out are not checked.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
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
    /// Least share of the onsets that the person feels, 0 to 1; left out: any.
    pub felt_share_min: Option<f64>,
    /// Largest share of the touched onsets beyond the part of the skin that the display shows, 0 to 1; left out: any.
    pub off_pad_share_max: Option<f64>,
    /// True if the emulated hardware passes a limit, as after a fault that no software can end; left out: it may pass
    /// none.
    pub over_limit: bool,
}

impl Scene {
    /// Reads and checks a scene by itself; [`crate::Setup`] checks it against its layout and bench.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: &Source) -> Result<Self, FileError> {
        let mut scene: Self = source.read()?;
        source.heading(&scene.name, &scene.description)?;
        if let Some(wanted) = &scene.wants {
            wants::check(wanted, source)?;
        }
        bounds!(source, "", scene; length_s: 0.01..=86_400.0, "s")?;
        for touch in &mut scene.touches {
            touch.last(scene.length_s);
        }
        scene.check_skin(source)?;
        bounds!(source, "compression", scene.compression;
            kc: 1..=1024;
            kc_touches: 1..=1024;
            ki: 1..=256;
            weight_exponent: 0.0..=16.0;
            iterations: 1..=1000;
            stop_mm: 0.0..=100.0, "mm")?;
        scene.illusion.check(source)?;
        scene.check_map(source)?;
        if let Some(stream) = &scene.stream {
            stream.check(source)?;
        }
        joint::check(&scene.joints, source, (scene.quiet_s(), scene.length_s))?;
        seat::check(&scene.seats, source)?;
        scene.check_events(source)?;
        let pressed = joint::touches(&scene.joints, scene.length_s);
        scene.touches.extend(pressed);
        bounds!(source, "expect", scene.expect;
            path_rmse_mm: 0.0..=1e4, "mm";
            path_max_mm: 0.0..=1e4, "mm";
            felt_rmse_mm: 0.0..=1e4, "mm";
            felt_share_min: 0.0..=1.0;
            off_pad_share_max: 0.0..=1.0)?;
        Ok(scene)
    }

    /// The contact threshold as the core takes it.
    #[must_use]
    pub fn threshold_rule(&self) -> ThresholdRule {
        let margin = self.threshold_margin as f32;
        match self.threshold {
            ThresholdFrom::Maximum => ThresholdRule::Auto { margin },
            ThresholdFrom::PerTaxel => ThresholdRule::PerTaxel {
                sigmas: THRESHOLD_SIGMAS as f32,
                floor: margin,
            },
        }
    }

    fn check_skin(&self, source: &Source) -> Result<(), FileError> {
        bounds!(source, "", self; rate_hz: 0.1..=10_000.0, "Hz")?;
        let [low, high] = self.noise_lsb;
        source.range("noise_lsb", &low, 0.0..=1000.0, "counts")?;
        source.range("noise_lsb", &high, low..=1000.0, "counts (the lower end)")?;
        bounds!(source, "", self;
            reference_frames: 1..=100_000;
            threshold_margin: 0.0..=65_535.0, "counts";
            drift_s: 0.01..=86_400.0, "s";
            faulty_deviations: 0.1..=1000.0)
    }

    /// Time until which nothing may touch the skin, s: the frames of reference and threshold.
    fn quiet_s(&self) -> f64 {
        f64::from(self.reference_frames + 1) / self.rate_hz
    }

    /// Checks the events: touches, textures, strokes, faults.
    fn check_events(&self, source: &Source) -> Result<(), FileError> {
        let quiet_s = self.quiet_s();
        for (index, touch) in self.touches.iter().enumerate() {
            let key = format!("touches[{index}]");
            touch.check(source, &key, self.length_s)?;
            if touch.start_s < quiet_s {
                let expected = format!(
                    "at least {quiet_s} s: reference and threshold frames are contact-free"
                );
                return Err(source.bad(&format!("{key}.start_s"), expected));
            }
        }
        if let Some(texture) = &self.texture {
            texture.check(source, "texture", (quiet_s, self.length_s))?;
        }
        for (index, finger) in self.fingers.iter().enumerate() {
            let at = |key: &str| format!("fingers[{index}].{key}");
            if let Some(texture) = &finger.texture {
                texture.check(source, &at("texture"), (quiet_s, self.length_s))?;
            }
            SceneStroke::check_all(&finger.strokes, source, &at("strokes"), self.length_s)?;
        }
        for (index, material) in self.materials.iter().enumerate() {
            material.check(source, &format!("materials[{index}]"), self.length_s)?;
        }
        SceneStroke::check_all(&self.strokes, source, "strokes", self.length_s)?;
        for (index, fault) in self.faults.iter().enumerate() {
            fault.check(source, &format!("faults[{index}]"), self.length_s)?;
        }
        Ok(())
    }

    fn check_map(&self, source: &Source) -> Result<(), FileError> {
        bounds!(source, "map", self.map;
            hysteresis: 0.0..=100.0;
            window_mm: 0.01..=1e4, "mm")?;
        if self.map.window_mm.is_some() && self.map.sensor_mm.is_some() {
            let expected = "map.sensor_mm, which stays, or map.window_mm, which follows";
            return Err(source.bad("map.window_mm", expected));
        }
        bounds!(source, "map", self.map; sensor_mm: -1e4..=1e4, "mm")?;
        match self.map.sensor_mm {
            Some([left, bottom, right, top]) if left >= right || bottom >= top => {
                Err(source.bad("map.sensor_mm", "[left, bottom, right, top] with an area"))
            }
            _ => Ok(()),
        }
    }
}
