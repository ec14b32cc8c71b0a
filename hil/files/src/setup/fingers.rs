//! The displays of a bench with the modules of a scene that drive them.

use std::collections::BTreeSet;
use std::ops::Range;

use palpate_core::guard::Memory;

use super::{People, Stroked, stroked};
use crate::bench::{Bench, BenchDisplay, BenchKind};
use crate::error::FileError;
use crate::felt::{Felt, FeltBy};
use crate::finger::{FingerRule, SceneFinger};
use crate::illusion::SceneStroke;
use crate::joint::Gate;
use crate::layout::{DisplayLayout, SensorLayout};
use crate::loaded::Loaded;
use crate::person::{PersonFile, Wearer};
use crate::scene::Scene;

/// A display of the bench with the modules that drive it.
#[derive(Debug, Clone, PartialEq)]
pub struct Finger {
    /// The display's name on the bench.
    pub name: String,
    /// Layout of its wires.
    pub display: Loaded<DisplayLayout>,
    /// The person who wears it.
    pub person: Loaded<PersonFile>,
    /// The calibration of that person, if there is one.
    pub wearer: Option<Loaded<Wearer>>,
    /// The hand that wears it.
    pub hand: Option<String>,
    /// Range of its wires among all outputs of the bench.
    pub wires: Range<usize>,
    /// Modules that drive it.
    pub modules: Vec<usize>,
    /// True if all of them drive it; else the first does.
    pub merged: bool,
    /// Condition under which it is felt; always where there is none.
    pub when: Option<Gate>,
    /// The texture felt there, with the stroked module by the skin's numbers.
    pub texture: Option<(Felt, Stroked)>,
    /// Strokes over its display.
    pub strokes: Vec<SceneStroke>,
    /// Heat and dose of earlier runs under this display; where there are none, the setup's own count.
    pub memory: Option<Memory>,
}

