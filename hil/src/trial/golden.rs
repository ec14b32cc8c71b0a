//! Goldens of scenes that lie in files: beside the scene, in a folder `goldens`. A golden that differs waits there for
//! `hil review`, as it does after `cargo test`.

use std::fs;
use std::path::{Path, PathBuf};

use palpate_files::{DEFAULT_BENCH, entries, headed, read_text};
use palpate_records::diff::{Tolerance, compare};
use palpate_records::story::Story;
use palpate_records::trace::Trace;
use palpate_records::verdict::{Conclusion, Verdict};
use palpate_run::{Failure, damaged};

use palpate_live::output::{make_folder, write_text};

/// Largest golden, bytes: hundreds of times what one has.
pub(super) const LARGEST: u64 = 32 << 20;
/// Name of a folder of goldens.
pub const FOLDER: &str = "goldens";
/// Differences told of one golden.
const TOLD: usize = 3;

/// Kinds of golden that a scene has.
pub(super) const KINDS: [&str; 2] = ["schedule", "contacts"];
/// The heading's line of a golden that `hil test` wrote: others are another program's business.
pub(super) const SOURCE: &str = "source: hil test";

/// The goldens of one scene on one bench.
#[derive(Clone, Debug)]
pub struct Goldens {
    folder: PathBuf,
    stem: String,
}

/// Goldens that held a trial, or should have.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Held {
    /// Kinds that the run was held against.
    pub kinds: Vec<&'static str>,
    /// Files that were accepted.
    pub wrote: Vec<PathBuf>,
    /// The folder where changed ones wait, if any does.
    pub waits: Option<PathBuf>,
}

/// A golden of a kind: its file, and what the run would have in it.
struct Kept {
    kind: &'static str,
    path: PathBuf,
    story: Story,
}

impl Goldens {
    /// Goldens of a scene file on a bench. The emulated bench that ships needs no name in them.
    pub fn new(scene: &Path, bench: &str) -> Self {
        let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
        let plain = |c: char| if c.is_alphanumeric() { c } else { '-' };
        Self {
            folder: scene.with_file_name(FOLDER),
            stem: match bench {
                DEFAULT_BENCH => stem.into_owned(),
                other => format!("{stem}@{}", other.chars().map(plain).collect::<String>()),
            },
        }
    }

    /// The folder that they lie in.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Prefix of the goldens' names: the scene's file, and the bench if it is not the one that ships.
    pub fn stem(&self) -> &str {
        &self.stem
    }

    fn path(&self, kind: &str) -> PathBuf {
        self.folder.join(format!("{}.{kind}.snap", self.stem))
    }

    /// The kinds that are kept.
    pub fn kinds(&self) -> Vec<&'static str> {
        let kept = |kind: &&str| self.path(kind).exists();
        KINDS.into_iter().filter(kept).collect()
    }

    /// Goldens of the same scene on other benches, of which none holds this trial.
    pub fn of_others(&self) -> Vec<String> {
        let scene = self.stem.split('@').next().unwrap_or(&self.stem);
        let stems = entries(&self.folder).unwrap_or_default();
        let stems = stems.iter().filter_map(|path| parts(path));
        let same = |stem: &&str| stem.split('@').next() == Some(scene) && **stem != self.stem;
        let mut others: Vec<String> = stems
            .map(|(stem, _)| stem)
            .filter(same)
            .map(str::to_owned)
            .collect();
        others.dedup();
        others
    }

    fn kept(&self, trace: &Trace) -> [Kept; 2] {
        let of = |kind, story| Kept {
            kind,
            path: self.path(kind),
            story,
        };
        let [schedule, contacts] = KINDS;
        [
            of(schedule, Story::schedule(trace)),
            of(contacts, Story::contacts(trace)),
        ]
    }

    /// Accepts the run as its goldens; a text that waits for a decision is decided by it. A golden that says the same
    /// already stays as it is.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn accept(&self, trace: &Trace) -> Result<Held, Failure> {
        make_folder(&self.folder)?;
        let mut held = Held::default();
        for kept in self.kept(trace) {
            let there = read_text(&kept.path, "a golden", LARGEST);
            if there.is_ok_and(|text| headed(&text).1.trim_end() == kept.text()) {
                held.kinds.push(kept.kind);
            } else {
                kept.write(&kept.path)?;
                held.wrote.push(kept.path.clone());
            }
            let _ = fs::remove_file(kept.waiting()); // there may be none
        }
        Ok(held)
    }

    /// Holds a run against the goldens that there are. A difference that means something is a failure, and the new
    /// text waits beside the old one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn check(&self, trace: &Trace, wrong: &mut Conclusion) -> Result<Held, Failure> {
        let mut held = Held::default();
        for kept in self.kept(trace) {
            if !kept.path.exists() {
                continue; // none is kept of this kind
            }
            held.kinds.push(kept.kind);
            let text = match read_text(&kept.path, "a golden", LARGEST) {
                Ok(text) => text,
                Err(error) => {
                    wrong.add(Verdict::Failed, error.to_string());
                    continue;
                }
            };
            let path = kept.path.display();
            let old = match Story::read(&text) {
                Ok(old) => old,
                Err(damage) => {
                    let error = damaged(path.to_string(), damage);
                    wrong.add(Verdict::Failed, error.to_string());
                    continue;
                }
            };
            let found = compare(&old, &kept.story, Tolerance::between(&old, &kept.story));
            let grave: Vec<&str> = found
                .iter()
                .filter(|d| d.meaning)
                .map(|d| d.text.as_str())
                .collect();
            if grave.is_empty() {
                let _ = fs::remove_file(kept.waiting()); // of an earlier run
                continue;
            }
            kept.write(&kept.waiting())?;
            held.waits = Some(self.folder.clone());
            let told = grave
                .iter()
                .take(TOLD)
                .copied()
                .collect::<Vec<_>>()
                .join("; ");
            let more = match grave.len().saturating_sub(TOLD) {
                0 => String::new(),
                n => format!("; and {n} more"),
            };
            wrong.add(Verdict::Failed, format!("{path}: {told}{more}"));
        }
        Ok(held)
    }
}

/// Parts of a golden's name, scene and bench, and its kind; none for a file that is no golden of a scene.
pub(super) fn parts(path: &Path) -> Option<(&str, &str)> {
    let name = path.file_name()?.to_str()?.strip_suffix(".snap")?;
    name.rsplit_once('.')
        .filter(|(_, kind)| KINDS.contains(kind))
}

impl Kept {
    /// File of a changed golden that waits.
    fn waiting(&self) -> PathBuf {
        self.path.with_extension("snap.new")
    }

    fn text(&self) -> String {
        self.story.text().trim_end().to_owned()
    }

    fn write(&self, path: &Path) -> Result<(), Failure> {
        write_text(path, &format!("---\n{SOURCE}\n---\n{}\n", self.text()))
    }
}
