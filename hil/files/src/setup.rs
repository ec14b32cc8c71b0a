//! Files that a run needs, read together and checked against one another.

mod fingers;

use super::activation::ActivationFile;
use super::band::BandFile;
use super::bench::{Bench, BenchKind};
use super::error::FileError;
use super::fault::FaultKind;
use super::felt::Felt;
use super::layout::{DisplayLayout, LayoutFile, SensorLayout};
use super::limits::LimitTable;
use super::loaded::{Loaded, load_bench, load_scene};
use super::near::did_you_mean;
use super::overrides::Overrides;
use super::person::{PersonFile, Wearer};
use super::recipe::Recipe;
use super::recipe_plan::RecipePlan;
use super::scene::Scene;
use super::seat;
use super::texture::{TextureEntry, TextureTable};
use super::transducer::Transducer;
use super::wire::{AlloyFile, WireFile, check_rest};
pub use fingers::Finger;
use palpate_core::codec::link::Hello;
use palpate_core::guard::{Limits, Memory};
use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_core::projector::HotPass;
use palpate_core::units::Duration;

/// Surface and activation that a scene's texture names.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroked {
    /// The surface, if one is stroked.
    pub surface: Option<TextureEntry>,
    /// The map from roughness to pulses.
    pub activation: Loaded<ActivationFile>,
}

/// Way of a run with the hot pass of its wires.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Pass {
    /// Cold wires are passed before the run.
    #[default]
    Before,
    /// The run is the pass.
    Itself(HotPass),
    /// The run is the pass, on an emulated skin: readings of what follows come from elsewhere.
    Apart(HotPass),
    /// Wires begin as their file says, whatever that is.
    LeftOut,
}

impl Pass {
    /// The pass that a run is; `None` for a run of a scene.
    #[must_use]
    pub const fn itself(self) -> Option<HotPass> {
        match self {
            Self::Itself(pass) | Self::Apart(pass) => Some(pass),
            Self::Before | Self::LeftOut => None,
        }
    }
}

/// Wires and finger that a run emulates in place of the bench's, of which its guard does not know.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drawn {
    /// The wires.
    pub wire: WireParameters,
    /// The finger.
    pub tissue: TissueParameters,
    /// True if the law plans with the response of these wires, false if with that of the bench's.
    pub is_identified: bool,
}

/// A scene on a bench, with everything they name.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// The scene.
    pub scene: Loaded<Scene>,
    /// The scene's skin.
    pub sensor: Loaded<SensorLayout>,
    /// The bench.
    pub bench: Loaded<Bench>,
    /// The bench's display.
    pub display: Loaded<DisplayLayout>,
    /// The bench's limit table.
    pub limits: Loaded<LimitTable>,
    /// The bench's wires.
    pub wire: Loaded<WireFile>,
    /// The wires' alloy.
    pub alloy: Loaded<AlloyFile>,
    /// Level and error of the bench over all that is not measured, where it names such a file.
    pub band: Option<Loaded<BandFile>>,
    /// The emulated person.
    pub person: Loaded<PersonFile>,
    /// The wearer's calibration, if there is one.
    pub wearer: Option<Loaded<Wearer>>,
    /// The texture, if the scene has one.
    pub texture: Option<Stroked>,
    /// The displays that the scene drives, where the bench has several.
    pub fingers: Vec<Finger>,
    /// Place of texture and strokes in the scene's file: `fingers[2].` for one of several fingers, for example.
    pub section: String,
    /// Longest time for which transfers of other displays hold up those of this one, where they share a bus.
    pub bus_wait: Duration,
    /// The unit's own description, once the bench met it: the stricter of both is played by.
    pub unit: Option<Hello>,
    /// Heat and dose of earlier runs: the guard goes on from them.
    pub memory: Option<Memory>,
    /// Way of the run with the hot pass of its wires.
    pub pass: Pass,
    /// Sentence for the run's records on the hot pass of its wires.
    pub told: Option<String>,
    /// Wires and finger in place of the bench's.
    pub drawn: Option<Drawn>,
    pub(super) observed: bool,
}

