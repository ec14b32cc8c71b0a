//! What a run needs, read together and checked against one another.

use super::resolve::{Kind, resolve, resolve_from};
use super::{
    ActivationFile, AlloyFile, Bench, DisplayLayout, FileError, LayoutFile, Limits, PerceiverFile,
    Scene, SensorLayout, Source, TextureEntry, TextureTable, Wearer, WireFile,
};

/// What was read, beside its text: later checks name a line with [`Source::bad`].
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded<T> {
    /// What the file says.
    pub value: T,
    /// Where it says so.
    pub source: Source,
}

fn load<T>(
    source: Source,
    read: fn(&Source) -> Result<T, FileError>,
) -> Result<Loaded<T>, FileError> {
    let value = read(&source)?;
    Ok(Loaded { value, source })
}

/// A scene by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_scene(name: &str) -> Result<Loaded<Scene>, FileError> {
    load(resolve(Kind::Scene, name)?, Scene::read)
}

/// A layout of either kind by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_layout(name: &str) -> Result<Loaded<LayoutFile>, FileError> {
    load(resolve(Kind::Layout, name)?, LayoutFile::read)
}

/// A bench by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_bench(name: &str) -> Result<Loaded<Bench>, FileError> {
    load(resolve(Kind::Bench, name)?, Bench::read)
}

/// A limit table by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_limits(name: &str) -> Result<Loaded<Limits>, FileError> {
    load(resolve(Kind::Limits, name)?, Limits::read)
}

/// A perceiver by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_perceiver(name: &str) -> Result<Loaded<PerceiverFile>, FileError> {
    load(resolve(Kind::Perceiver, name)?, PerceiverFile::read)
}

/// Reads an activation: a built-in name or a file.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_activation(name: &str) -> Result<Loaded<ActivationFile>, FileError> {
    load(resolve(Kind::Activation, name)?, ActivationFile::read)
}

/// A table of textures by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_textures(name: &str) -> Result<Loaded<TextureTable>, FileError> {
    load(resolve(Kind::Textures, name)?, TextureTable::read)
}

/// What a scene's texture names.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroked {
    /// The surface, if one is stroked.
    pub surface: Option<TextureEntry>,
    /// From roughness to pulses.
    pub activation: Loaded<ActivationFile>,
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
    pub limits: Loaded<Limits>,
    /// The bench's wires.
    pub wire: Loaded<WireFile>,
    /// What they are made of.
    pub alloy: Loaded<AlloyFile>,
    /// The emulated person.
    pub perceiver: Loaded<PerceiverFile>,
    /// The wearer's calibration, if there is one.
    pub wearer: Option<Loaded<Wearer>>,
    /// The texture, if the scene has one.
    pub texture: Option<Stroked>,
}

impl Setup {
    /// Reads a scene and a bench by name or path, and all they refer to.
    ///
    /// # Errors
    /// What cannot be in any of the files, or does not fit together.
    pub fn load(scene: &str, bench: &str) -> Result<Self, FileError> {
        Self::join(load_scene(scene)?, load_bench(bench)?)
    }

    /// Reads what an already read scene and bench refer to.
    ///
    /// # Errors
    /// What cannot be in any of the files, or does not fit together.
    pub fn join(scene: Loaded<Scene>, bench: Loaded<Bench>) -> Result<Self, FileError> {
        let sensor = sensor_of(&scene)?;
        let display = display_of(&bench)?;
        check_faults(&scene, &sensor.value, &bench.value)?;
        let limits = match &bench.value.limits {
            Some(name) => {
                let source = resolve_from(Kind::Limits, name, &bench.source, "limits")?;
                load(source, Limits::read)?
            }
            None => load_limits("default")?,
        };
        let wire = resolve_from(
            Kind::Wire,
            &bench.value.wire.kind,
            &bench.source,
            "wire.kind",
        )?;
        let wire = load(wire, WireFile::read)?;
        let alloy = &bench.value.wire.alloy;
        let alloy = resolve_from(Kind::Alloy, alloy, &bench.source, "wire.alloy")?;
        let alloy = load(alloy, AlloyFile::read)?;
        let texture = texture_of(&scene, sensor.value.modules.len())?;
        let (perceiver, wearer) = person_of(&scene)?;
        let wires = display.value.wires_mm.len();
        if let Some(wearer) = &wearer {
            wearer.value.fits(&wearer.source, wires)?;
        }
        if bench.value.outputs.len() != wires {
            let expected = format!("{wires} outputs, one a wire of `{}`", display.value.name);
            let found = format!("{}", bench.value.outputs.len());
            return Err(bench.source.bad_found("outputs", expected, found));
        }
        if let Some(needed) = &scene.value.map.display
            && *needed != bench.value.display
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
            perceiver,
            wearer,
            texture,
        })
    }
}

