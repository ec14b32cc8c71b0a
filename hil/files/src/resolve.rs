//! Resolution of a name or a path, as the user typed it, to a text.

use std::path::{Path, PathBuf};

use super::error::FileError;
use super::near::did_you_mean;
use super::source::Source;

macro_rules! kinds {
    (@) => { Default::default() };
    (@ $built_in:expr) => { $built_in };
    ($(
        $(#[$doc:meta])*
        $kind:ident = $name:literal $folder:literal $noun:literal $($text:ident $names:ident)?
    ),+ $(,)?) => {
        /// The kinds of settings file; each has its own shelf of built-in names.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum FileKind { $($(#[$doc])* $kind),+ }

        impl FileKind {
            /// Every kind.
            pub const ALL: [Self; 16] = [$(Self::$kind),+];

            /// The name of the kind, as the schema of such files has it.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$kind => $name),+ }
            }

            /// The name of the kind's shelf: the folder of the built-in files.
            #[must_use]
            pub const fn folder(self) -> &'static str {
                match self { $(Self::$kind => $folder),+ }
            }

            /// The kind with its article.
            #[must_use]
            pub const fn noun(self) -> &'static str {
                match self { $(Self::$kind => $noun),+ }
            }

            pub(super) fn built_in(self, name: &str) -> Option<&'static str> {
                match self { $(Self::$kind => kinds!(@ $(palpate_fixtures::$text(name))?)),+ }
            }

            /// The built-in names, in alphabetical order.
            #[must_use]
            pub fn names(self) -> Vec<&'static str> {
                match self { $(Self::$kind => kinds!(@ $(palpate_fixtures::$names().collect())?)),+ }
            }
        }
    };
}

kinds! {
    /// Touches of the skin, and their projection.
    Scene = "scene" "scenes" "a scene" scene scene_names,
    /// Hardware, emulated or real.
    Bench = "bench" "benches" "a bench" bench bench_names,
    /// Places of taxels or wires.
    Layout = "layout" "layouts" "a layout" layout layout_names,
    /// Limits that the guard enforces.
    Limits = "limits" "limits" "a limit table" limits limits_names,
    /// The emulated person.
    Person = "person" "persons" "a person" person person_names,
    /// A wearer's calibration.
    Wearer = "wearer" "wearers" "a wearer" wearer wearer_names,
    /// A shape-memory wire.
    Wire = "wire" "wires" "a wire" wire wire_names,
    /// The material of a wire.
    Alloy = "alloy" "alloys" "an alloy" alloy alloy_names,
    /// A map from roughness to pulses.
    Activation = "activation" "activations" "an activation" activation activation_names,
    /// A table of textures.
    Textures = "textures" "textures" "a table of textures" textures textures_names,
    /// Trials that are known to fail.
    Quarantine = "quarantine" "quarantines" "a quarantine",
    /// A study with people.
    Protocol = "protocol" "protocols" "a protocol" protocol protocol_names,
    /// Priors of what has not been measured.
    Priors = "priors" "priors" "priors" priors priors_names,
    /// Evidence about wires and people.
    Evidence = "evidence" "evidence" "evidence" evidence evidence_names,
    /// Level, share felt and error of a bench over all that is not measured.
    Band = "band" "bands" "a band" band band_names,
    /// A recipe for a recording.
    Recording = "recording" "recordings" "a recipe of a recording",
}

/// Most names that an error lists.
const MOST_NAMES: usize = 20;

impl FileKind {
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

    /// Names to choose from, or the command that lists them where they are many.
    fn choices(self) -> String {
        let names = self.names();
        let names = match names.len() > MOST_NAMES {
            true => format!("`hil list {}` has their names", self.folder()),
            false => names.join(", "),
        };
        format!("{} ({names}) or a file", self.noun())
    }
}

/// Resolves a built-in name if there is one, else a file.
///
/// # Errors
/// An unknown name lists what exists; a file says why it cannot be read.
pub fn resolve(kind: FileKind, name: &str) -> Result<Source, FileError> {
    look_up(kind, name, None)?.ok_or_else(|| {
        let meant = kind.meant(name, None);
        let (expected, found) = match is_path(name) {
            true => (format!("the file of {}", kind.noun()), "no such file"),
            false => (kind.choices(), "neither of that name"),
        };
        let name = if name.is_empty() { "\"\"" } else { name };
        FileError::whole(name, expected, format!("{found}{meant}"))
    })
}

/// Returns true if a name is meant as a path: it has a folder or the ending of settings files.
fn is_path(name: &str) -> bool {
    name.contains('/') || name.ends_with(".toml")
}

/// Resolves a name that stands under `key` of another file: relative paths start at that file's folder.
///
/// # Errors
/// The errors of [`resolve`]; an unknown name is reported at its line in `referrer`.
pub fn resolve_from(
    kind: FileKind,
    name: &str,
    referrer: &Source,
    key: &str,
) -> Result<Source, FileError> {
    let folder = referrer.folder_of(key);
    look_up(kind, name, folder)?.ok_or_else(|| {
        let meant = kind.meant(name, folder);
        let there = if is_path(name) {
            ", and no such file"
        } else {
            ""
        };
        referrer.bad_found(key, kind.choices(), format!("\"{name}\"{there}{meant}"))
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
