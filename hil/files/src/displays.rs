//! Several fingertips: the displays of a bench, the modules of a scene that drive each, and how the two fit.

use std::ops::Range;

use serde::Deserialize;

use super::address::check_chip;
use super::bench::{Bench, BenchKind, Output};
use super::error::FileError;
use super::layout::{DisplayLayout, SensorLayout};
use super::loaded::Loaded;
use super::person::{PersonFile, Wearer};
use super::resolve::FileKind;
use super::scene::Scene;
use super::setup::People;
use super::source::Source;
use super::words::choice;

/// A bench has at most so many displays, and as many boards.
const MOST: usize = 16;

choice! { /** How several modules drive one display. */ FingerRule {
    /** The first one drives; the others are compressed and recorded. */ First = "first",
    /** All drive: `kc` contacts over all of them, as they lie in the layout's plane. */ Merged = "merged",
}}

/// One of several displays of an emulated bench: a fingertip.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BenchDisplay {
    /// Lower case with hyphens.
    pub name: String,
    /// A display layout: a built-in name or a file; left out: the bench's `display`.
    pub layout: Option<String>,
    /// The emulated person who wears it: a built-in name or a file; left out: the scene's.
    pub person: Option<String>,
    /// That person's calibration: a built-in name or a file; left out: the scene's.
    pub wearer: Option<String>,
    /// One entry per wire; left out of all displays: the outputs of one chip after the other, from 0x40 on.
    #[serde(default)]
    pub outputs: Vec<Output>,
}

/// What drives one of a bench's displays.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SceneFinger {
    /// The display, by its name on the bench.
    pub display: String,
    /// Its modules, counted from zero.
    pub modules: Vec<usize>,
    /// How they drive it, where there are several.
    pub rule: Option<FingerRule>,
}

/// A display of the bench with the modules that drive it.
#[derive(Debug, Clone, PartialEq)]
pub struct Finger {
    /// The display's name on the bench.
    pub name: String,
    /// Where its wires are.
    pub display: Loaded<DisplayLayout>,
    /// Who wears it.
    pub person: Loaded<PersonFile>,
    /// That person's calibration, if there is one.
    pub wearer: Option<Loaded<Wearer>>,
    /// Its wires among all outputs of the bench.
    pub wires: Range<usize>,
    /// Its modules.
    pub modules: Vec<usize>,
    /// Whether all of them drive it; else the first does.
    pub merged: bool,
}

impl Bench {
    /// Checks the displays, and says in `outputs` what is connected to all of them.
    pub(super) fn join_displays(&mut self, source: &Source) -> Result<(), FileError> {
        if self.displays.is_empty() {
            return Ok(());
        }
        if self.kind == BenchKind::Real {
            let expected = "nothing: a bench of hardware has one display, `display` and `outputs`";
            return Err(source.bad_found("displays", expected, "[[displays]]"));
        }
        if !self.outputs.is_empty() {
            let expected = "nothing: every one of [[displays]] has its own";
            return Err(source.bad_found("outputs", expected, "outputs of the bench"));
        }
        source.range("displays", self.displays.len(), 1..=MOST, "displays")?;
        let stated = self.displays.iter().any(|d| !d.outputs.is_empty());
        let mut displays = std::mem::take(&mut self.displays);
        for (index, display) in displays.iter_mut().enumerate() {
            let at = |key: &str| format!("displays[{index}].{key}");
            source.name(&at("name"), &display.name)?;
            let layout = self.layout_of(source, index, display)?;
            let first = self.outputs.len();
            let wires = layout.value.wires_mm.len();
            if !stated {
                display.outputs = (first..first + wires).map(Output::nth).collect();
            }
            if display.outputs.len() != wires {
                let expected = format!("{wires} outputs, one per wire of `{}`", layout.value.name);
                let found = display.outputs.len().to_string();
                return Err(source.bad_found(&at("outputs"), expected, found));
            }
            self.outputs.append(&mut display.outputs.clone());
        }
        self.displays = displays;
        self.check_displays(source)?;
        self.check_supply(source)
    }

