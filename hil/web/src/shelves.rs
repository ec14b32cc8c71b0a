//! Built-in files for a page to choose from, each with its own description.

use palpate_core::illusion::IllusionModel;
use palpate_core::render::Style;
use palpate_files::{
    DEFAULT_BENCH, FileKind, LayoutFile, built_in, load_bench, load_layout, load_scene,
};
use palpate_run::Failure;
use serde::Serialize;

/// Most taxels of a skin that a page offers: it draws as many at 60 pictures per second.
const MOST_OFFERED: usize = 4096;

/// All shelves, in alphabetical order but for illusions and renderers.
#[derive(Debug, Serialize)]
pub struct Shelves {
    version: &'static str,
    scenes: Vec<Offer>,
    skins: Vec<Offer>,
    displays: Vec<Offer>,
    benches: Vec<Offer>,
    illusions: [&'static str; 9],
    renderers: [&'static str; 3],
    persons: Vec<Offer>,
    wires: Vec<Offer>,
}

/// A file or word that a page offers.
#[derive(Debug, Serialize)]
struct Offer {
    name: String,
    description: String,
    /// `true` for a scene that wants the texture model.
    #[serde(skip_serializing_if = "is_false")]
    texture: bool,
    /// `true` for a bench of motors, which has no wires to choose.
    #[serde(skip_serializing_if = "is_false")]
    motors: bool,
    /// Bench of a scene that wants one of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    bench: Option<String>,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
const fn is_false(value: &bool) -> bool {
    !*value
}

fn shelf(kind: FileKind) -> impl Iterator<Item = Offer> {
    let listed = built_in(kind).into_iter();
    listed.map(|file| Offer {
        name: file.name,
        description: file.description,
        texture: false,
        motors: false,
        bench: None,
    })
}

/// Reads the shelves.
///
/// # Errors
/// A built-in file that cannot be read, which its tests would have found.
pub fn shelves() -> Result<Shelves, Failure> {
    let (mut scenes, mut skins, mut displays) = (Vec::new(), Vec::new(), Vec::new());
    for scene in shelf(FileKind::Scene) {
        let file = load_scene(&scene.name)?.value;
        let (own, texture) = (file.own_bench(), file.texture.is_some());
        if !load_bench(own)?.value.displays.is_empty() {
            continue;
        }
        let bench = (own != DEFAULT_BENCH).then(|| own.to_owned());
        scenes.push(Offer {
            texture,
            bench,
            ..scene
        });
    }
    for layout in shelf(FileKind::Layout).filter(|layout| layout.name != "million") {
        match load_layout(&layout.name)?.value {
            LayoutFile::Sensor(sensor) if sensor.readings() <= MOST_OFFERED => skins.push(layout),
            LayoutFile::Sensor(_) => {}
            LayoutFile::Display(_) => displays.push(layout),
        }
    }
    let mut benches = Vec::new();
    for bench in shelf(FileKind::Bench) {
        let own = load_bench(&bench.name)?.value;
        let motors = own.haptics.is_some();
        if own.displays.is_empty() {
            benches.push(Offer { motors, ..bench });
        }
    }
    Ok(Shelves {
        version: env!("CARGO_PKG_VERSION"),
        scenes,
        skins,
        displays,
        benches,
        illusions: IllusionModel::ALL.map(IllusionModel::name),
        renderers: Style::ALL.map(Style::name),
        persons: shelf(FileKind::Person).collect(),
        wires: shelf(FileKind::Wire).collect(),
    })
}