/// What a scene's texture names, on a skin of so many modules.
fn texture_of(scene: &Loaded<Scene>, modules: usize) -> Result<Option<Stroked>, FileError> {
    let Some(felt) = &scene.value.texture else {
        return Ok(None);
    };
    if felt.module.is_some_and(|module| module >= modules) {
        let expected = format!("a module of the layout, 0 to {}", modules - 1);
        return Err(scene.source.bad("texture.module", expected));
    }
    let from = |kind, name, key| resolve_from(kind, name, &scene.source, key);
    let activation = from(Kind::Activation, &felt.activation, "texture.activation")?;
    let table = TextureTable::read(&from(Kind::Textures, &felt.table, "texture.table")?)?;
    let names: Vec<String> = table.texture.iter().map(|t| t.name.clone()).collect();
    let surface = felt.surface.as_ref().map(|name| {
        let found = table.texture.into_iter().find(|t| t.name == *name);
        let expected = || format!("a texture of `{}`: {}", table.name, names.join(", "));
        found.ok_or_else(|| scene.source.bad("texture.surface", expected()))
    });
    Ok(Some(Stroked {
        surface: surface.transpose()?,
        activation: load(activation, ActivationFile::read)?,
    }))
}

/// The emulated person of a scene, and the calibration if it names one.
type Person = (Loaded<PerceiverFile>, Option<Loaded<Wearer>>);

fn person_of(scene: &Loaded<Scene>) -> Result<Person, FileError> {
    let illusion = &scene.value.illusion;
    let perceiver = match &illusion.perceiver {
        Some(name) => {
            let key = "illusion.perceiver";
            let source = resolve_from(Kind::Perceiver, name, &scene.source, key)?;
            load(source, PerceiverFile::read)?
        }
        None => load_perceiver("fitted")?,
    };
    let wearer = match &illusion.wearer {
        Some(name) => {
            let source = resolve_from(Kind::Wearer, name, &scene.source, "illusion.wearer")?;
            Some(load(source, Wearer::read)?)
        }
        None => None,
    };
    Ok((perceiver, wearer))
}

/// The skin of a scene.
///
/// # Errors
/// What cannot be in its layout, or does not fit the scene.
pub fn sensor_of(scene: &Loaded<Scene>) -> Result<Loaded<SensorLayout>, FileError> {
    let source = resolve_from(Kind::Layout, &scene.value.layout, &scene.source, "layout")?;
    let LayoutFile::Sensor(mut sensor) = LayoutFile::read(&source)? else {
        return Err(scene.source.bad_found(
            "layout",
            "a layout of kind \"sensor\"",
            format!("the display `{}`", scene.value.layout),
        ));
    };
    if let Some(bus) = scene.value.boards.bus {
        let wired = sensor.modules.iter_mut().filter_map(|m| m.bus.as_mut());
        wired.for_each(|of_module| *of_module = bus);
    }
    let modules = sensor.modules.len();
    let touched = scene.value.touches.iter().enumerate();
    let named = touched
        .map(|(index, touch)| (format!("touches[{index}].module"), touch.module))
        .chain([("drives".to_owned(), scene.value.drives)]);
    for (key, module) in named {
        if module >= modules {
            let expected = format!("a module of `{}`, 0 to {}", sensor.name, modules - 1);
            return Err(scene.source.bad(&key, expected));
        }
    }
    Ok(Loaded {
        value: sensor,
        source,
    })
}

/// Every fault must meet something that is there.
fn check_faults(
    scene: &Loaded<Scene>,
    sensor: &SensorLayout,
    bench: &Bench,
) -> Result<(), FileError> {
    let chips: std::collections::BTreeSet<u8> = bench.outputs.iter().map(|o| o.board).collect();
    let chips = chips.len();
    let buses = sensor.modules.iter().filter_map(|m| m.bus);
    let buses = buses.max().map_or(0, |last| usize::from(last) + 1);
    for (index, fault) in scene.value.faults.iter().enumerate() {
        let below = |name: &str, value: Option<usize>, count: usize| {
            let fits = value.is_none_or(|v| v < count);
            let key = format!("faults[{index}].{name}");
            let bad = || scene.source.bad(&key, format!("less than {count}"));
            fits.then_some(()).ok_or_else(bad)
        };
        below("module", fault.module, sensor.modules.len())?;
        below("with", fault.with, sensor.modules.len())?;
        below("bus", fault.bus.map(usize::from), buses)?;
        below("board", fault.board, chips)?;
        below("wire", fault.wire, bench.outputs.len())?;
        if let Some(module) = fault.module.and_then(|m| sensor.modules.get(m)) {
            below("taxel", fault.taxel, module.taxels().len())?;
            below("line", fault.line.map(usize::from), 8)?;
        }
    }
    Ok(())
}

fn display_of(bench: &Loaded<Bench>) -> Result<Loaded<DisplayLayout>, FileError> {
    let source = resolve_from(Kind::Layout, &bench.value.display, &bench.source, "display")?;
    let LayoutFile::Display(display) = LayoutFile::read(&source)? else {
        return Err(bench.source.bad_found(
            "display",
            "a layout of kind \"display\"",
            format!("the sensor `{}`", bench.value.display),
        ));
    };
    Ok(Loaded {
        value: display,
        source,
    })
}
