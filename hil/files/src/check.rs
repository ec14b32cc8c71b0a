//! A file checked to its end: every error at once.
//!
//! Reading stops at the first error. The check then leaves out the value at that key, or puts a fitting one in its
//! place, and reads the file again, until no error is left. There is one reader and one wording for both.

use std::path::Path;

use serde_json::Value;

use super::activation::ActivationFile;
use super::band::BandFile;
use super::bench::Bench;
use super::change::Change;
use super::error::FileError;
use super::evidence::EvidenceFile;
use super::layout::LayoutFile;
use super::limits::LimitTable;
use super::loaded::Loaded;
use super::near::{nearest, quoted_words};
use super::person::{PersonFile, Wearer};
use super::placeholder;
use super::priors::PriorsFile;
use super::protocol::Protocol;
use super::quarantine::Quarantine;
use super::recipe::Recipe;
use super::resolve::FileKind;
use super::scene::Scene;
use super::setup;
use super::source::Source;
use super::texture::TextureTable;
use super::wire::{AlloyFile, WireFile};

/// Errors after which a file is given up: its author has enough to do. It also bounds the values that are put in
/// place of others, because two keys that contradict each other would be mended in turn for ever.
const MOST: usize = 100;
/// Author of a value that replaces a wrong one. No file has such a name.
const MENDED: &str = "\0mended";

/// Result of checking one file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Checked {
    /// Kind of the file; none where nothing tells.
    pub kind: Option<FileKind>,
    /// Errors, in the order of the lines.
    pub errors: Vec<FileError>,
    /// True if all of the file was looked at. An error that hides what comes after it makes this false.
    pub complete: bool,
}

/// Checks a file of any kind; its content tells the kind.
#[must_use]
pub fn check(path: &Path) -> Checked {
    match Source::open(path) {
        Ok(source) => check_source(source),
        Err(error) => Checked {
            kind: None,
            errors: vec![error],
            complete: false,
        },
    }
}

/// Checks a text.
#[must_use]
pub fn check_source(source: Source) -> Checked {
    let kind = kind_of(&source);
    let mut syntax = source.syntax_errors();
    // Later errors of a line only follow from its first.
    syntax.sort_by_key(|error| error.line);
    syntax.dedup_by_key(|error| error.line);
    if !syntax.is_empty() {
        return Checked {
            kind: kind.ok(),
            errors: syntax,
            complete: false,
        };
    }
    match kind {
        Ok(kind) => {
            let mut file = Mended {
                schema: placeholder::schema(kind).unwrap_or_default(),
                changes: Vec::new(),
                errors: Vec::new(),
                complete: true,
                source,
            };
            file.check(kind);
            // By line; errors of one line stay in the order in which they were found.
            file.errors.sort_by_key(|error| error.line);
            Checked {
                kind: Some(kind),
                errors: file.errors,
                complete: file.complete,
            }
        }
        Err(error) => Checked {
            kind: None,
            errors: vec![error],
            complete: false,
        },
    }
}

/// Tells the kind of a file: the one that its `#:schema` line states, else the one that knows most of its keys.
///
/// # Errors
/// A file that no kind, or more than one, knows best.
pub fn kind_of(source: &Source) -> Result<FileKind, FileError> {
    let stated = source
        .text()
        .lines()
        .find_map(|l| l.strip_prefix("#:schema"));
    let stated = stated.and_then(|path| Path::new(path.trim()).file_stem()?.to_str());
    if let Some(kind) = FileKind::ALL
        .into_iter()
        .find(|kind| Some(kind.name()) == stated)
    {
        return Ok(kind);
    }
    if matches!(source.peek("kind"), Ok(Some(kind)) if kind == FileKind::Recording.name()) {
        return Ok(FileKind::Recording);
    }
    let keys = source.top_keys();
    let told = |key: &&String| !["name", "description", "assumed"].contains(&key.as_str());
    let known = |kind: FileKind| {
        let schema = placeholder::schema(kind).unwrap_or_default();
        let names = placeholder::top_keys(&schema);
        // A mistyped key still tells something: half as much as the key itself.
        let weight = |key: &String| match nearest(key, names.iter().copied()) {
            Some(name) if name == key => 2,
            Some(_) => 1,
            None => 0,
        };
        keys.iter().filter(told).map(weight).sum::<usize>()
    };
    let scores = FileKind::ALL.map(|kind| match kind {
        // It states its kind, and shares its other keys with layouts.
        FileKind::Recording => (0, kind),
        _ => (known(kind), kind),
    });
    // A file that states nothing but its name may lie in a folder that says what is in it.
    let folder = source.folder().and_then(|f| f.file_name()?.to_str());
    let shelf = FileKind::ALL
        .into_iter()
        .find(|kind| Some(kind.folder()) == folder);
    let best = scores.iter().map(|(score, _)| *score).max().unwrap_or(0);
    let mut first = scores.iter().filter(|(score, _)| *score == best);
    match (first.next(), first.next(), shelf) {
        (Some((_, kind)), None, _) if best > 0 => Ok(*kind),
        (_, _, Some(kind)) if best == 0 => Ok(kind),
        _ => {
            let expected = "keys of a scene, a bench or another settings file, or a first line such as \
                            `#:schema scene.json` that says which";
            let found = match keys.as_slice() {
                [] => "none".to_owned(),
                keys => format!("the keys {}", keys.join(", ")),
            };
            Err(FileError::whole(source.label(), expected, found))
        }
    }
}

/// A file with values in place of its wrong ones.
struct Mended {
    source: Source,
    schema: Value,
    changes: Vec<Change>,
    errors: Vec<FileError>,
    complete: bool,
}

