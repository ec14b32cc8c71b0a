//! Nearest known name to a mistyped word.

/// The nearest of `names` to a word, if one is near enough to be meant: a letter in three may differ, and a unit at
/// the end may be missing.
#[must_use]
pub fn nearest<'n>(word: &str, names: impl IntoIterator<Item = &'n str>) -> Option<&'n str> {
    // Every name ends alike, which tells nothing.
    let plain = |text: &str| {
        let stem = text.strip_suffix(".toml").unwrap_or(text);
        stem.to_lowercase().replace('_', "-")
    };
    let word = plain(word);
    let near = |name: &'n str| {
        let full = plain(name);
        let unit = full
            .strip_prefix(&word)
            .is_some_and(|rest| rest.starts_with('-'));
        let distance = if unit && !word.is_empty() {
            1
        } else {
            strsim::damerau_levenshtein(&word, &full)
        };
        let longest = word.chars().count().max(full.chars().count());
        (distance * 3 <= longest).then_some((distance, name))
    };
    // The first of equals: names come in the order in which errors list them.
    let found = names.into_iter().filter_map(near).min_by_key(|(d, _)| *d);
    found.map(|(_, name)| name)
}

/// The question at the end of an error; empty where nothing is near.
#[must_use]
pub fn did_you_mean<'n>(word: &str, names: impl IntoIterator<Item = &'n str>) -> String {
    nearest(word, names).map_or_else(String::new, |name| format!("; did you mean `{name}`?"))
}

/// The words in backquotes of a sentence.
pub(super) fn quoted_words(sentence: &str) -> impl Iterator<Item = &str> {
    sentence.split('`').skip(1).step_by(2)
}

#[cfg(test)]
#[path = "near_tests.rs"]
mod tests;