impl Setup {
    /// Returns the setup with these changes to scene and bench.
    ///
    /// # Errors
    /// Names the option and key of a value that is refused, or that does not fit the others.
    pub fn with(self, overrides: &Overrides) -> Result<Self, FileError> {
        Self::join(self.scene.with(overrides)?, self.bench.with(overrides)?)
    }

    /// Reads a scene and a bench by name or path, and all they refer to.
    ///
    /// # Errors
    /// A value that is refused in one of the files, or files that do not fit together.
    pub fn load(scene: &str, bench: &str) -> Result<Self, FileError> {
        Self::join(load_scene(scene)?, load_bench(bench)?)
    }

    /// Reads the files that an already read scene and bench refer to.
    ///
    /// # Errors
    /// A value that is refused in one of the files, or files that do not fit together.
    pub fn join(mut scene: Loaded<Scene>, bench: Loaded<Bench>) -> Result<Self, FileError> {
        scene.fits_bench(&bench.value)?;
        scene.on_motors(&bench.value)?;
        let sensor = sensor_of(&scene)?;
        let display = display_of(&bench)?;
        check_faults(&scene, &sensor.value, &bench.value)?;
        seat::fit(&scene.value.seats, &scene.source, bench.value.outputs.len())?;
        if scene.value.stream.is_some() && bench.value.kind == BenchKind::Real {
            let expected = "nothing on a bench of hardware, whose boards are on its own buses: [stream] emulates a network";
            return Err(scene.source.bad("stream", expected));
        }
        let hardware = &bench.value;
        let limits = limits_of(&bench)?;
        let (wire, alloy) = mounted_of(&bench)?;
        let band = band_of(&bench)?;
        let texture = texture_of(&scene, sensor.value.modules.len())?;
        let people = people_of(&scene)?;
        let fingers = fingers::driven(&scene, &bench, &people)?;
        let (person, wearer) = people;
        let wires = display.value.wires_mm.len();
        if let Some(wearer) = wearer.as_ref().filter(|_| fingers.is_empty()) {
            wearer.value.fits(&wearer.source, wires)?;
        }
        check_outputs(&bench, &display.value)?;
        if let Some(needed) = &scene.value.map.display
            && *needed != hardware.display
            && *needed != display.value.name
        {
            let expected = format!("the bench's display, `{}`", display.value.name);
            return Err(scene.source.bad("map.display", expected));
        }
        Ok(Self {
            scene,
            sensor,
            bench,
            display,
            limits,
            wire,
            alloy,
            band,
            person,
            wearer,
            texture,
            fingers,
            section: String::new(),
            bus_wait: Duration::ZERO,
            unit: None,
            memory: None,
            pass: Pass::default(),
            told: None,
            drawn: None,
            observed: false,
        })
    }

    /// Returns the setup with a guard that only looks on: every stimulus is driven unchanged.
    ///
    /// # Errors
    /// A bench of hardware.
    pub fn observed(mut self) -> Result<Self, FileError> {
        if self.bench.value.unit_address().is_some() {
            let expected = "nothing for --observe: a unit has a guard of its own";
            return Err(self.bench.source.bad("unit.address", expected));
        }
        if self.bench.value.haptics.is_some() {
            let expected = "nothing for --observe: only a guard of wires can look on";
            return Err(self.bench.source.bad("haptics", expected));
        }
        if self.bench.value.kind == BenchKind::Real {
            let expected = "\"emulated\": on hardware the guard never only observes";
            return Err(self.bench.source.bad_found("kind", expected, "\"real\""));
        }
        self.observed = true;
        Ok(self)
    }

    /// Returns true if the guard only looks on.
    #[must_use]
    pub const fn is_observed(&self) -> bool {
        self.observed
    }
}