    /// Every name, and every channel of a board, belongs to one display alone.
    fn check_displays(&self, source: &Source) -> Result<(), FileError> {
        let mut taken: Vec<(Output, &str)> = Vec::new();
        for (index, display) in self.displays.iter().enumerate() {
            let key = format!("displays[{index}]");
            if self.displays[..index]
                .iter()
                .any(|d| d.name == display.name)
            {
                let expected = "a name of its own: another display has this one";
                return Err(source.bad(&format!("{key}.name"), expected));
            }
            for (wire, output) in display.outputs.iter().enumerate() {
                let at = |name: &str| format!("{key}.outputs[{wire}].{name}");
                source.range(&at("bus"), usize::from(output.bus), 0..=MOST - 1, "")?;
                check_chip(source, &at("board"), output.board)?;
                source.range(&at("channel"), output.channel, 0..=15, "")?;
                if output.bus != display.outputs[0].bus {
                    let bus = display.outputs[0].bus;
                    let expected = format!("{bus}: the wires of one display are on one bus");
                    return Err(source.bad(&at("bus"), expected));
                }
                if let Some((_, owner)) = taken.iter().find(|(other, _)| other == output) {
                    let expected = format!(
                        "an output of its own: display `{owner}` has channel {} of board 0x{:02x}",
                        output.channel, output.board
                    );
                    return Err(source.bad(&at("channel"), expected));
                }
                taken.push((*output, &display.name));
            }
        }
        let boards = self.boards();
        let expected = format!("at most {MOST} boards");
        let found = boards.to_string();
        let many = || source.bad_found("displays", expected, found);
        (boards <= MOST).then_some(()).ok_or_else(many)
    }

    /// How many boards the outputs are on.
    #[must_use]
    pub fn boards(&self) -> usize {
        let boards = self.outputs.iter().map(|o| (o.bus, o.board));
        boards.collect::<std::collections::BTreeSet<_>>().len()
    }

    /// Boards run asynchronously, so that the currents of one wire each may flow at one instant.
    fn check_supply(&self, source: &Source) -> Result<(), FileError> {
        let (boards, wire) = (self.boards(), self.drive.current_ma);
        let needed = boards as f64 * wire;
        if self.drive.supply_limit_ma >= needed {
            return Ok(());
        }
        let expected = format!(
            "at least {needed} mA: {boards} boards with one wire of {wire} mA each, which are not in step"
        );
        let found = format!("{} mA", self.drive.supply_limit_ma);
        Err(source.bad_found("drive.supply_limit_ma", expected, found))
    }

    fn layout_of(
        &self,
        source: &Source,
        index: usize,
        display: &BenchDisplay,
    ) -> Result<Loaded<DisplayLayout>, FileError> {
        let (name, key) = match &display.layout {
            Some(name) => (name, format!("displays[{index}].layout")),
            None => (&self.display, "display".to_owned()),
        };
        let (value, source) = DisplayLayout::named(name, source, &key)?;
        Ok(Loaded { value, source })
    }
}

