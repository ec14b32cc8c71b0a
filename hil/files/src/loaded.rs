//! Files read by name or path, each beside its text.

use std::path::PathBuf;

use super::activation::ActivationFile;
use super::band::BandFile;
use super::bench::Bench;
use super::error::FileError;
use super::evidence::EvidenceFile;
use super::layout::{LayoutFile, SensorLayout};
use super::limits::LimitTable;
use super::near::nearest;
use super::overrides::Overrides;
use super::person::{PersonFile, Wearer};
use super::placeholder::keys;
use super::priors::PriorsFile;
use super::protocol::Protocol;
use super::recipe::Recipe;
use super::resolve::{FileKind, resolve, resolve_from};
use super::scene::Scene;
use super::source::Source;
use super::texture::TextureTable;
use super::wire::{AlloyFile, WireFile};

/// A value with the text that it was read from: later checks name a line with [`Source::bad`].
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded<T> {
    /// The value.
    pub value: T,
    /// The text that states it.
    pub source: Source,
}

impl Loaded<Scene> {
    /// The scene read again with these changes.
    ///
    /// # Errors
    /// Names the option and key of a value that is refused.
    pub fn with(self, overrides: &Overrides) -> Result<Self, FileError> {
        Self::read(self.source.with(overrides.of_scene(&self.value)))
    }
}

/// The content of one kind of settings file.
pub trait Settings: Sized {
    /// The kind.
    const KIND: FileKind;

    /// Reads and checks a file of this kind.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    fn read(source: &Source) -> Result<Self, FileError>;
}

/// The types of settings files with their kinds, and the function that loads one, where callers name such files.
macro_rules! files {
    ($($type:ident = $kind:ident $(, $load:ident $noun:literal)?;)+) => {$(
        impl Settings for $type {
            const KIND: FileKind = FileKind::$kind;

            fn read(source: &Source) -> Result<Self, FileError> {
                Self::read(source)
            }
        }

        $(
            #[doc = concat!($noun, " by name or path.")]
            ///
            /// # Errors
            /// An unknown name, or a value of the file that is refused.
            pub fn $load(name: &str) -> Result<Loaded<$type>, FileError> {
                Loaded::named(name)
            }
        )?
    )+};
}

files! {
    Scene = Scene, load_scene "A scene";
    LayoutFile = Layout, load_layout "A layout of either kind";
    Bench = Bench, load_bench "A bench";
    LimitTable = Limits;
    PersonFile = Person, load_person "A person";
    Wearer = Wearer;
    WireFile = Wire, load_wire "A wire";
    AlloyFile = Alloy, load_alloy "An alloy";
    ActivationFile = Activation, load_activation "An activation";
    TextureTable = Textures, load_textures "A table of textures";
    Protocol = Protocol, load_protocol "A protocol";
    PriorsFile = Priors, load_priors "Priors";
    EvidenceFile = Evidence, load_evidence "Evidence";
    BandFile = Band;
    Recipe = Recording, load_recipe "A recipe of a recording";
}

/// A skin by name or path: a layout of kind "sensor".
///
/// # Errors
/// The errors of [`load_layout`], and a layout of the other kind.
pub fn load_skin(name: &str) -> Result<Loaded<SensorLayout>, FileError> {
    load_layout(name)?.skin()
}

impl Loaded<LayoutFile> {
    pub(super) fn skin(self) -> Result<Loaded<SensorLayout>, FileError> {
        let source = self.source;
        match self.value {
            LayoutFile::Sensor(value) => Ok(Loaded { value, source }),
            LayoutFile::Display(_) => Err(source.bad("kind", "\"sensor\"")),
        }
    }
}

impl<T: Settings> Loaded<T> {
    /// Reads a text, and keeps it beside its value.
    ///
    /// # Errors
    /// Names the line and key of a value that is refused.
    pub fn read(source: Source) -> Result<Self, FileError> {
        let value = T::read(&source).map_err(|error| match cfg!(target_family = "wasm") {
            // Nobody types keys in a browser's page, and the schemas weigh 24 kB with gzip.
            true => error,
            false => elsewhere(T::KIND, error),
        })?;
        Ok(Self { value, source })
    }

    /// Reads the file of a name or path.
    pub(super) fn named(name: &str) -> Result<Self, FileError> {
        Self::read(resolve(T::KIND, name)?)
    }
}

