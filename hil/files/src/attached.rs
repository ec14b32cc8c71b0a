//! A setup from the texts that a recording has with it, and what options of the command line had put in place of them.

use serde::{Deserialize, Serialize};

use super::bench::Bench;
use super::change::Change;
use super::error::FileError;
use super::layout::{DisplayLayout, LayoutFile, SensorLayout};
use super::limits::LimitTable;
use super::loaded::Loaded;
use super::person::{PersonFile, Wearer};
use super::scene::Scene;
use super::setup::Setup;
use super::source::Source;
use super::wire::{AlloyFile, WireFile};
use palpate_core::guard::Earlier;
use palpate_core::units::Duration;

/// Changes to scene and bench, as a text has them.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Changes {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    scene: Vec<Stated>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bench: Vec<Stated>,
}

/// One of them.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stated {
    by: String,
    key: String,
    /// None where the file's own value counts no more.
    value: Option<String>,
}

fn stated(source: &Source) -> Vec<Stated> {
    let changes = source.changes().iter().cloned();
    let stated = changes.map(|Change { by, key, value }| Stated { by, key, value });
    stated.collect()
}

fn changes(stated: Vec<Stated>) -> Vec<Change> {
    let stated = stated.into_iter();
    let changes = stated.map(|Stated { by, key, value }| Change { by, key, value });
    changes.collect()
}

impl Setup {
    /// What options put in place of values of scene and bench, as a text that [`Setup::attached`] takes; none where they
    /// changed nothing.
    #[must_use]
    pub fn changes(&self) -> Option<String> {
        let all = Changes {
            scene: stated(&self.scene.source),
            bench: stated(&self.bench.source),
        };
        let any = !(all.scene.is_empty() && all.bench.is_empty());
        any.then(|| toml::to_string(&all).ok()).flatten()
    }

    /// The setup of a run from the texts that its recording has: `text` gives that of a file by its name, such as
    /// `scene.toml`. Textures are left out, since their tables are not with a recording.
    ///
    /// # Errors
    /// A file that is not there, under `label`, and what cannot be in one.
    pub fn attached(label: &str, text: impl Fn(&str) -> Option<String>) -> Result<Self, FileError> {
        let named = |name: &str| {
            let found = text(name).map(|text| Source::new(format!("{label}: {name}"), text));
            found.ok_or_else(|| {
                let expected =
                    format!("the file {name} attached to it, as `hil run --record` does");
                FileError::whole(label, expected, "none")
            })
        };
        let all = match text("changes.toml") {
            None => Changes::default(),
            Some(text) => Source::new(format!("{label}: changes.toml"), text).read()?,
        };
        let source = named("scene.toml")?.with(changes(all.scene));
        let mut value = Scene::read(&source)?;
        value.texture = None;
        value.fingers.iter_mut().for_each(|f| f.texture = None);
        let scene = Loaded { value, source };
        let source = named("bench.toml")?.with(changes(all.bench));
        let value = Bench::read(&source)?;
        let bench = Loaded { value, source };
        if !bench.value.displays.is_empty() {
            return Self::join(scene, bench);
        }
        let wearer = text("wearer.toml").map(|_| named("wearer.toml"));
        let wearer = wearer.transpose()?;
        Ok(Self {
            sensor: sensor(named("sensor.toml")?)?,
            display: display(named("display.toml")?)?,
            limits: read(named("limits.toml")?, LimitTable::read)?,
            wire: read(named("wire.toml")?, WireFile::read)?,
            alloy: read(named("alloy.toml")?, AlloyFile::read)?,
            person: read(named("person.toml")?, PersonFile::read)?,
            wearer: wearer
                .map(|source| read(source, Wearer::read))
                .transpose()?,
            texture: None,
            fingers: Vec::new(),
            section: String::new(),
            bus_wait: Duration::ZERO,
            unit: None,
            earlier: Earlier::default(),
            observed: false,
            scene,
            bench,
        })
    }
}

fn read<T>(
    source: Source,
    read: fn(&Source) -> Result<T, FileError>,
) -> Result<Loaded<T>, FileError> {
    let value = read(&source)?;
    Ok(Loaded { value, source })
}

fn sensor(source: Source) -> Result<Loaded<SensorLayout>, FileError> {
    match LayoutFile::read(&source)? {
        LayoutFile::Sensor(value) => Ok(Loaded { value, source }),
        LayoutFile::Display(_) => Err(source.bad("kind", "\"sensor\"")),
    }
}

fn display(source: Source) -> Result<Loaded<DisplayLayout>, FileError> {
    match LayoutFile::read(&source)? {
        LayoutFile::Display(value) => Ok(Loaded { value, source }),
        LayoutFile::Sensor(_) => Err(source.bad("kind", "\"display\"")),
    }
}

#[cfg(test)]
#[path = "attached_tests.rs"]
mod tests;