impl Scene {
    /// Every module drives one finger, by a rule where it is not alone.
    pub(super) fn check_fingers(
        &self,
        source: &Source,
        sensor: &SensorLayout,
    ) -> Result<(), FileError> {
        let mut owners: Vec<Option<&str>> = vec![None; sensor.modules.len()];
        for (index, finger) in self.fingers.iter().enumerate() {
            let at = |key: &str| format!("fingers[{index}].{key}");
            if self.fingers[..index]
                .iter()
                .any(|f| f.display == finger.display)
            {
                let expected = "a display of its own: another of [[fingers]] has this one";
                return Err(source.bad(&at("display"), expected));
            }
            for (position, &module) in finger.modules.iter().enumerate() {
                let here = at(&format!("modules[{position}]"));
                source.range(&here, module, 0..=sensor.modules.len() - 1, "")?;
                if let Some(owner) = owners[module].replace(&finger.display) {
                    let expected = format!("a module of one finger: it drives `{owner}` already");
                    return Err(source.bad(&here, expected));
                }
            }
            let several = finger.modules.len() > 1;
            match (finger.modules.len(), finger.rule) {
                (0, _) => return Err(source.bad(&at("modules"), "at least one module")),
                (2.., None) => {
                    let expected = "\"first\" or \"merged\": how several modules drive one display";
                    return Err(source.bad(&at("rule"), expected));
                }
                (_, Some(_)) if !several => {
                    return Err(source.bad(&at("rule"), "nothing: one module needs no rule"));
                }
                _ => {}
            }
        }
        let idle = owners.iter().position(Option::is_none);
        match idle.filter(|_| !self.fingers.is_empty()) {
            None => Ok(()),
            Some(module) => {
                let name = &sensor.modules[module].name;
                let expected = format!(
                    "all {} modules of `{}`, each once: a finger's `rule = \"first\"` records modules that do not drive",
                    sensor.modules.len(),
                    sensor.name
                );
                let found = format!("none with module {module} (`{name}`), which drives nothing");
                Err(source.bad_found("fingers", expected, found))
            }
        }
    }
}

/// The displays of a bench that a scene drives; none where the bench has one display.
pub(super) fn fingers_of(
    scene: &Loaded<Scene>,
    bench: &Loaded<Bench>,
    people: &People,
) -> Result<Vec<Finger>, FileError> {
    let displays = &bench.value.displays;
    if displays.is_empty() {
        return Ok(Vec::new());
    }
    let names: Vec<String> = displays.iter().map(|d| format!("`{}`", d.name)).collect();
    let names = names.join(", ");
    let source = &scene.source;
    if scene.value.fingers.is_empty() {
        let expected = format!("[[fingers]]: what drives the bench's displays {names}");
        return Err(source.bad_found("fingers", expected, "none"));
    }
    for (key, there) in [
        ("texture", scene.value.texture.is_some()),
        ("strokes", !scene.value.strokes.is_empty()),
    ] {
        if there {
            let expected = "nothing: it is felt on a bench of one display only";
            return Err(source.bad_found(key, expected, format!("`{key}`")));
        }
    }
    let finger = |(index, file): (usize, &SceneFinger)| {
        let found = displays.iter().position(|d| d.name == file.display);
        let number = found.ok_or_else(|| {
            let expected = format!("a display of bench `{}`: {names}", bench.value.name);
            source.bad(&format!("fingers[{index}].display"), expected)
        })?;
        let display = &displays[number];
        let first = displays[..number].iter().map(|d| d.outputs.len()).sum();
        let layout = bench.value.layout_of(&bench.source, number, display)?;
        let (person, wearer) = worn_by(bench, number, display, people)?;
        let wires = layout.value.wires_mm.len();
        if let Some(wearer) = &wearer {
            wearer.value.fits(&wearer.source, wires)?;
        }
        Ok(Finger {
            name: file.display.clone(),
            display: layout,
            person,
            wearer,
            wires: first..first + wires,
            modules: file.modules.clone(),
            merged: file.rule == Some(FingerRule::Merged),
        })
    };
    scene.value.fingers.iter().enumerate().map(finger).collect()
}

/// Who wears a display: whom it names, else whom the scene names.
fn worn_by(
    bench: &Loaded<Bench>,
    number: usize,
    display: &BenchDisplay,
    people: &People,
) -> Result<People, FileError> {
    let (mut person, mut wearer) = people.clone();
    let at = |key: &str| format!("displays[{number}].{key}");
    if let Some(name) = &display.person {
        person = bench.refer(FileKind::Person, PersonFile::read, name, &at("person"))?;
    }
    if let Some(name) = &display.wearer {
        wearer = Some(bench.refer(FileKind::Wearer, Wearer::read, name, &at("wearer"))?);
    }
    Ok((person, wearer))
}
