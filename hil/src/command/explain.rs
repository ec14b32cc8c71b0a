//! `hil run --explain`: what a scene asks for and what is built for it; afterwards what was done and what was left
//! out, in counts and time. Everything left out would have given the same bytes; tests hold every shortcut to that.

use std::io::{self, Write};

use palpate_core::contact::Scope;
use palpate_files::{
    Felt, FeltBy, Finger, LevelsFrom, Scene, SceneStroke, Setup, ThresholdFrom, Transducer,
};
use palpate_run::Outcome;
use palpate_run::effort::FrameKind;

/// The plan: one line a stage.
///
/// # Errors
/// Errors of the stream.
pub fn plan(setup: &Setup, out: &mut dyn Write) -> io::Result<()> {
    let scene = &setup.scene.value;
    writeln!(out, "plan")?;
    let mut row = |name: &str, value: String| writeln!(out, "  {name:<16}{value}");
    row("threshold", threshold(scene))?;
    row(
        "reference",
        match scene.drift_s {
            Some(s) => format!(
                "{} frames, then follows drift in {s} s",
                scene.reference_frames
            ),
            None => format!("{} frames, and stays", scene.reference_frames),
        },
    )?;
    row("contacts", contacts(setup))?;
    row(
        "levels",
        match (scene.compression.ki, scene.compression.levels) {
            (1, _) => "one: none to find, no first pass".into(),
            (k, LevelsFrom::Dynamic) => {
                format!("{k}, dynamic: found anew in every frame, no first pass")
            }
            (k, LevelsFrom::Static) => {
                format!("{k}, static: a first pass over the whole input finds them exactly")
            }
        },
    )?;
    row(
        "intensity",
        if scene.illusion.intensity {
            "levels set how hard wires are driven".into()
        } else {
            "off: levels are recorded, and no wire heeds them".into()
        },
    )?;
    row("skin", skin(setup))?;
    row("map", map(setup))?;
    if let Some(fingers) = each(setup, None, |finger| Some(driven_by(setup, finger)), |w| w) {
        row("fingers", fingers)?;
    }
    row("texture", texture(setup))?;
    row("strokes", strokes(setup))?;
    row(
        "display",
        match setup.fingers.as_slice() {
            [] => format!(
                "{} wires, written only where registers change",
                setup.display.value.wires_mm.len()
            ),
            fingers => several(setup, fingers),
        },
    )
}