pub(super) fn limits_of(bench: &Loaded<Bench>) -> Result<Loaded<LimitTable>, FileError> {
    let limits: Loaded<LimitTable> = bench.refer(&bench.value.limits, "limits")?;
    let Limits {
        skin_mean_mc,
        skin_peak_mc,
        skin_deep_mc,
        ..
    } = limits.value.limits;
    let lowest_c = skin_mean_mc.min(skin_peak_mc).min(skin_deep_mc) as f64 / 1e3;
    let tissue = &bench.value.tissue;
    if tissue.guarded_c() >= lowest_c {
        let table = &limits.value.name;
        let key = match tissue.rest_c >= lowest_c {
            true => "tissue.rest_c",
            false => "tissue.warmest_c",
        };
        let expected = format!("less than {lowest_c}, the lowest row of [skin] in `{table}`");
        return Err(bench.source.bad(key, expected));
    }
    Ok(limits)
}

pub(super) fn alloy_of(bench: &Loaded<Bench>) -> Result<Loaded<AlloyFile>, FileError> {
    bench.refer(&bench.value.wire.alloy, "wire.alloy")
}

pub(super) fn wire_of(bench: &Loaded<Bench>) -> Result<Loaded<WireFile>, FileError> {
    bench.refer(&bench.value.wire.kind, "wire.kind")
}

/// Reads wire and alloy of a bench, which fit each other and the mount.
pub(super) fn mounted_of(
    bench: &Loaded<Bench>,
) -> Result<(Loaded<WireFile>, Loaded<AlloyFile>), FileError> {
    let (alloy, wire) = (alloy_of(bench)?, wire_of(bench)?);
    let mount = &bench.value.mount;
    mount.fits(&bench.source, wire.value.length_mm)?;
    let worn = WireParameters {
        mount: mount.parameters(),
        ..wire.value.parameters(&alloy.value)
    };
    let tissue = bench.value.tissue.parameters();
    check_rest(&wire.source, &bench.source, &worn, &tissue)?;
    Ok((wire, alloy))
}

/// Reads the band that a bench names, which is of that bench.
pub(super) fn band_of(bench: &Loaded<Bench>) -> Result<Option<Loaded<BandFile>>, FileError> {
    let Some(name) = &bench.value.band else {
        return Ok(None);
    };
    let band: Loaded<BandFile> = bench.refer(name, "band")?;
    let (own, other) = (&bench.value.name, &band.value.name);
    if own == other {
        return Ok(Some(band));
    }
    let typed = bench.typed();
    let expected = format!("a band of bench `{own}`; `hil calibrate {typed} --out FILE` makes one");
    let found = format!("\"{name}\", one of bench `{other}`");
    Err(bench.source.bad_found("band", expected, found))
}

/// Checks that all wires of a display are connected.
pub(super) fn check_outputs(
    bench: &Loaded<Bench>,
    display: &DisplayLayout,
) -> Result<(), FileError> {
    let (outputs, wires) = (bench.value.outputs.len(), display.wires_mm.len());
    if outputs == wires || !bench.value.displays.is_empty() {
        return Ok(());
    }
    let expected = format!("{wires} outputs, one per wire of `{}`", display.name);
    Err(bench
        .source
        .bad_found("outputs", expected, outputs.to_string()))
}

/// Reads the surface and activation of a scene's texture, on a skin of so many modules.
pub(super) fn texture_of(
    scene: &Loaded<Scene>,
    modules: usize,
) -> Result<Option<Stroked>, FileError> {
    let Some(felt) = &scene.value.texture else {
        return Ok(None);
    };
    if felt.module.is_some_and(|module| module >= modules) {
        let expected = format!("a module of the layout, 0 to {}", modules - 1);
        return Err(scene.source.bad("texture.module", expected));
    }
    stroked(scene, felt, "texture").map(Some)
}