/// Checks that every module of a scene's skin belongs to one finger, by a rule where the finger has several.
pub(super) fn check(scene: &Loaded<Scene>, sensor: &SensorLayout) -> Result<(), FileError> {
    let (fingers, source) = (&scene.value.fingers, &scene.source);
    let mut owners: Vec<Option<&str>> = vec![None; sensor.modules.len()];
    for (index, finger) in fingers.iter().enumerate() {
        let at = |key: &str| format!("fingers[{index}].{key}");
        if fingers[..index].iter().any(|f| f.display == finger.display) {
            let expected = "a display of its own: another of [[fingers]] has this one";
            return Err(source.bad(&at("display"), expected));
        }
        for (position, &module) in finger.modules.iter().enumerate() {
            let here = at(&format!("modules[{position}]"));
            source.range(&here, &module, 0..=sensor.modules.len() - 1, "")?;
            if let Some(owner) = owners[module].replace(&finger.display) {
                let expected = format!("a module of one finger: it drives `{owner}` already");
                return Err(source.bad(&here, expected));
            }
        }
        if let Some(when) = &finger.when {
            when.check(source, &at("when"))?;
        }
        if let Some(module) = finger.texture.as_ref().and_then(|felt| felt.module)
            && !finger.modules.contains(&module)
        {
            let expected = format!("one of the finger's modules, {:?}", finger.modules);
            return Err(source.bad_found(&at("texture.module"), expected, module.to_string()));
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
    match idle.filter(|_| !fingers.is_empty()) {
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

/// The displays of a bench that a scene drives; none where the bench has one display.
pub(super) fn driven(
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
            let expected = format!(
                "nothing on a bench of several displays: each of [[fingers]] has its own, such as `fingers[0].{key}`"
            );
            return Err(source.bad_found(key, expected, format!("`{key}`")));
        }
    }
    let gate = |index: usize, file: &SceneFinger| {
        let key = format!("fingers[{index}].when");
        if file.when.is_some() && bench.value.kind == BenchKind::Real {
            let expected = "nothing: a real bench reads no joints";
            return Err(source.bad_found(&key, expected, "a joint"));
        }
        let joints = &scene.value.joints;
        let of = |when| Gate::new(when, joints, &scene.source, &key);
        file.when.as_ref().map(of).transpose()
    };
    let finger = |(index, file): (usize, &SceneFinger)| {
        let found = displays.iter().position(|d| d.name == file.display);
        let number = found.ok_or_else(|| {
            let expected = format!("a display of bench `{}`: {names}", bench.value.name);
            source.bad(&format!("fingers[{index}].display"), expected)
        })?;
        let display = &displays[number];
        let first = displays[..number].iter().map(|d| d.outputs.len()).sum();
        let (value, source) = bench.value.layout_of(&bench.source, number, display)?;
        let (person, wearer) = worn_by(bench, number, display, people)?;
        let wires = value.wires_mm.len();
        if let Some(wearer) = &wearer {
            wearer.value.fits(&wearer.source, wires)?;
        }
        Ok(Finger {
            name: file.display.clone(),
            hand: display.hand.clone(),
            display: Loaded { value, source },
            person,
            wearer,
            wires: first..first + wires,
            modules: file.modules.clone(),
            merged: file.rule == Some(FingerRule::Merged),
            when: gate(index, file)?,
            texture: texture_of(scene, index, file)?,
            strokes: file.strokes.clone(),
            memory: None,
        })
    };
    let fingers = scene.value.fingers.iter().enumerate().map(finger);
    let fingers = fingers.collect::<Result<Vec<_>, _>>()?;
    check_carriers(&fingers, scene, &bench.value)?;
    Ok(fingers)
}

/// A finger's texture; the stroked module is the first unless the texture states another.
fn texture_of(
    scene: &Loaded<Scene>,
    index: usize,
    file: &SceneFinger,
) -> Result<Option<(Felt, Stroked)>, FileError> {
    let with = |felt: &Felt| {
        let named = stroked(scene, felt, &format!("fingers[{index}].texture"))?;
        let mut felt = felt.clone();
        felt.module = felt.module.or_else(|| file.modules.first().copied());
        Ok((felt, named))
    };
    file.texture.as_ref().map(with).transpose()
}

/// Checks that a board with pulses that run by themselves serves one display: they leave no time for other bursts.
fn check_carriers(
    fingers: &[Finger],
    scene: &Loaded<Scene>,
    bench: &Bench,
) -> Result<(), FileError> {
    let boards = |finger: &Finger| {
        let outputs = bench.outputs[finger.wires.clone()].iter();
        outputs.map(|o| (o.bus, o.board)).collect::<BTreeSet<_>>()
    };
    for (index, finger) in fingers.iter().enumerate() {
        let by = finger.texture.as_ref().map(|(felt, _)| felt.carrier);
        if by != Some(FeltBy::Display) {
            continue;
        }
        let own = boards(finger);
        for other in fingers.iter().filter(|other| other.name != finger.name) {
            if let Some((_, board)) = own.intersection(&boards(other)).next() {
                let expected = format!(
                    "\"contacts\", or a board of its own: display `{}` has bursts on board 0x{board:02x} too, and the pulses of \"display\" take every period",
                    other.name
                );
                let key = format!("fingers[{index}].texture.carrier");
                return Err(scene.source.bad_found(&key, expected, "\"display\""));
            }
        }
    }
    Ok(())
}

/// The person who wears a display: the one that it names, else the one that the scene names.
fn worn_by(
    bench: &Loaded<Bench>,
    number: usize,
    display: &BenchDisplay,
    people: &People,
) -> Result<People, FileError> {
    let (mut person, mut wearer) = people.clone();
    let at = |key: &str| format!("displays[{number}].{key}");
    if let Some(name) = &display.person {
        person = bench.refer(name, &at("person"))?;
    }
    if let Some(name) = &display.wearer {
        wearer = Some(bench.refer(name, &at("wearer"))?);
    }
    Ok((person, wearer))
}
