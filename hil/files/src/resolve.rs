//! A name or a path, as the user typed it, to a text.

use std::path::{Path, PathBuf};

use super::error::FileError;
use super::near::did_you_mean;
use super::source::Source;

/// The kinds of settings file; each has its own shelf of built-in names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// What touches the skin, and how it is projected.
    Scene,
    /// Where taxels or wires are.
    Layout,
    /// Which hardware, emulated or real.
    Bench,
    /// What the guard enforces.
    Limits,
    /// The emulated person.
    Person,
    /// A wearer's calibration.
    Wearer,
    /// A shape-memory wire.
    Wire,
    /// What it is made of.
    Alloy,
    /// From roughness to pulses.
    Activation,
    /// A table of textures.
    Textures,
    /// Trials that are known to fail.
    Quarantine,
    /// A study with people.
    Protocol,
}

impl FileKind {
    /// Every kind.
    pub const ALL: [Self; 12] = [
        Self::Scene,
        Self::Bench,
        Self::Layout,
        Self::Limits,
        Self::Person,
        Self::Wearer,
        Self::Wire,
        Self::Alloy,
        Self::Activation,
        Self::Textures,
        Self::Quarantine,
        Self::Protocol,
    ];

    /// Its name, as the schema of such files has it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Layout => "layout",
            Self::Bench => "bench",
            Self::Limits => "limits",
            Self::Person => "person",
            Self::Wearer => "wearer",
            Self::Wire => "wire",
            Self::Alloy => "alloy",
            Self::Activation => "activation",
            Self::Textures => "textures",
            Self::Quarantine => "quarantine",
            Self::Protocol => "protocol",
        }
    }

    /// The name of its shelf: that of the folder of the built-in ones.
    #[must_use]
    pub const fn folder(self) -> &'static str {
        match self {
            Self::Scene => "scenes",
            Self::Layout => "layouts",
            Self::Bench => "benches",
            Self::Limits => "limits",
            Self::Person => "persons",
            Self::Wearer => "wearers",
            Self::Wire => "wires",
            Self::Alloy => "alloys",
            Self::Activation => "activations",
            Self::Textures => "textures",
            Self::Quarantine => "quarantines",
            Self::Protocol => "protocols",
        }
    }

    /// The kind with its article.
    #[must_use]
    pub const fn noun(self) -> &'static str {
        match self {
            Self::Scene => "a scene",
            Self::Layout => "a layout",
            Self::Bench => "a bench",
            Self::Limits => "a limit table",
            Self::Person => "a person",
            Self::Wearer => "a wearer",
            Self::Wire => "a wire",
            Self::Alloy => "an alloy",
            Self::Activation => "an activation",
            Self::Textures => "a table of textures",
            Self::Quarantine => "a quarantine",
            Self::Protocol => "a protocol",
        }
    }

    pub(super) fn built_in(self, name: &str) -> Option<&'static str> {
        match self {
            Self::Scene => palpate_fixtures::scene(name),
            Self::Layout => palpate_fixtures::layout(name),
            Self::Bench => palpate_fixtures::bench(name),
            Self::Limits => palpate_fixtures::limits(name),
            Self::Person => palpate_fixtures::person(name),
            Self::Wearer => palpate_fixtures::wearer(name),
            Self::Wire => palpate_fixtures::wire(name),
            Self::Alloy => palpate_fixtures::alloy(name),
            Self::Activation => palpate_fixtures::activation(name),
            Self::Textures => palpate_fixtures::textures(name),
            Self::Quarantine => None,
            Self::Protocol => palpate_fixtures::protocol(name),
        }
    }

    /// The built-in names, in alphabetical order.
    #[must_use]
    pub fn names(self) -> Vec<&'static str> {
        match self {
            Self::Scene => palpate_fixtures::scene_names().collect(),
            Self::Layout => palpate_fixtures::layout_names().collect(),
            Self::Bench => palpate_fixtures::bench_names().collect(),
            Self::Limits => palpate_fixtures::limits_names().collect(),
            Self::Person => palpate_fixtures::person_names().collect(),
            Self::Wearer => palpate_fixtures::wearer_names().collect(),
            Self::Wire => palpate_fixtures::wire_names().collect(),
            Self::Alloy => palpate_fixtures::alloy_names().collect(),
            Self::Activation => palpate_fixtures::activation_names().collect(),
            Self::Textures => palpate_fixtures::textures_names().collect(),
            Self::Quarantine => Vec::new(),
            Self::Protocol => palpate_fixtures::protocol_names().collect(),
        }
    }

    /// The name or file that was meant, as a question.
    fn meant(self, name: &str, folder: Option<&Path>) -> String {
        let folder = folder.unwrap_or_else(|| Path::new("."));
        let files: Vec<String> = std::fs::read_dir(folder)
            .into_iter()
            .flatten()
            .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
            .filter(|file| file.ends_with(".toml"))
            .collect();
        let there = files.iter().map(String::as_str);
        did_you_mean(name, self.names().into_iter().chain(there))
    }

    fn choices(self) -> String {
        format!("{} ({}) or a file", self.noun(), self.names().join(", "))
    }
}

/// A built-in name if there is one, else a file.
///
/// # Errors
/// An unknown name lists what exists; a file says why it cannot be read.
pub fn resolve(kind: FileKind, name: &str) -> Result<Source, FileError> {
    look_up(kind, name, None)?.ok_or_else(|| {
        FileError::whole(
            if name.is_empty() { "\"\"" } else { name },
            kind.choices(),
            format!("neither of that name{}", kind.meant(name, None)),
        )
    })
}

/// The same for a name that stands under `key` of another file: relative paths start at that file's folder.
///
/// # Errors
/// As [`resolve`]; an unknown name is reported at its line in `referrer`.
pub fn resolve_from(
    kind: FileKind,
    name: &str,
    referrer: &Source,
    key: &str,
) -> Result<Source, FileError> {
    let folder = referrer.folder_of(key);
    look_up(kind, name, folder)?.ok_or_else(|| {
        let meant = kind.meant(name, folder);
        referrer.bad_found(key, kind.choices(), format!("\"{name}\"{meant}"))
    })
}

fn look_up(kind: FileKind, name: &str, folder: Option<&Path>) -> Result<Option<Source>, FileError> {
    if let Some(text) = kind.built_in(name) {
        let label = format!("fixtures/{}/{name}.toml", kind.folder());
        return Ok(Some(Source::new(label, text)));
    }
    let path = folder.map_or_else(|| PathBuf::from(name), |folder| folder.join(name));
    if name.is_empty() || !path.exists() {
        return Ok(None);
    }
    Source::open(&path).map(Some)
}