/// Reads the surface and activation that a texture section names.
fn stroked(scene: &Loaded<Scene>, felt: &Felt, section: &str) -> Result<Stroked, FileError> {
    let at = |key: &str| format!("{section}.{key}");
    let activation = scene.refer(&felt.activation, &at("activation"))?;
    let table: TextureTable = scene.refer(&felt.table, &at("table"))?.value;
    let names: Vec<String> = table.texture.iter().map(|t| t.name.clone()).collect();
    let surface = felt.surface.as_ref().map(|name| {
        let found = table.texture.into_iter().find(|t| t.name == *name);
        let expected = || format!("a texture of `{}`: {}", table.name, names.join(", "));
        found.ok_or_else(|| {
            let meant = did_you_mean(name, names.iter().map(String::as_str));
            let found = format!("\"{name}\"{meant}");
            let key = at("surface");
            scene.source.bad_found(&key, expected(), found)
        })
    });
    Ok(Stroked {
        surface: surface.transpose()?,
        activation,
    })
}

/// The emulated person of a scene, and the calibration if it names one.
pub(super) type People = (Loaded<PersonFile>, Option<Loaded<Wearer>>);

pub(super) fn people_of(scene: &Loaded<Scene>) -> Result<People, FileError> {
    let illusion = &scene.value.illusion;
    let person = scene.refer(&illusion.person, "illusion.person")?;
    let wearer = illusion.wearer.as_ref();
    let wearer = wearer.map(|name| scene.refer(name, "illusion.wearer"));
    Ok((person, wearer.transpose()?))
}

/// A recipe held against the layout that it names, and the layout.
///
/// # Errors
/// A layout that cannot be, or that does not fit the recipe.
pub fn plan_of(recipe: &Loaded<Recipe>) -> Result<(RecipePlan, SensorLayout), FileError> {
    let layout = skin_of(recipe, &recipe.value.layout)?.value;
    let plan = RecipePlan::new(&recipe.value, &recipe.source, &layout)?;
    Ok((plan, layout))
}

fn skin_of<T>(file: &Loaded<T>, name: &str) -> Result<Loaded<SensorLayout>, FileError> {
    let Loaded { value, source } = file.refer(name, "layout")?;
    let LayoutFile::Sensor(value) = value else {
        let expected = "a layout of kind \"sensor\"";
        let found = format!("the display `{name}`");
        return Err(file.source.bad_found("layout", expected, found));
    };
    Ok(Loaded { value, source })
}

/// The skin of a scene.
///
/// # Errors
/// A value of its layout that is refused, or that does not fit the scene.
pub fn sensor_of(scene: &Loaded<Scene>) -> Result<Loaded<SensorLayout>, FileError> {
    let mut loaded = skin_of(scene, &scene.value.layout)?;
    let sensor = &mut loaded.value;
    if let Some(bus) = scene.value.boards.bus {
        let wired = sensor.modules.iter_mut().filter_map(|m| m.bus.as_mut());
        wired.for_each(|of_module| *of_module = bus);
        if let Some((module, position)) = sensor.shared_board() {
            let expected = format!(
                "a layout whose boards have addresses of their own on one bus; board {position} of module {module} has another's"
            );
            return Err(scene.source.bad("boards.bus", expected));
        }
    }
    fingers::check(scene, sensor)?;
    let modules = sensor.modules.len();
    let presses = scene.value.joints.iter().enumerate();
    let presses = presses.filter_map(|(index, joint)| {
        let module = joint.press?.module;
        Some((format!("joints[{index}].press.module"), module))
    });
    let touched = scene.value.touches.iter().enumerate();
    // presses of joints are touches too: their own keys come first
    let named = presses
        .chain(touched.map(|(index, touch)| (format!("touches[{index}].module"), touch.module)))
        .chain([("drives".to_owned(), scene.value.drives)]);
    for (key, module) in named {
        if module >= modules {
            let expected = format!("a module of `{}`, 0 to {}", sensor.name, modules - 1);
            return Err(scene.source.bad(&key, expected));
        }
    }
    Ok(loaded)
}

