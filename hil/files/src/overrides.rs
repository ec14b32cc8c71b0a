//! Values in place of a scene's or bench's own, checked as if the files stated them.

use std::fmt::Display;

use serde::{Deserialize, Serialize};

use super::change::Change;
use super::error::FileError;
use super::scene::Scene;

/// Changes to a scene and a bench, key by key. The last change of a key counts.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Overrides {
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) scene: Vec<Change>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) bench: Vec<Change>,
}

impl Overrides {
    /// Puts `value` (TOML, or a plain string) at a key of the scene. Errors about it name `by` in place of a file.
    pub fn scene(&mut self, by: &str, key: &str, value: impl Display) {
        let value = Some(value.to_string());
        self.scene.push(change(by, key, value));
    }

    /// Adds a change to the bench.
    pub fn bench(&mut self, by: &str, key: &str, value: impl Display) {
        let value = Some(value.to_string());
        self.bench.push(change(by, key, value));
    }

    /// Reads `KEY=VALUE`: a key of the scene, or after `bench.` one of the bench.
    ///
    /// # Errors
    /// A text without `=` or without a key; errors about key or value come where the file is read.
    pub fn set(&mut self, by: &str, text: &str) -> Result<(), FileError> {
        let parts = text.split_once('=').map(|(k, v)| (k.trim(), v.trim()));
        match parts.filter(|(key, _)| !key.is_empty()) {
            Some((key, value)) => match key.strip_prefix("bench.") {
                Some(key) => self.bench(by, key, value),
                None => self.scene(by, key, value),
            },
            None => return Err(FileError::whole(by, "KEY=VALUE", format!("`{text}`"))),
        }
        Ok(())
    }

    /// The scene's changes, behind those that remove keys which they make meaningless in a file.
    pub(super) fn of_scene(&self, file: &Scene) -> Vec<Change> {
        let last = |key: &str| self.scene.iter().rfind(|change| change.key == key);
        let mut dropped = Vec::new();
        let name = file.illusion.model.name();
        let other = |change: &&Change| change.value.as_deref().map(unquoted) != Some(name);
        if let Some(model) = last("illusion.model").filter(other) {
            // The file stated those keys for its own model.
            let keys = [
                "illusion.shape",
                "illusion.shape_y",
                "illusion.distances",
                "illusion.flat",
                "illusion.level_db",
            ];
            dropped.extend(keys.map(|key| change(&model.by, key, None)));
        }
        if let Some(shape) = last("illusion.shape") {
            dropped.push(change(&shape.by, "illusion.flat", None));
        }
        dropped.extend(self.scene.iter().cloned());
        dropped
    }
}

fn unquoted(text: &str) -> &str {
    text.trim_matches(['"', '\''])
}

fn change(by: &str, key: &str, value: Option<String>) -> Change {
    Change {
        by: by.into(),
        key: key.into(),
        value,
    }
}
