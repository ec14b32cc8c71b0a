//! Changes of a scene: its goldens that wait, each compared with the accepted one.

use std::collections::{BTreeMap, BTreeSet};

use palpate_files::headed;
use palpate_records::diff::{Difference, Grade, Tolerance, compare};
use palpate_records::story::{GoldenKind, Story};

use super::pending::Pending;
use palpate_run::{Failure, damaged};

/// One golden that waits.
#[derive(Clone, Debug)]
pub struct Change {
    /// The files.
    pub pending: Pending,
    /// Accepted golden; `None` for a new golden, or for a text that Palpate did not write.
    pub old: Option<Story>,
    /// Golden that waits; `None` for a text that Palpate did not write.
    pub new: Option<Story>,
    /// Differences of the two.
    pub differences: Vec<Difference>,
}

/// Goldens of one scene that wait.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name of the scene.
    pub name: String,
    /// Goldens of the scene that wait, the schedule first.
    pub changes: Vec<Change>,
}

/// Goldens that wait, by scene; the scene that lost most of a margin comes first.
///
/// # Errors
/// A golden of ours that cannot be read, with its line.
pub fn scenes(pending: Vec<Pending>) -> Result<Vec<Scene>, Failure> {
    let mut by_name: BTreeMap<String, Vec<Change>> = BTreeMap::new();
    for one in pending {
        let name = one.subject().to_owned();
        by_name.entry(name).or_default().push(change(one)?);
    }
    let mut all: Vec<Scene> = by_name
        .into_iter()
        .map(|(name, mut changes)| {
            changes.sort_by_key(|c| c.new.as_ref().map(|s| s.kind));
            Scene { name, changes }
        })
        .collect();
    // What differs most comes before what differs least, where no margin tells.
    all.sort_by_cached_key(|s| {
        let weight = std::cmp::Reverse((s.lost(), s.words().len()));
        (weight, s.name.clone())
    });
    Ok(all)
}

fn change(pending: Pending) -> Result<Change, Failure> {
    let read = |text: &str, path: String| -> Result<Option<Story>, Failure> {
        if !headed(text).1.starts_with("palpate ") {
            return Ok(None);
        }
        let story = Story::read(text).map_err(|damage| damaged(path, damage))?;
        Ok(Some(story))
    };
    let path = pending.path.display().to_string();
    let new = read(&pending.new, path)?;
    let old = match &pending.old {
        Some(text) => {
            let path = pending.path.with_extension("");
            read(text, path.display().to_string())?
        }
        None => None,
    };
    let differences = match (&old, &new) {
        (Some(a), Some(b)) if a.kind == b.kind => compare(a, b, Tolerance::between(a, b)),
        _ => Vec::new(),
    };
    Ok(Change {
        pending,
        old,
        new,
        differences,
    })
}

impl Change {
    /// Word for the golden's kind.
    pub fn what(&self) -> &'static str {
        self.new.as_ref().map_or("another text", |s| s.kind.title())
    }

    /// Remark on goldens that cannot be compared.
    fn remark(&self) -> Option<String> {
        let name = &self.pending.name;
        match (&self.pending.old, &self.old, &self.new) {
            (None, _, _) => Some(format!("{name} is new")),
            (Some(_), Some(a), Some(b)) if a.kind == b.kind => None,
            (Some(old), _, _) => {
                let ((_, old), (_, new)) = (headed(old), headed(&self.pending.new));
                let lines = old.lines().zip(new.lines()).filter(|(a, b)| a != b).count();
                let more = old.lines().count().abs_diff(new.lines().count());
                Some(format!("{name}: {} lines differ", lines + more))
            }
        }
    }
}

impl Scene {
    /// The largest share of a limit that was left and is no more, thousandths of a percent.
    pub fn lost(&self) -> i64 {
        let all = self.changes.iter().flat_map(|c| &c.differences);
        let margins = all.filter(|d| d.grade == Grade::Margin);
        margins.map(|d| d.weight).max().unwrap_or(0)
    }

    /// Differences in words, margins that shrank first, each told once.
    pub fn words(&self) -> Vec<Difference> {
        let mut seen = BTreeSet::new();
        let mut all: Vec<Difference> = Vec::new();
        for change in &self.changes {
            for d in &change.differences {
                if seen.insert(d.text.clone()) {
                    all.push(d.clone());
                }
            }
        }
        all.sort_by_key(|d| (d.grade != Grade::Margin, d.grade, -d.weight));
        let remarks = self.changes.iter().filter_map(Change::remark);
        all.extend(remarks.map(|text| Difference {
            grade: Grade::Moment,
            meaning: true,
            weight: 0,
            text,
        }));
        all
    }

    /// The golden of a kind that waits, with what it replaces.
    pub fn golden(&self, kind: GoldenKind) -> Option<(&Story, &Story)> {
        self.changes.iter().find_map(|change| {
            let (old, new) = (change.old.as_ref()?, change.new.as_ref()?);
            (old.kind == kind && new.kind == kind).then_some((old, new))
        })
    }
}
