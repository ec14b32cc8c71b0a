//! The parser's sentences turned into ours: which key, what was expected, what was found.

use super::near::{did_you_mean, quoted_words};

/// What a parser's message says, taken apart.
pub(super) struct Wrong {
    pub key: String,
    pub expected: String,
    /// None: the value in the file speaks for itself.
    pub found: Option<String>,
}

/// Takes a `serde` message at `path` apart. Messages of unknown form are passed on whole.
pub(super) fn expectation(path: &str, message: &str) -> Wrong {
    let first = message.lines().next().unwrap_or_default();
    if let Some((field, rest)) = quoted(first, "unknown field ") {
        let known = rest.trim_start_matches(", expected ");
        return Wrong {
            key: inside(path, field),
            expected: known.replace("one of ", "one of the keys "),
            found: Some(format!("the unknown key `{field}`{}", meant(field, known))),
        };
    }
    if let Some((field, _)) = quoted(first, "missing field ") {
        return Wrong {
            key: inside(path, field),
            expected: "a value".into(),
            found: Some("nothing".into()),
        };
    }
    if let Some((variant, rest)) = quoted(first, "unknown variant ") {
        let known = rest.trim_start_matches(", expected ");
        return Wrong {
            key: path.into(),
            expected: known.into(),
            found: Some(format!("`{variant}`{}", meant(variant, known))),
        };
    }
    let wrong_value = ["invalid type: ", "invalid value: ", "invalid length "]
        .iter()
        .any(|start| first.starts_with(start));
    if let (true, Some((_, wanted))) = (wrong_value, first.rsplit_once(", expected ")) {
        return Wrong {
            key: path.into(),
            expected: plain(wanted),
            found: None,
        };
    }
    Wrong {
        key: path.into(),
        expected: "a valid value".into(),
        found: Some(first.into()),
    }
}

/// Which of the words that were expected was meant, as a question.
fn meant(word: &str, expected: &str) -> String {
    did_you_mean(word, quoted_words(expected))
}

fn quoted<'m>(message: &'m str, start: &str) -> Option<(&'m str, &'m str)> {
    message
        .strip_prefix(start)?
        .strip_prefix('`')?
        .split_once('`')
}

/// The key of a field below another key; below none it is the field's own.
pub(super) fn inside(path: &str, field: &str) -> String {
    match path {
        "" => field.into(),
        _ => format!("{path}.{field}"),
    }
}

/// Rust's type names in a user's words.
fn plain(wanted: &str) -> String {
    let words = match wanted {
        "f64" => "a number",
        "u8" => "a whole number from 0 to 255",
        "u16" => "a whole number from 0 to 65535",
        "u32" | "u64" | "usize" => "a whole number, 0 or more",
        "a boolean" => "true or false",
        "a sequence" => "an array",
        "an array of length 2" => "an array of 2 numbers",
        "an array of length 4" => "an array of 4 numbers",
        other if other.starts_with("struct ") => "a table",
        other if other.starts_with("enum ") => "a string",
        other => other,
    };
    words.into()
}
