//! Goldens of scenes that lie in files: beside the scene, in a folder `goldens`. What differs waits there for
//! `hil review`, as it does after `cargo test`.

use std::fs;
use std::path::{Path, PathBuf};

use palpate_files::read_text;
use palpate_records::diff::{Tolerance, compare};
use palpate_records::story::Story;
use palpate_records::trace::Trace;
use palpate_records::verdict::{Conclusion, Verdict};
use palpate_run::{Failure, damaged};

use palpate_live::output::{make_folder, write_file};

/// Largest golden, bytes: hundreds of times what one has.
const LARGEST: u64 = 32 << 20;
/// Differences told of one golden.
const TOLD: usize = 3;

/// The goldens of one scene on one bench.
#[derive(Clone, Debug)]
pub struct Goldens {
    folder: PathBuf,
    stem: String,
}

/// A golden of a kind: its file, and what the run would have in it.
struct Kept {
    path: PathBuf,
    story: Story,
}

impl Goldens {
    /// Those of a scene file on a bench. The emulated bench that ships needs no name in them.
    pub fn of(scene: &Path, bench: &str) -> Self {
        let stem = scene.file_stem().unwrap_or_default().to_string_lossy();
        let plain = |c: char| if c.is_alphanumeric() { c } else { '-' };
        Self {
            folder: scene.with_file_name("goldens"),
            stem: match bench {
                "emulated" => stem.into_owned(),
                other => format!("{stem}@{}", other.chars().map(plain).collect::<String>()),
            },
        }
    }

    /// Whether any is kept.
    pub fn exist(&self) -> bool {
        let kept = |kind| {
            self.folder
                .join(format!("{}.{kind}.snap", self.stem))
                .is_file()
        };
        ["schedule", "contacts"].into_iter().any(kept)
    }

    fn kept(&self, trace: &Trace) -> [Kept; 2] {
        let of = |kind: &str, story| Kept {
            path: self.folder.join(format!("{}.{kind}.snap", self.stem)),
            story,
        };
        [
            of("schedule", Story::schedule(trace)),
            of("contacts", Story::contacts(trace)),
        ]
    }

    /// Takes what a run did for good; what waits for a decision is decided by it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn accept(&self, trace: &Trace) -> Result<(), Failure> {
        make_folder(&self.folder)?;
        for kept in self.kept(trace) {
            kept.write(&kept.path)?;
            let _ = fs::remove_file(kept.waiting()); // there may be none
        }
        Ok(())
    }

    /// Holds a run against the goldens that there are. A difference that means something is a failure, and the new
    /// text waits beside the old one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn check(&self, trace: &Trace, wrong: &mut Conclusion) -> Result<(), Failure> {
        for kept in self.kept(trace) {
            if !kept.path.exists() {
                continue; // none is kept of this kind
            }
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
        Ok(())
    }
}

impl Kept {
    /// Where a changed golden waits.
    fn waiting(&self) -> PathBuf {
        self.path.with_extension("snap.new")
    }

    fn write(&self, path: &Path) -> Result<(), Failure> {
        let text = format!(
            "---\nsource: hil test\n---\n{}\n",
            self.story.text().trim_end()
        );
        write_file(path, |out| out.write_all(text.as_bytes()))
    }
}
