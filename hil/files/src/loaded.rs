//! Files read by name or path, each beside its text.

use std::path::PathBuf;

use super::activation::ActivationFile;
use super::bench::Bench;
use super::error::FileError;
use super::layout::LayoutFile;
use super::limits::LimitTable;
use super::overrides::Overrides;
use super::person::PersonFile;
use super::protocol::Protocol;
use super::resolve::{FileKind, resolve, resolve_from};
use super::scene::Scene;
use super::source::Source;
use super::texture::TextureTable;
use super::wire::{AlloyFile, WireFile};

/// What was read, beside its text: later checks name a line with [`Source::bad`].
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded<T> {
    /// What the file says.
    pub value: T,
    /// Where it says so.
    pub source: Source,
}

impl Loaded<Scene> {
    /// The scene read again with these changes.
    ///
    /// # Errors
    /// Names the option and key of what cannot be.
    pub fn with(self, overrides: &Overrides) -> Result<Self, FileError> {
        let source = self.source.with(overrides.of_scene(&self.value));
        let value = Scene::read(&source)?;
        Ok(Self { value, source })
    }
}

/// How a kind of file is read.
type Read<T> = fn(&Source) -> Result<T, FileError>;

fn load<T>(source: Source, read: Read<T>) -> Result<Loaded<T>, FileError> {
    let value = read(&source)?;
    Ok(Loaded { value, source })
}

impl<T> Loaded<T> {
    /// The file that stands under `key` of this one.
    pub(super) fn refer<U>(
        &self,
        kind: FileKind,
        read: Read<U>,
        name: &str,
        key: &str,
    ) -> Result<Loaded<U>, FileError> {
        load(resolve_from(kind, name, &self.source, key)?, read)
    }
}

/// A scene by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_scene(name: &str) -> Result<Loaded<Scene>, FileError> {
    load(resolve(FileKind::Scene, name)?, Scene::read)
}

/// A layout of either kind by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_layout(name: &str) -> Result<Loaded<LayoutFile>, FileError> {
    load(resolve(FileKind::Layout, name)?, LayoutFile::read)
}

/// A bench by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_bench(name: &str) -> Result<Loaded<Bench>, FileError> {
    load(resolve(FileKind::Bench, name)?, Bench::read)
}

/// A limit table by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_limits(name: &str) -> Result<Loaded<LimitTable>, FileError> {
    load(resolve(FileKind::Limits, name)?, LimitTable::read)
}

/// A person by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_person(name: &str) -> Result<Loaded<PersonFile>, FileError> {
    load(resolve(FileKind::Person, name)?, PersonFile::read)
}

/// A protocol by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_protocol(name: &str) -> Result<Loaded<Protocol>, FileError> {
    load(resolve(FileKind::Protocol, name)?, Protocol::read)
}

/// Reads an activation: a built-in name or a file.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_activation(name: &str) -> Result<Loaded<ActivationFile>, FileError> {
    load(resolve(FileKind::Activation, name)?, ActivationFile::read)
}

/// A table of textures by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_textures(name: &str) -> Result<Loaded<TextureTable>, FileError> {
    load(resolve(FileKind::Textures, name)?, TextureTable::read)
}

/// An alloy by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_alloy(name: &str) -> Result<Loaded<AlloyFile>, FileError> {
    load(resolve(FileKind::Alloy, name)?, AlloyFile::read)
}

/// A wire by name or path.
///
/// # Errors
/// An unknown name, or what cannot be in the file.
pub fn load_wire(name: &str) -> Result<Loaded<WireFile>, FileError> {
    load(resolve(FileKind::Wire, name)?, WireFile::read)
}

impl Loaded<Protocol> {
    /// The scene of a condition, by its place among them, with its changes; `None` where nothing is played.
    ///
    /// # Errors
    /// An unknown name, or what cannot be in the scene.
    pub fn scene(&self, condition: usize) -> Result<Option<Loaded<Scene>>, FileError> {
        let named = self.value.conditions.get(condition);
        let Some((condition, name)) = named.and_then(|c| Some((c, c.scene.as_ref()?))) else {
            return Ok(None);
        };
        let place = self.value.conditions.iter().position(|c| c == condition);
        let key = format!("conditions[{}].scene", place.unwrap_or(0));
        let scene = self.refer(FileKind::Scene, Scene::read, name, &key)?;
        scene.with(&condition.overrides()?).map(Some)
    }
}

impl Loaded<Bench> {
    /// The file of the key of its unit: a relative name starts at the folder of the bench's file.
    #[must_use]
    pub fn unit_key(&self) -> Option<PathBuf> {
        let name = self.value.unit.as_ref()?.key.as_ref()?;
        let folder = self.source.folder_of("unit.key");
        Some(folder.map_or_else(|| name.into(), |folder| folder.join(name)))
    }
}