/// Improves an unknown key's error with the place where such a key stands, if that is another: deeper in the same
/// file, or in the other one of scene and bench.
fn elsewhere(kind: FileKind, error: FileError) -> FileError {
    let unknown = error.found.strip_prefix("the unknown key `");
    let Some(word) = unknown.and_then(|rest| Some(rest.split_once('`')?.0)) else {
        return error;
    };
    let last = |key: &String| key.rsplit('.').next().unwrap_or(key).to_owned();
    let is_option = error.path.starts_with("--");
    let (own, other) = match kind {
        FileKind::Bench if is_option => ("bench.", Some((FileKind::Scene, "", "a scene"))),
        FileKind::Scene => ("", Some((FileKind::Bench, "bench.", "a bench"))),
        FileKind::Bench => ("", Some((FileKind::Scene, "", "a scene"))),
        _ => ("", None),
    };
    let own_keys = keys(kind);
    let here = own_keys.iter().find(|key| last(key) == word);
    let there = other
        .filter(|_| here.is_none())
        .and_then(|(kind, by, noun)| {
            let found = keys(kind).into_iter().find(|key| last(key) == word)?;
            Some((format!("{by}{found}"), found, noun))
        });
    let near = || {
        let names: Vec<String> = own_keys.iter().map(last).collect();
        let near = nearest(word, names.iter().map(String::as_str))?;
        own_keys.iter().find(|key| last(key) == near)
    };
    let asked = |key: &str| format!("the unknown key `{word}`; did you mean `{key}`?");
    let found = match (here, there) {
        (Some(key), _) => asked(&format!("{own}{key}")),
        (None, Some((option, ..))) if is_option => asked(&option),
        (None, Some((_, key, noun))) => format!("the unknown key `{word}`; {noun} has `{key}`"),
        // The error has named the near keys of its own table.
        (None, None) if error.found.contains("did you mean") => return error,
        (None, None) => match near() {
            Some(key) => asked(&format!("{own}{key}")),
            None => return error,
        },
    };
    FileError { found, ..error }
}

impl<T> Loaded<T> {
    /// Reads the file that stands under `key` of this one.
    pub(super) fn refer<U: Settings>(&self, name: &str, key: &str) -> Result<Loaded<U>, FileError> {
        Loaded::read(resolve_from(U::KIND, name, &self.source, key)?)
    }
}

/// A word of a command line, in quotes where a shell would read it otherwise.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "=._/-+:,".contains(c);
    match word.chars().all(plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

impl Loaded<Protocol> {
    /// The scene of a condition, by its place among them, with its changes; `None` where the condition plays none.
    ///
    /// # Errors
    /// An unknown name, or a value of the scene that is refused.
    pub fn scene(&self, condition: usize) -> Result<Option<Loaded<Scene>>, FileError> {
        let named = self.value.conditions.get(condition);
        let Some((condition, name)) = named.and_then(|c| Some((c, c.scene.as_ref()?))) else {
            return Ok(None);
        };
        let place = self.value.conditions.iter().position(|c| c == condition);
        let key = format!("conditions[{}].scene", place.unwrap_or(0));
        let scene: Loaded<Scene> = self.refer(name, &key)?;
        scene.with(&condition.overrides()?).map(Some)
    }
}

impl Loaded<Bench> {
    /// Returns true if the bench is a built-in one, as it ships.
    #[must_use]
    pub fn is_as_shipped(&self) -> bool {
        let shipped = FileKind::Bench.built_in(&self.value.name);
        shipped == Some(self.source.text()) && self.source.changes().is_empty()
    }

    /// The bench as a command line names it, with an option for each value in place of its own.
    #[must_use]
    pub fn typed(&self) -> String {
        let mut words = match self.source.folder() {
            Some(_) => self.source.label().to_owned(),
            None => self.value.name.clone(),
        };
        for change in self.source.changes() {
            if let Some(value) = change.value.as_ref().filter(|_| change.key != "band") {
                words += &format!(" --set {}", quoted(&format!("{}={value}", change.key)));
            }
        }
        words
    }

    /// The key file of the bench's unit: a relative name starts at the folder of the bench's file.
    #[must_use]
    pub fn unit_key(&self) -> Option<PathBuf> {
        let name = self.value.unit.as_ref()?.key.as_ref()?;
        let folder = self.source.folder_of("unit.key");
        Some(folder.map_or_else(|| name.into(), |folder| folder.join(name)))
    }
}
