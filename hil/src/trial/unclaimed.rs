//! Goldens that hold nothing: of a scene that has another name now, or of a bench that nothing is tried on. A golden that is
//! silent looks like one that agrees.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use palpate_files::{did_you_mean, entries, headed, read_text};
use palpate_records::verdict::{Conclusion, Verdict};
use palpate_run::Failure;

use super::golden::{Goldens, LARGEST, SOURCE, parts};
use super::{Suite, Trial, TrialEnd};

/// The goldens in the folders of a suite that no scene on one of these benches claims, as failed trials. Where the
/// command line leaves scenes or benches out, these are only goldens of scenes that are gone.
///
/// # Errors
/// A folder that cannot be read.
pub fn unclaimed(suite: &Suite, benches: &[&str], all_tried: bool) -> Result<Vec<Trial>, Failure> {
    let of = |scene: &Path, bench: &str| {
        let goldens = Goldens::new(scene, bench);
        (goldens.folder().to_path_buf(), goldens.stem().to_owned())
    };
    let claims: BTreeSet<(PathBuf, String)> = suite
        .scenes
        .iter()
        .flat_map(|scene| benches.iter().map(move |bench| of(scene, bench)))
        .collect();
    let mut found = Vec::new();
    for folder in &suite.goldens {
        let mut by_stem: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
        for path in entries(folder)? {
            let Some((stem, _)) = parts(&path) else {
                continue;
            };
            let claimed = claims.contains(&(folder.clone(), stem.to_owned()));
            if !claimed && is_ours(&path) {
                by_stem.entry(stem.to_owned()).or_default().push(path);
            }
        }
        let scenes = || {
            let here = suite.scenes.iter();
            let here = here.filter(|s| s.parent() == folder.parent());
            here.filter_map(|s| s.file_stem()?.to_str())
        };
        for (stem, paths) in by_stem {
            let (scene, bench) = stem.split_once('@').unwrap_or((&stem, ""));
            let gone = !scenes().any(|name| name == scene);
            if !gone && !all_tried {
                continue;
            }
            let why = match (gone, bench) {
                (true, _) => format!(
                    "no scene `{scene}.toml` is here{}; give the golden the scene's name, or remove it",
                    did_you_mean(scene, scenes())
                ),
                (false, "") => format!(
                    "it is of the bench that ships, and trials run on {}; `hil test .. --bench emulated` holds it, else remove it",
                    benches.join(", ")
                ),
                (false, bench) => format!(
                    "trials run on {}, not on `{bench}`; add that bench, or remove the golden",
                    benches.join(", ")
                ),
            };
            found.push(failed(&stem, &paths, &why));
        }
    }
    Ok(found)
}

/// Tells whether `hil test` wrote a golden; `true` also for one that cannot be read.
fn is_ours(path: &Path) -> bool {
    let text = read_text(path, "a golden", LARGEST);
    text.map_or(true, |text| {
        let (head, _) = headed(&text);
        head.is_some_and(|head| head.lines().any(|line| line == SOURCE))
    })
}

fn failed(stem: &str, paths: &[PathBuf], why: &str) -> Trial {
    let mut wrong = Conclusion::default();
    let names: Vec<String> = paths.iter().map(|p| p.display().to_string()).collect();
    let text = format!("{}: no trial claims it: {why}", names.join(", "));
    wrong.add(Verdict::Failed, text);
    Trial::untried(stem, TrialEnd::Failed(wrong))
}
