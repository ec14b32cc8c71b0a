//! Guesses at a mistyped command line: a command, a scene, an option of another name or place.

use std::ffi::OsString;
use std::path::Path;

use clap::Command;
use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, Error, ErrorKind};
use palpate_files::nearest;

use super::command;

/// Options that have another name now: the command, the old and the new name. An empty name was a place on the line.
const RENAMED: [(&str, &str, &str); 14] = [
    ("run", "--report", "--html FILE"),
    ("run", "--felt", "--person NAME"),
    ("run", "--shape", "--set illusion.shape=P"),
    ("run", "--alpha", "--set illusion.alpha=PART"),
    ("run", "--beta", "--set illusion.beta=PART"),
    ("run", "--tau-d-ms", "--set illusion.tau_d_ms=MS"),
    ("run", "--soa-ms", "--set illusion.soa_ms=MS"),
    ("design", "--csv", "--out FILE"),
    ("unit", "--listen", "--at ADDRESS"),
    ("texture panel", "--felt", "--person NAME"),
    ("texture strokes", "", "--out DIR"),
    ("texture materials", "", "--out FILE"),
    ("texture export", "", "--out FILE"),
    ("export views", "", "--out DIR"),
];

/// The error of a command line, with what was probably meant.
#[must_use]
pub fn meant(mut error: Error, line: &[OsString]) -> Error {
    let all = command();
    let words: Vec<&str> = line.iter().skip(1).filter_map(|w| w.to_str()).collect();
    let (path, at) = reached(&all, &words);
    let tip = match error.kind() {
        ErrorKind::InvalidSubcommand => {
            let word = text_of(&error, ContextKind::InvalidSubcommand);
            let found = word.map(|word| another_command(&all, &path, at, &word));
            match found {
                Some(Ok(name)) => {
                    let names = ContextValue::Strings(vec![name]);
                    error.insert(ContextKind::SuggestedSubcommand, names);
                    None
                }
                Some(Err(tip)) => tip,
                None => None,
            }
        }
        ErrorKind::UnknownArgument => {
            let word = text_of(&error, ContextKind::InvalidArg);
            let tip = word.and_then(|word| another_option(&all, &path, at, &word));
            tip.or_else(|| hyphens(at, &words))
        }
        ErrorKind::InvalidValue | ErrorKind::ValueValidation => hyphens(at, &words),
        _ => None,
    };
    if let Some(tip) = tip {
        // Clap's own guess is worth less.
        error.remove(ContextKind::SuggestedSubcommand);
        error.remove(ContextKind::SuggestedArg);
        let tip = ContextValue::StyledStrs(vec![StyledStr::from(tip)]);
        error.insert(ContextKind::Suggested, tip);
    }
    error
}

fn text_of(error: &Error, kind: ContextKind) -> Option<String> {
    match error.get(kind)? {
        ContextValue::String(text) => Some(text.clone()),
        _ => None,
    }
}

/// The innermost command that the words name, and the way to it.
fn reached<'c>(all: &'c Command, words: &[&str]) -> (String, &'c Command) {
    let (mut path, mut at) = (Vec::new(), all);
    for word in words.iter().filter(|word| !word.starts_with('-')) {
        match at.find_subcommand(word) {
            Some(inner) => {
                path.push(*word);
                at = inner;
            }
            None => break,
        }
    }
    (path.join(" "), at)
}

/// A command that is none: the name that is near, else what there is to say.
fn another_command(
    all: &Command,
    path: &str,
    at: &Command,
    word: &str,
) -> Result<String, Option<String>> {
    if path.is_empty() && is_scene(word) {
        return Err(Some(format!("a scene is run by `hil run {word}`")));
    }
    // `hil simulate` stands below `hil study`, and is not `hil emulate` misspelt.
    let mut below = all.get_subcommands();
    if let Some(owner) = below.find(|c| c.find_subcommand(word).is_some()) {
        let owner = owner.get_name();
        return Err(Some(format!("`hil {owner} {word}` is a command")));
    }
    // `hil unlatch` is an option of `hil off`, and is not `hil emulate` misspelt.
    let has = |c: &&Command| c.get_arguments().any(|a| a.get_long() == Some(word));
    let mut with: Vec<&Command> = all.get_subcommands().filter(has).collect();
    if let (Some(owner), true) = (with.pop(), with.is_empty()) {
        let owner = owner.get_name();
        return Err(Some(format!("`hil {owner} --{word}` is an option")));
    }
    let names = at.get_subcommands().filter(|c| !c.is_hide_set());
    let near = nearest(word, names.map(Command::get_name));
    near.map(str::to_owned).ok_or(None)
}

/// Returns true if a word names a built-in scene or a file of settings.
fn is_scene(word: &str) -> bool {
    let named = palpate_fixtures::scene_names().any(|name| name == word);
    named || Path::new(word).extension().is_some_and(|e| e == "toml")
}

/// An option or word that a command does not take.
fn another_option(all: &Command, path: &str, at: &Command, word: &str) -> Option<String> {
    let name = word.split('=').next().unwrap_or(word);
    let old = if name.starts_with('-') { name } else { "" };
    let renamed = RENAMED
        .iter()
        .find(|(of, was, _)| *of == path && *was == old);
    if let Some((_, was, is)) = renamed {
        let was = if was.is_empty() { name } else { was };
        return Some(format!("in place of `{was}` there is `{is}`"));
    }
    if old.is_empty() {
        let one = matches!(path, "run" | "sweep");
        return one.then(|| {
            format!("one scene at a time; `hil test` tries several, such as `hil test .. {word}`")
        });
    }
    let long = name.strip_prefix("--")?;
    let has = |c: &Command| c.get_arguments().any(|a| a.get_long() == Some(long));
    if at.get_arguments().any(|a| a.get_long() == Some(long)) {
        return None; // it takes no value, or stands twice
    }
    let mut others = all.get_subcommands().filter(|c| !c.is_hide_set());
    let other = others.find(|c| has(c))?.get_name();
    Some(match path {
        "" => format!("`{name}` belongs to a command: `hil {other} {name}`"),
        _ => format!("`hil {other}` has `{name}`"),
    })
}

/// A long option behind one hyphen, which a shell takes for several short ones.
fn hyphens(at: &Command, words: &[&str]) -> Option<String> {
    let long = |word: &&str| {
        let name = word.strip_prefix('-')?.split('=').next()?;
        let known = at.get_arguments().any(|a| a.get_long() == Some(name));
        (name.len() > 1 && known).then(|| format!("long options have two hyphens: `--{name}`"))
    };
    words.iter().find_map(long)
}