/// Words for a property of each finger, by name, or of the only display.
fn each<T>(
    setup: &Setup,
    own: Option<T>,
    of: impl Fn(&Finger) -> Option<T>,
    words: impl Fn(T) -> String,
) -> Option<String> {
    if setup.fingers.is_empty() {
        return own.map(words);
    }
    let named = |finger: &Finger| Some(format!("{}: {}", finger.name, words(of(finger)?)));
    let all: Vec<String> = setup.fingers.iter().filter_map(named).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

/// Modules that drive a finger, and the joint's angles at which it is felt.
fn driven_by(setup: &Setup, finger: &Finger) -> String {
    let modules = &setup.sensor.value.modules;
    let name = |module: &usize| modules.get(*module).map_or("?", |m| &*m.name);
    let from = match finger.modules.as_slice() {
        [only] => format!("`{}`", name(only)),
        all if finger.merged => format!("{} modules merged", all.len()),
        all => format!(
            "`{}` of {} modules",
            all.first().map_or("?", name),
            all.len()
        ),
    };
    let Some(gate) = &finger.when else {
        return from;
    };
    let joints = &setup.scene.value.joints;
    let joint = joints
        .get(gate.joint)
        .map_or("the recording's", |j| &*j.name);
    let is_open = match (gate.above_deg.is_finite(), gate.below_deg.is_finite()) {
        (true, true) => format!("between {} and {}", gate.above_deg, gate.below_deg),
        (true, false) => format!("above {}", gate.above_deg),
        _ => format!("below {}", gate.below_deg),
    };
    format!("{from}, felt while joint {joint} is {is_open} degrees")
}

fn texture(setup: &Setup) -> String {
    let words = |felt: Felt| {
        let surface = felt
            .surface
            .map_or("what is recorded".into(), |s| format!("`{s}`"));
        match felt.carrier {
            FeltBy::Contacts => format!("{surface}, thins out bursts"),
            FeltBy::Display => format!("{surface}, in place of contacts"),
        }
    };
    let own = setup.scene.value.texture.clone();
    let of = |finger: &Finger| Some(finger.texture.as_ref()?.0.clone());
    let all = each(setup, own, of, words);
    all.unwrap_or_else(|| "none: no encoder is built".into())
}

fn strokes(setup: &Setup) -> String {
    let some = |strokes: &[SceneStroke]| (!strokes.is_empty()).then_some(strokes.len());
    let own = some(&setup.scene.value.strokes);
    let of = |finger: &Finger| some(&finger.strokes);
    let all = each(setup, own, of, |n| format!("{n}, in place of contacts"));
    all.unwrap_or_else(|| "none: none is planned".into())
}

fn skin(setup: &Setup) -> String {
    let layout = &setup.sensor.value;
    let way = match (&setup.scene.value.stream, layout.transducer) {
        (Some(_), _) => "read by another machine, over a network",
        (None, _) if layout.modules.iter().all(|m| m.bus.is_none()) => "whole scans, no bus",
        (None, Transducer::Capacitive) => "MTB boards on CAN",
        (None, _) => "uSkin boards on CAN",
    };
    let taxels = layout.readings();
    format!("`{}`, {taxels} taxels read: {way}", layout.name)
}

fn map(setup: &Setup) -> String {
    let scene = &setup.scene.value;
    let map = &scene.map;
    match (map.window_mm, map.sensor_mm, scene.compression.scope) {
        (Some([w, h]), _, _) => format!(
            "a window of {w} mm by {h} mm goes to a contact outside that is {} % stronger than all inside",
            map.hysteresis * 100.0
        ),
        (None, Some([x0, y0, x1, y1]), _) => {
            format!(
                "the region [{x0}, {y0}, {x1}, {y1}] mm fills the display; contacts outside are not felt"
            )
        }
        (None, None, Scope::Skin) => "the whole skin's hull fills the display".into(),
        (None, None, Scope::Module) if !setup.fingers.is_empty() => {
            "the hull of the modules that drive a finger fills its display".into()
        }
        (None, None, Scope::Module) => {
            "the hull of the driving module's taxels fills the display".into()
        }
    }
}

fn several(setup: &Setup, fingers: &[Finger]) -> String {
    let names = |names: Vec<&str>| names.join(", ");
    let driven: Vec<&str> = fingers.iter().map(|f| &*f.name).collect();
    let displays = setup.bench.value.displays.iter().map(|d| &*d.name);
    let idle: Vec<&str> = displays.filter(|name| !driven.contains(name)).collect();
    let left_out = match idle.is_empty() {
        true => String::new(),
        false => format!("; {} driven by nothing: not built", names(idle)),
    };
    format!("a loop of its own for each of {}{left_out}", names(driven))
}

fn threshold(scene: &Scene) -> String {
    let margin = scene.threshold_margin;
    match scene.threshold {
        ThresholdFrom::Maximum => {
            format!("one for all: largest value of a frame, and {margin} counts")
        }
        ThresholdFrom::PerTaxel => format!(
            "each taxel's own: {} deviations of its noise, and {margin} counts",
            palpate_files::THRESHOLD_SIGMAS
        ),
    }
}

fn contacts(setup: &Setup) -> String {
    let (c, modules) = (
        &setup.scene.value.compression,
        setup.sensor.value.modules.len(),
    );
    let span = match (c.scope, modules) {
        (Scope::Skin, _) => "for the whole skin".into(),
        (Scope::Module, 1) => "for the module".into(),
        (Scope::Module, n) if !setup.fingers.is_empty() => {
            format!(
                "for each of {n} modules, for all together where they are merged; all are recorded"
            )
        }
        (Scope::Module, n) => {
            format!("for each of {n} modules; all are recorded, one drives the display")
        }
    };
    let how = match c.most_contacts() {
        1 => "a weighted mean, no iteration",
        _ => "passed through up to that many taxels, else weighted K-means from the last frame",
    };
    let grows = match c.most_contacts() > c.kc {
        true => format!(" ({} with so many touches)", c.most_contacts()),
        false => String::new(),
    };
    format!("at most {}{grows} {span}: {how}", c.kc)
}

/// Work that was done and left out.
///
/// # Errors
/// Errors of the stream.
pub fn done(outcome: &Outcome, out: &mut dyn Write) -> io::Result<()> {
    let effort = &outcome.effort;
    let work = &effort.compression;
    writeln!(out, "done and left out")?;
    for kind in FrameKind::ALL {
        let (count, median, sum) = effort.frames(kind);
        let name = match kind {
            FrameKind::Repeated => "repeated",
            FrameKind::Untouched => "untouched",
            FrameKind::Direct => "no iteration",
            FrameKind::Solved => "iterated",
        };
        let time = if count == 0 {
            String::new()
        } else {
            format!(", {median:.2} us median, {:.2} ms together", sum * 1e-3)
        };
        writeln!(out, "  {name:<16}{count} frames{time}")?;
    }
    let mut row = |name: &str, value: String| writeln!(out, "  {name:<16}{value}");
    row(
        "modules",
        format!(
            "{} untouched, {} repeated, {} passed through, {} means, {} solved",
            work.untouched, work.repeated, work.passed, work.means, work.solves
        ),
    )?;
    row(
        "assignments",
        format!(
            "{} by a pass over the taxels, {} known without; {} seeded afresh",
            work.passes,
            work.iterations - work.passes,
            work.seeded
        ),
    )?;
    row(
        "levels",
        if effort.calibrated {
            "first pass made".into()
        } else {
            "first pass left out".into()
        },
    )?;
    row(
        "onsets",
        format!(
            "{}, of which {} had nothing to project",
            effort.onsets, effort.silent_onsets
        ),
    )?;
    let possible = effort.onsets * effort.wires as u64;
    row(
        "wires",
        format!(
            "{} stimuli of {possible} possible; {} of {} wires stayed cold throughout",
            effort.driven, effort.cold_wires, effort.wires
        ),
    )?;
    let t = &effort.traffic;
    row(
        "registers",
        format!(
            "{} updates sent and {} left out; {} channels written, {} held their value",
            t.writes, t.unchanged_updates, t.channels, t.unchanged_channels
        ),
    )
}
