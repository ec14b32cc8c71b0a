//! The files of a folder of recordings.

use std::io;
use std::path::{Path, PathBuf};

/// The files of a folder that have this ending, each after its name without it, in the order of their paths.
///
/// # Errors
/// A folder that cannot be read.
pub fn files(folder: &Path, ending: &str) -> io::Result<Vec<(String, PathBuf)>> {
    let mut paths: Vec<PathBuf> = std::fs::read_dir(folder)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == ending))
        .collect();
    paths.sort_unstable();
    let named = |path: PathBuf| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        (stem.into_owned(), path)
    };
    Ok(paths.into_iter().map(named).collect())
}
