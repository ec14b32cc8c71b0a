//! Settings files of earlier versions: keys that are gone become comments, and all other lines stay as they were
//! written.

use super::check::kind_of;
use super::resolve::FileKind;
use super::source::Source;

/// A key that is gone.
struct Gone {
    kind: FileKind,
    key: &'static str,
    /// Values with which it is gone; empty: all.
    values: &'static [&'static str],
    why: &'static str,
}

const GONE: [Gone; 2] = [
    Gone {
        kind: FileKind::Scene,
        key: "illusion.smallest_step",
        values: &[],
        why: "every step is rendered: leaving small ones out made paths coarser and no wire cooler",
    },
    Gone {
        kind: FileKind::Wire,
        key: "hysteresis",
        values: &["cosine"],
        why: "the law `cosine` went; a wire without the key follows generalised play",
    },
];

/// A file as this version reads it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Migrated {
    /// The text.
    pub text: String,
    /// Changes made: line, key and reason.
    pub changes: Vec<String>,
}

/// Migrates a file of an earlier version; none where it has no such key.
#[must_use]
pub fn migrated(source: &Source) -> Option<Migrated> {
    let kind = kind_of(source).ok()?;
    let mut found = Migrated {
        text: source.text().to_owned(),
        changes: Vec::new(),
    };
    for gone in GONE.iter().filter(|gone| gone.kind == kind) {
        let now = Source::new(source.label(), &*found.text);
        let stands = |value: &&str| now.value_at(gone.key).is_some_and(|v| v.contains(*value));
        if !now.states(gone.key) || !(gone.values.is_empty() || gone.values.iter().any(stands)) {
            continue;
        }
        let (line, text) = without(&now, gone);
        found.text = text;
        let Gone { key, why, .. } = gone;
        found.changes.push(format!(
            "{}:{line}: `{key}` is left out: {why}",
            source.label()
        ));
    }
    (!found.changes.is_empty()).then_some(found)
}

/// The text without a key, and the key's line: a comment where it has lines of its own, cut out of an inline table.
fn without(source: &Source, gone: &Gone) -> (usize, String) {
    let (mut section, mut first, mut out) = (String::new(), 0, String::new());
    for (number, line) in source.text().split_inclusive('\n').enumerate() {
        let trimmed = line.trim_start();
        let bare = trimmed.split('#').next().unwrap_or_default().trim();
        let header = bare.strip_prefix('[').and_then(|l| l.strip_suffix(']'));
        if let Some(name) = header {
            section = name.trim_matches(['[', ']']).trim().to_owned();
        }
        let key = bare.split_once('=').map(|(key, _)| key.trim());
        let whole = match (header, key, section.as_str()) {
            (Some(_), ..) => section.clone(),
            (None, Some(key), "") => key.to_owned(),
            (None, Some(key), section) => format!("{section}.{key}"),
            (None, None, _) => String::new(),
        };
        let inside = whole.strip_prefix(gone.key);
        if inside.is_some_and(|rest| rest.is_empty() || rest.starts_with('.')) {
            if first == 0 {
                first = number + 1;
                out += &format!("# {}:\n", gone.why);
            }
            out += "# ";
        }
        out += line;
    }
    if first > 0 {
        return (first, out);
    }
    source.cut(gone.key).unwrap_or((1, out))
}

#[cfg(test)]
#[path = "migrate_tests.rs"]
mod tests;