/// Checks that every fault meets an existing thing.
fn check_faults(
    scene: &Loaded<Scene>,
    sensor: &SensorLayout,
    bench: &Bench,
) -> Result<(), FileError> {
    let chips = bench.boards();
    let adapters = bench.outputs.iter().map(|o| usize::from(o.bus) + 1).max();
    let buses = sensor.modules.iter().filter_map(|m| m.bus);
    let buses = buses.max().map_or(0, |last| usize::from(last) + 1);
    for (index, fault) in scene.value.faults.iter().enumerate() {
        let below = |name: &str, value: Option<usize>, count: usize| {
            let fits = value.is_none_or(|v| v < count);
            let key = format!("faults[{index}].{name}");
            let bad = || scene.source.bad(&key, format!("less than {count}"));
            fits.then_some(()).ok_or_else(bad)
        };
        let bad_kind = |expected| scene.source.bad(&format!("faults[{index}].kind"), expected);
        let of_taxels = [
            FaultKind::TaxelFrozen,
            FaultKind::ZeroTriplets,
            FaultKind::SdaDead,
            FaultKind::WrongModel,
        ];
        if of_taxels.contains(&fault.kind) && sensor.transducer != Transducer::Magnetic {
            let expected =
                "a fault that this layout's boards can have: only uSkin boards send taxel by taxel";
            return Err(bad_kind(expected));
        }
        below("module", fault.module, sensor.modules.len())?;
        below("with", fault.with, sensor.modules.len())?;
        let buses = match fault.kind.is_of_display() {
            true => adapters.unwrap_or(0),
            false => buses,
        };
        below("bus", fault.bus.map(usize::from), buses)?;
        below("board", fault.board, chips)?;
        below("wire", fault.wire, bench.outputs.len())?;
        if fault.kind == FaultKind::ClockStopped && bench.drive.clock.is_none() {
            let expected = "a bench that states drive.clock: there is none to stop";
            return Err(bad_kind(expected));
        }
        below("motor", fault.motor, bench.outputs.len())?;
        let is_of_wires = fault.kind.is_of_display() && !fault.kind.is_of_i2c();
        if is_of_wires && fault.kind.is_of_motors() != bench.haptics.is_some() {
            let expected = match bench.haptics {
                Some(_) => "a fault that a bench of motors can have: of sensors, I2C or motors",
                None => "a bench with [haptics]: there is no motor to fail",
            };
            return Err(bad_kind(expected));
        }
        let of_chips = [FaultKind::DriverHot, FaultKind::SwitchStuck];
        let is_of_chips = fault.kind.is_of_i2c() || of_chips.contains(&fault.kind);
        let card = bench.haptics.as_ref().map(|h| h.audio.is_some());
        if card == Some(true) && is_of_chips {
            let expected = "a fault that motors on a sound card can have: there is no I2C bus";
            return Err(bad_kind(expected));
        }
        if card == Some(false) && fault.kind.is_of_audio() {
            let expected = "a fault that motors behind an I2C bus can have: there is no sound card";
            return Err(bad_kind(expected));
        }
        if fault.kind.is_of_converters() && bench.dac.is_none() {
            let expected = "a bench with [dac]: there is no converter to fail";
            return Err(bad_kind(expected));
        }
        if let Some(module) = fault.module.and_then(|m| sensor.modules.get(m)) {
            below("taxel", fault.taxel, module.taxels().len())?;
            below("line", fault.line.map(usize::from), 8)?;
        }
    }
    Ok(())
}

pub(super) fn display_of(bench: &Loaded<Bench>) -> Result<Loaded<DisplayLayout>, FileError> {
    let name = &bench.value.display;
    let (value, source) = DisplayLayout::named(name, &bench.source, "display")?;
    Ok(Loaded { value, source })
}
