//! The command line as people meet it: commands in groups, with examples.

use std::fmt::Write;

use clap::{Command, CommandFactory};

use super::Cli;

/// Commands by purpose. One that no group names stands in the last.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Run", &["run", "serve", "sweep", "design", "calibrate"]),
    (
        "Compare",
        &["diff", "compare", "reproduce", "test", "review"],
    ),
    ("Files of your own", &["list", "new", "check", "export"]),
    (
        "Recordings",
        &["contacts", "import", "identify", "record", "replay"],
    ),
    ("Hardware", &["doctor", "emulate", "unit", "pulse", "off"]),
    ("People, textures, this program", &["study", "texture"]),
];

/// Lines that work, behind the command that they show. `FILE` and its like are never among them: an example is there to
/// be typed.
const EXAMPLES: &str = include_str!("examples.txt");

/// The examples of a command, which is given by all its words.
fn examples(path: &str) -> impl Iterator<Item = &'static str> {
    let head = format!("[{path}]");
    let own = EXAMPLES.lines().skip_while(move |line| *line != head);
    own.skip(1).take_while(|line| !line.is_empty())
}

/// The command line with groups and examples, without what is internal.
pub fn shown() -> Command {
    let all = command();
    // Clap takes no command out, so the others are put into a program of the same face.
    let others = all.get_subcommands().filter(|c| !c.is_hide_set());
    let others: Vec<Command> = others.cloned().collect();
    Command::new("hil")
        .version(env!("CARGO_PKG_VERSION"))
        .about(all.get_about().cloned().unwrap_or_default())
        .after_help(all.get_after_help().cloned().unwrap_or_default())
        .args(all.get_arguments().cloned())
        .subcommands(others)
}

/// The whole command line, as it is parsed.
pub fn command() -> Command {
    let command = with_examples(Cli::command(), "hil");
    let groups = groups(&command);
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}{{options}}{{after-help}}\n"
    ))
}

/// A command that is called by these words, and those below it, with their examples.
fn with_examples(command: Command, path: &str) -> Command {
    let head = *command.get_styles().get_header();
    let lines: String = examples(path).map(|line| format!("\n  {line}")).collect();
    let command = match lines.is_empty() {
        true => command,
        false => command.after_help(format!("{head}Examples:{head:#}{lines}")),
    };
    command.mut_subcommands(|inner| {
        let path = format!("{path} {}", inner.get_name());
        with_examples(inner, &path)
    })
}

/// The commands in their groups, a line each.
fn groups(command: &Command) -> String {
    let styles = command.get_styles();
    let (head, name) = (styles.get_header(), styles.get_literal());
    let known = |c: &&Command| !c.is_hide_set();
    let grouped = |c: &Command| {
        GROUPS
            .iter()
            .any(|(_, names)| names.contains(&c.get_name()))
    };
    let mut text = String::new();
    for (n, (title, names)) in GROUPS.iter().enumerate() {
        let _ = writeln!(text, "{head}{title}:{head:#}");
        let own = names
            .iter()
            .filter_map(|name| command.find_subcommand(name));
        let last = n + 1 == GROUPS.len();
        let rest = command.get_subcommands().filter(|c| last && !grouped(c));
        for inner in own.chain(rest).filter(known) {
            let _ = writeln!(
                text,
                "  {name}{:<12}{name:#}{}",
                inner.get_name(),
                sentence(inner)
            );
        }
        text.push('\n');
    }
    let _ = writeln!(text, "{head}Options:{head:#}");
    text
}

/// The first sentence of a command's description.
fn sentence(command: &Command) -> String {
    let about = command.get_about().map(ToString::to_string);
    let about = about.unwrap_or_default();
    let first = about.split(". ").next().unwrap_or_default();
    first.to_owned()
}

#[cfg(test)]
#[path = "help_tests.rs"]
mod tests;
