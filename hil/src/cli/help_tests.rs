//! Tests of `help.rs`.

use std::collections::BTreeMap;

use clap::Command;

use super::*;

/// Every command, with the words that lead to it.
fn all(command: &Command, path: &str, into: &mut Vec<(String, Command)>) {
    into.push((path.to_owned(), command.clone()));
    for inner in command.get_subcommands() {
        all(inner, &format!("{path} {}", inner.get_name()), into);
    }
}

fn every_command() -> Vec<(String, Command)> {
    let mut found = Vec::new();
    all(&command(), "hil", &mut found);
    found
}

/// The words of a line as a shell has them, up to a redirection.
fn words(line: &str) -> Vec<String> {
    let line = line.split(" > ").next().unwrap();
    let mut words = vec![String::new()];
    let mut quoted = false;
    for c in line.chars() {
        match c {
            '"' => quoted = !quoted,
            ' ' if !quoted => words.push(String::new()),
            c => words.last_mut().unwrap().push(c),
        }
    }
    words
}

#[test]
fn every_example_is_a_command_line() {
    let mut shown = 0;
    for (path, _) in every_command() {
        for line in examples(&path) {
            let words = words(line);
            assert!(line.starts_with(&path), "{line}");
            let parsed = command().try_get_matches_from(&words);
            assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
            shown += 1;
        }
    }
    // Whatever is no heading and no gap is shown behind some command.
    let others = |line: &&str| !line.is_empty() && !line.starts_with('[');
    assert_eq!(shown, EXAMPLES.lines().filter(others).count());
}

#[test]
fn groups_name_commands_that_there_are_and_fit_a_terminal() {
    for (_, names) in GROUPS {
        for name in names {
            assert!(command().find_subcommand(name).is_some(), "{name}");
        }
    }
    let help = command().render_help().to_string();
    for line in help.lines() {
        assert!(line.chars().count() <= 80, "{line}");
    }
    assert!(!help.contains("guardian"), "{help}");
    for inner in shown().get_subcommands() {
        assert!(
            help.contains(&format!("\n  {} ", inner.get_name())),
            "{help}"
        );
    }
}

/// One letter is one option everywhere, and one thing has one name.
#[test]
fn short_options_and_words_mean_the_same_in_every_command() {
    let mut letters: BTreeMap<char, String> = BTreeMap::new();
    for (path, command) in every_command() {
        for option in command.get_arguments() {
            let Some(long) = option.get_long() else {
                continue;
            };
            for gone in ["report", "csv", "listen", "felt", "folder"] {
                assert_ne!(long, gone, "{path}");
            }
            let Some(short) = option.get_short() else {
                continue;
            };
            let same = letters.entry(short).or_insert_with(|| long.to_owned());
            assert_eq!(same, long, "{path} -{short}");
        }
    }
    assert!(letters.len() > 6, "{letters:?}");
}
