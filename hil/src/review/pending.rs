//! Snapshots that insta left behind because they changed (`NAME.snap.new` beside `NAME.snap`), and what becomes of
//! them. Anybody's `cargo insta` sees and decides the same files.

use std::fs;
use std::path::{Path, PathBuf};

use palpate_files::{entries, headed, read_text};
use palpate_live::output::write_text;
use palpate_run::Failure;

use crate::trial::GOLDENS;

/// Folders of goldens, from the root of a project.
const FOLDERS: [&str; 2] = ["fixtures/goldens", GOLDENS];
/// Ending that insta gives the name of a snapshot that waits.
const WAITS: &str = ".snap.new";

/// A snapshot that waits for a decision.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pending {
    /// Name of the snapshot without an ending: `sphere-along.schedule`.
    pub name: String,
    /// The file that waits.
    pub path: PathBuf,
    /// The text that was accepted before, if there was one.
    pub old: Option<String>,
    /// The text that waits.
    pub new: String,
}

/// The folder of goldens: here or above.
///
/// # Errors
/// [`Failure::Input`] where there is none.
pub fn folder(named: Option<&Path>) -> Result<PathBuf, Failure> {
    if let Some(named) = named {
        let inside = named.join(GOLDENS);
        if inside.is_dir() {
            return Ok(inside);
        }
        if named.is_dir() {
            return Ok(named.to_path_buf());
        }
        return Err(Failure::Input(format!(
            "--goldens {}: expected a folder",
            named.display()
        )));
    }
    let here = std::env::current_dir().unwrap_or_default();
    let found = here
        .ancestors()
        .flat_map(|a| FOLDERS.map(|f| a.join(f)))
        .find(|f| f.is_dir());
    found.ok_or_else(|| {
        Failure::Input(format!(
            "expected {} here or above {}; name another folder with --goldens",
            FOLDERS.join(" or "),
            here.display()
        ))
    })
}

/// Everything that waits in a folder, by name.
///
/// # Errors
/// A folder or file that cannot be read.
pub fn pending(folder: &Path) -> Result<Vec<Pending>, Failure> {
    let mut found = Vec::new();
    for path in entries(folder)? {
        let file = path.file_name().map(|n| n.to_string_lossy().into_owned());
        let Some(name) = file.as_deref().and_then(|f| f.strip_suffix(WAITS)) else {
            continue;
        };
        let before = accepted(&path);
        found.push(Pending {
            name: name.to_owned(),
            new: read(&path)?,
            old: if before.exists() {
                Some(read(&before)?)
            } else {
                None
            },
            path,
        });
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(found)
}

fn accepted(path: &Path) -> PathBuf {
    path.with_extension("")
}

/// Most bytes of a golden.
const MOST: u64 = 8 << 20;

fn read(path: &Path) -> Result<String, Failure> {
    Ok(read_text(path, "a readable golden", MOST)?)
}

impl Pending {
    /// The scene, or other subject, of the snapshot: its name up to the first dot.
    pub fn subject(&self) -> &str {
        self.name.split('.').next().unwrap_or(&self.name)
    }

    /// Accepts the text that waits, with a reason if there is one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn accept(&self, why: Option<&str>) -> Result<(), Failure> {
        write_text(&accepted(&self.path), &settled(&self.new, why))?;
        self.reject()
    }

    /// Rejects the golden that waits; the accepted one stays.
    ///
    /// # Errors
    /// A file that cannot be removed.
    pub fn reject(&self) -> Result<(), Failure> {
        fs::remove_file(&self.path).map_err(Failure::written(&self.path))
    }
}

/// A snapshot as insta would keep it: without the line of the assertion; with the reason as its description, which
/// `cargo insta review` shows too.
fn settled(text: &str, why: Option<&str>) -> String {
    let (Some(head), body) = headed(text) else {
        return text.to_owned();
    };
    let mut lines: Vec<String> = head
        .lines()
        .filter(|l| !l.starts_with("assertion_line:"))
        .filter(|l| why.is_none() || !l.starts_with("description:"))
        .map(str::to_owned)
        .collect();
    if let Some(why) = why {
        // A JSON string is a YAML string.
        let quoted = serde_json::Value::from(why.trim()).to_string();
        lines.push(format!("description: {quoted}"));
    }
    format!("---\n{}\n---\n{body}", lines.join("\n"))
}

#[cfg(test)]
#[path = "pending_tests.rs"]
mod tests;
