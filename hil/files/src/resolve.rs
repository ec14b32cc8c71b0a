//! A name or a path, as the user typed it, to a text.

use std::path::{Path, PathBuf};

use super::error::FileError;
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
    Perceiver,
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
}

impl FileKind {
    fn folder(self) -> &'static str {
        match self {
            Self::Scene => "scenes",
            Self::Layout => "layouts",
            Self::Bench => "benches",
            Self::Limits => "limits",
            Self::Perceiver => "perceivers",
            Self::Wearer => "wearers",
            Self::Wire => "wires",
            Self::Alloy => "alloys",
            Self::Activation => "activations",
            Self::Textures => "textures",
        }
    }

    fn noun(self) -> &'static str {
        match self {
            Self::Scene => "a scene",
            Self::Layout => "a layout",
            Self::Bench => "a bench",
            Self::Limits => "a limit table",
            Self::Perceiver => "a perceiver",
            Self::Wearer => "a wearer",
            Self::Wire => "a wire",
            Self::Alloy => "an alloy",
            Self::Activation => "an activation",
            Self::Textures => "a table of textures",
        }
    }

    fn built_in(self, name: &str) -> Option<&'static str> {
        match self {
            Self::Scene => palpate_fixtures::scene(name),
            Self::Layout => palpate_fixtures::layout(name),
            Self::Bench => palpate_fixtures::bench(name),
            Self::Limits => palpate_fixtures::limits(name),
            Self::Perceiver => palpate_fixtures::perceiver(name),
            Self::Wearer => palpate_fixtures::wearer(name),
            Self::Wire => palpate_fixtures::wire(name),
            Self::Alloy => palpate_fixtures::alloy(name),
            Self::Activation => palpate_fixtures::activation(name),
            Self::Textures => palpate_fixtures::textures(name),
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
            Self::Perceiver => palpate_fixtures::perceiver_names().collect(),
            Self::Wearer => palpate_fixtures::wearer_names().collect(),
            Self::Wire => palpate_fixtures::wire_names().collect(),
            Self::Alloy => palpate_fixtures::alloy_names().collect(),
            Self::Activation => palpate_fixtures::activation_names().collect(),
            Self::Textures => palpate_fixtures::textures_names().collect(),
        }
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
            "neither of that name",
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
    look_up(kind, name, referrer.folder_of(key))?.ok_or_else(|| referrer.bad(key, kind.choices()))
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