impl Mended {
    fn check(&mut self, kind: FileKind) {
        match kind {
            FileKind::Scene => self.scene(),
            FileKind::Bench => self.bench(),
            FileKind::Layout => self.read(|s| LayoutFile::read(s).map(drop)),
            FileKind::Limits => self.read(|s| LimitTable::read(s).map(drop)),
            FileKind::Person => self.read(|s| PersonFile::read(s).map(drop)),
            FileKind::Wearer => self.read(|s| Wearer::read(s).map(drop)),
            FileKind::Wire => self.read(|s| WireFile::read(s).map(drop)),
            FileKind::Alloy => self.read(|s| AlloyFile::read(s).map(drop)),
            FileKind::Activation => self.read(|s| ActivationFile::read(s).map(drop)),
            FileKind::Textures => self.read(|s| TextureTable::read(s).map(drop)),
            FileKind::Protocol => self.read(|s| Protocol::read(s).map(drop)),
            FileKind::Priors => self.read(|s| PriorsFile::read(s).map(drop)),
            FileKind::Evidence => self.read(|s| EvidenceFile::read(s).map(drop)),
            FileKind::Band => self.read(|s| BandFile::read(s).map(drop)),
            FileKind::Recording => self.recipe(),
            FileKind::Quarantine => self.read(|s| Quarantine::alone(s).map(drop)),
        }
    }

    fn scene(&mut self) {
        let of = |s: &Source| Loaded::<Scene>::read(s.clone());
        self.read(|s| of(s).map(drop));
        self.read(|s| setup::sensor_of(&of(s)?).map(drop));
        self.read(|s| {
            let scene = of(s)?;
            // A layout that cannot be read has its own error.
            let modules = setup::sensor_of(&scene).map_or(usize::MAX, |l| l.value.modules.len());
            setup::texture_of(&scene, modules).map(drop)
        });
        self.read(|s| setup::people_of(&of(s)?).map(drop));
    }

    fn recipe(&mut self) {
        self.read(|s| Recipe::read(s).map(drop));
        self.read(|s| setup::plan_of(&Loaded::read(s.clone())?).map(drop));
    }

    fn bench(&mut self) {
        let of = |s: &Source| Loaded::<Bench>::read(s.clone());
        self.read(|s| of(s).map(drop));
        self.read(|s| setup::limits_of(&of(s)?).map(drop));
        self.read(|s| setup::wire_of(&of(s)?).map(drop));
        self.read(|s| setup::alloy_of(&of(s)?).map(drop));
        self.read(|s| setup::mounted_of(&of(s)?).map(drop));
        self.read(|s| setup::band_of(&of(s)?).map(drop));
        self.read(|s| {
            let bench = of(s)?;
            let display = setup::display_of(&bench)?;
            setup::check_outputs(&bench, &display.value)
        });
    }

    /// Reads until no error is left, or until one cannot be mended.
    fn read(&mut self, read: impl Fn(&Source) -> Result<(), FileError>) {
        while let Err(error) = read(&self.source.with(self.changes.clone())) {
            let own = error.path == self.source.label();
            if error.path != MENDED && !self.errors.contains(&error) {
                self.errors.push(error.clone());
            }
            // Another file's errors are for its own check, and they hide those of this one.
            let mended = own || error.path == MENDED;
            let enough = self.errors.len() >= MOST || self.changes.len() >= MOST;
            if !mended || enough || !self.mend(&error, &read) {
                self.complete = false;
                return;
            }
        }
    }

    /// Puts another value at the key of an error, so that reading goes on beyond it.
    fn mend(
        &mut self,
        error: &FileError,
        read: &impl Fn(&Source) -> Result<(), FileError>,
    ) -> bool {
        let Some(key) = &error.key else { return false };
        if let Some(renamed) = self.renamed(key, error) {
            self.source = renamed;
            return true;
        }
        for attempt in self.attempts(key, error) {
            let mut changes = self.changes.clone();
            changes.push(attempt);
            let better = match read(&self.source.with(changes.clone())) {
                Ok(()) => true,
                Err(next) => match &next.key {
                    Some(next) => !is_at(next, key),
                    None => next.path != self.source.label(),
                },
            };
            if better {
                self.changes = changes;
                return true;
            }
        }
        false
    }

    /// Returns the file with the mistyped key renamed: the key then is not missing as well, and its content is
    /// checked.
    fn renamed(&self, key: &str, error: &FileError) -> Option<Source> {
        if !error.found.starts_with("the unknown key") {
            return None;
        }
        let last = key.rsplit('.').next()?;
        let meant = nearest(last, quoted_words(&error.expected))?;
        self.source.renamed(key, meant)
    }

    /// Values that could stand at `key`: nothing, the word that was meant, or an example.
    fn attempts(&self, key: &str, error: &FileError) -> Vec<Change> {
        let change = |value: Option<String>| Change {
            by: MENDED.into(),
            key: key.into(),
            value,
        };
        let nothing = (!key.ends_with(']')).then_some(None);
        let found = error.found.split(';').next().unwrap_or_default();
        let found = found.trim_matches(['`', '"']);
        let word = nearest(found, quoted_words(&error.expected));
        let word = word.map(|word| format!("\"{word}\""));
        let examples = placeholder::placeholders(&self.schema, key);
        let values = word.into_iter().chain(examples).map(Some);
        nothing.into_iter().chain(values).map(change).collect()
    }
}

/// Returns true if a key is the other or lies in it.
fn is_at(key: &str, other: &str) -> bool {
    let rest = key.strip_prefix(other);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

#[cfg(test)]
#[path = "check_tests.rs"]
mod tests;
