//! Contents of the shelf: built-in files, those of a folder and laws of illusion, each with a line that describes it.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::check::kind_of;
use super::placeholder;
use super::resolve::FileKind;
use super::source::Source;

/// A settings file or a law of illusion, as a list has it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Listed {
    /// The description that the file gives.
    pub description: String,
    /// The path of the file; none for a built-in one.
    pub file: Option<PathBuf>,
    /// The name of its [`FileKind`], or `illusion`.
    pub kind: &'static str,
    /// The word to type: a built-in name, or a path.
    pub name: String,
}

/// The built-in files of a kind, in alphabetical order.
#[must_use]
pub fn built_in(kind: FileKind) -> Vec<Listed> {
    let listed = |name: &'static str| Listed {
        kind: kind.name(),
        name: name.into(),
        description: kind.built_in(name).map_or_else(String::new, |text| {
            description(&Source::new(name, text)).unwrap_or_default()
        }),
        file: None,
    };
    kind.names().into_iter().map(listed).collect()
}

/// The settings files in a folder and up to `depth` folders below it, in alphabetical order. Other files, hidden
/// folders and links to folders are left out.
#[must_use]
pub fn of_folder(folder: &Path, depth: usize) -> Vec<Listed> {
    let mut found = Vec::new();
    search(folder, depth, &mut found);
    found.sort_unstable_by(|a: &Listed, b| a.name.cmp(&b.name));
    found
}

fn search(folder: &Path, depth: usize, found: &mut Vec<Listed>) {
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or(".");
        if depth > 0 && path.is_dir() {
            let skipped = name.starts_with('.') || ["target", "node_modules"].contains(&name);
            if !skipped && !path.is_symlink() {
                search(&path, depth - 1, found);
            }
        } else if name.ends_with(".toml") {
            found.extend(listed(&path));
        }
    }
}

fn listed(path: &Path) -> Option<Listed> {
    let source = Source::open(path).ok()?;
    // Files of this folder are named as people type them.
    let path = path.strip_prefix(".").unwrap_or(path);
    Some(Listed {
        kind: kind_of(&source).ok()?.name(),
        description: description(&source)?,
        name: path.to_str()?.to_owned(),
        file: Some(path.to_path_buf()),
    })
}

/// The laws of illusion.
#[must_use]
pub fn illusions() -> Vec<Listed> {
    let schema = placeholder::schema(FileKind::Scene).unwrap_or_default();
    let laws = schema["$defs"]["IllusionModel"]["oneOf"].as_array();
    let law = |law: &serde_json::Value| {
        let text = |key: &str| law[key].as_str().map(str::to_owned);
        Some(Listed {
            kind: "illusion",
            name: text("const")?,
            description: text("description")?.trim_end_matches('.').to_owned(),
            file: None,
        })
    };
    laws.into_iter().flatten().filter_map(law).collect()
}

fn description(source: &Source) -> Option<String> {
    source.peek("description").ok()?
}

#[cfg(test)]
#[path = "shelf_tests.rs"]
mod tests;
