//! The parser's sentences turned into ours: which key, what was expected, what was found.

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
            key: with_last(path, field),
            expected: known.replace("one of ", "one of the keys "),
            found: Some(format!("the unknown key `{field}`")),
        };
    }
    if let Some((field, _)) = quoted(first, "missing field ") {
        return Wrong {
            key: with_last(path, field),
            expected: "a value".into(),
            found: Some("nothing".into()),
        };
    }
    if let Some((variant, rest)) = quoted(first, "unknown variant ") {
        return Wrong {
            key: path.into(),
            expected: rest.trim_start_matches(", expected ").into(),
            found: Some(format!("`{variant}`")),
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

fn quoted<'m>(message: &'m str, start: &str) -> Option<(&'m str, &'m str)> {
    message
        .strip_prefix(start)?
        .strip_prefix('`')?
        .split_once('`')
}

fn with_last(path: &str, field: &str) -> String {
    let last = path.rsplit('.').next().unwrap_or_default();
    match path {
        "" => field.into(),
        _ if last == field => path.into(),
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
        "string or table" => "a string",
        other if other.starts_with("struct ") => "a table",
        other if other.starts_with("enum ") => "a string",
        other => other,
    };
    words.into()
}
