//! Settings files of earlier versions: keys that are gone become comments, and all other lines stay as they were
//! written.

use super::check::kind_of;
use super::error::FileError;
use super::resolve::FileKind;
use super::source::Source;
use super::wire::WireState;

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
        values: &[],
        why: "the laws `cosine` and `plays` went; every wire follows generalised play",
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

/// Makes of a file of an earlier version one of this version; `None` where nothing of it changed. `sag_state` goes into a
/// wire that has none.
///
/// # Errors
/// A wire without `sag_state` where none is given, or with more transformations than the model has now.
pub fn migrated(
    source: &Source,
    sag_state: Option<WireState>,
) -> Result<Option<Migrated>, FileError> {
    let Ok(kind) = kind_of(source) else {
        return Ok(None);
    };
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
    if kind == FileKind::Wire {
        r_phase(source, &mut found)?;
        state_of_sag(source, sag_state, &mut found)?;
    }
    Ok((!found.changes.is_empty()).then_some(found))
}

/// Makes the R phase of a wire's only play.
fn r_phase(source: &Source, found: &mut Migrated) -> Result<(), FileError> {
    if !source.states("plays") {
        return Ok(());
    }
    let headers = found.text.matches("[[plays]]").count();
    if headers != 1 {
        let expected = "one [[plays]], the R phase: no other transforms beside the martensite now";
        return Err(source.bad_found("plays", expected, format!("{headers} of them")));
    }
    let line = source.line_of("plays");
    found.text = found.text.replace("[[plays]]", "[r_phase]");
    found.changes.push(format!(
        "{}:{line}: `plays` is `r_phase`: phases exclude one another",
        source.label()
    ));
    Ok(())
}

/// Writes the state in which the sag was measured before the first table.
fn state_of_sag(
    source: &Source,
    state: Option<WireState>,
    found: &mut Migrated,
) -> Result<(), FileError> {
    if source.states("sag_state") {
        return Ok(());
    }
    let Some(state) = state else {
        let expected = "--sag-state cold or passed: in which of them the bench's sag was measured, no file of an earlier version says";
        return Err(source.bad_found("sag_state", expected, "neither"));
    };
    let mut before = 0;
    for line in found.text.split_inclusive('\n') {
        if line.trim_start().starts_with('[') {
            break;
        }
        before += line.len();
    }
    let row = format!("sag_state = \"{}\"\n\n", state.word());
    found.text.insert_str(before, &row);
    found.changes.push(format!(
        "{}: `sag_state` is {}, in which the bench's sag was measured; the wire begins `cold`",
        source.label(),
        state.word()
    ));
    Ok(())
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
