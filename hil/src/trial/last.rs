//! Memory of the trials that failed when a folder was last tried: `.palpate/last-failed` in it, scene and bench a line.

use std::fs;
use std::path::{Path, PathBuf};

use palpate_files::{FileError, said};
use palpate_run::Failure;

use super::{Trial, TrialEnd};
use palpate_live::output::{make_folder, write_text};

fn file(folder: &Path) -> PathBuf {
    folder.join(".palpate").join("last-failed")
}

/// Remembers what failed.
///
/// # Errors
/// A folder that cannot be written to.
pub fn remember(folder: &Path, suites: &[(String, Vec<Trial>)]) -> Result<(), Failure> {
    let mut lines = String::new();
    for (bench, trials) in suites {
        let failed = trials
            .iter()
            .filter(|t| matches!(t.end, TrialEnd::Failed(_) | TrialEnd::Broken(_)));
        failed.for_each(|t| lines += &format!("{}\t{bench}\n", t.scene));
    }
    let file = file(folder);
    file.parent().map_or(Ok(()), make_folder)?;
    write_text(&file, &lines)
}

/// Scene and bench of what failed.
///
/// # Errors
/// A folder that was never tried.
pub fn failed(folder: &Path) -> Result<Vec<(String, String)>, Failure> {
    let file = file(folder);
    let text = fs::read_to_string(&file).map_err(|e| {
        let label = file.display().to_string();
        let expected = "what failed last; try the folder without --last-failed first";
        FileError::whole(label, expected, said(&e))
    })?;
    let lines = text.lines().filter_map(|line| line.split_once('\t'));
    Ok(lines
        .map(|(scene, bench)| (scene.to_owned(), bench.to_owned()))
        .collect())
}
