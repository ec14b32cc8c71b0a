//! A setup from the texts of a recording, with the changes that options of the command line made to them.

use super::bench::Bench;
use super::error::FileError;
use super::layout::LayoutFile;
use super::loaded::Loaded;
use super::overrides::Overrides;
use super::scene::Scene;
use super::setup::{Pass, Setup};
use super::source::Source;
use palpate_core::units::Duration;

impl Setup {
    /// Changes that options made to scene and bench, as a text that [`Setup::attached`] takes; none where they
    /// changed nothing.
    #[must_use]
    pub fn changes(&self) -> Option<String> {
        let all = Overrides {
            scene: self.scene.source.changes().to_vec(),
            bench: self.bench.source.changes().to_vec(),
        };
        let any = all != Overrides::default();
        any.then(|| toml::to_string(&all).ok()).flatten()
    }

    /// The setup of a run from the texts that its recording has: `text` gives that of a file by its name, such as
    /// `scene.toml`. Textures are left out, since their tables are not with a recording.
    ///
    /// # Errors
    /// A file that is missing, under `label`, and a value in one that is refused.
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
            None => Overrides::default(),
            Some(text) => Source::new(format!("{label}: changes.toml"), text).read()?,
        };
        let mut scene: Loaded<Scene> = Loaded::read(named("scene.toml")?.with(all.scene))?;
        scene.value.texture = None;
        let fingers = scene.value.fingers.iter_mut();
        fingers.for_each(|f| f.texture = None);
        let bench: Loaded<Bench> = Loaded::read(named("bench.toml")?.with(all.bench))?;
        if !bench.value.displays.is_empty() {
            return Self::join(scene, bench);
        }
        let wearer = text("wearer.toml").map(|_| named("wearer.toml"));
        let wearer = wearer.transpose()?;
        let layout = |source: Source| -> Result<_, FileError> {
            let value = LayoutFile::read(&source)?;
            Ok(Loaded { value, source })
        };
        let Loaded { value, source } = layout(named("display.toml")?)?;
        let LayoutFile::Display(value) = value else {
            return Err(source.bad("kind", "\"display\""));
        };
        Ok(Self {
            sensor: layout(named("sensor.toml")?)?.skin()?,
            display: Loaded { value, source },
            limits: Loaded::read(named("limits.toml")?)?,
            wire: Loaded::read(named("wire.toml")?)?,
            alloy: Loaded::read(named("alloy.toml")?)?,
            band: None,
            person: Loaded::read(named("person.toml")?)?,
            wearer: wearer.map(Loaded::read).transpose()?,
            texture: None,
            fingers: Vec::new(),
            section: String::new(),
            bus_wait: Duration::ZERO,
            unit: None,
            memory: None,
            pass: Pass::default(),
            told: None,
            drawn: None,
            observed: false,
            scene,
            bench,
        })
    }
}

#[cfg(test)]
#[path = "attached_tests.rs"]
mod tests;
