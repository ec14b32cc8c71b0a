//! The command line as people meet it: commands in groups, with examples.

use std::fmt::Write;

use clap::{Command, CommandFactory};

use super::Cli;

/// Commands by what they are for. One that no group names stands in the last.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Run", &["run", "serve", "sweep", "design"]),
    ("Compare", &["diff", "compare", "test", "review"]),
    ("Files of your own", &["list", "new", "check", "export"]),
    ("Recordings", &["contacts", "identify", "record", "replay"]),
    ("Hardware", &["doctor", "emulate", "unit", "pulse", "off"]),
    ("People, textures, this program", &["study", "texture"]),
];

/// Lines that work, by command. `FILE` and its like are never among them: an example is there to be typed.
pub(super) const EXAMPLES: [(&[&str], &[&str]); 32] = [
    (
        &[],
        &["hil", "hil run sphere-circle --serve", "hil list scenes"],
    ),
    (
        &["run"],
        &[
            "hil run sphere-circle --html report.html",
            "hil run sphere-along -s illusion.soa_ms=120 -o tuesday",
            "hil run sphere-along -b thesis --illusion phantom",
            "hil run --replay taxels.csv --layout uskin-4x4 --rate 41.3",
        ],
    ),
    (
        &["serve"],
        &[
            "hil serve sphere-circle",
            "hil serve a.mcap b.mcap --at 8200",
        ],
    ),
    (
        &["sweep"],
        &[
            "hil sweep sphere-along -s illusion.soa_ms=100..130:10 --seeds 1..20 -o runs.csv",
            "hil sweep sphere-along -s compression.kc=1,2 --seeds 1..5 -o runs.csv --html runs.html",
        ],
    ),
    (
        &["design"],
        &["hil design --wire loose --diameter-um 50,75 --power-mw 5..20:5 --html designs.html"],
    ),
    (
        &["diff"],
        &[
            "hil diff monday tuesday",
            "hil diff schedule.jsonl capture.vcd --window 0.7..0.9",
        ],
    ),
    (
        &["compare"],
        &[
            "hil compare monday tuesday",
            "hil compare before.csv after.csv --html change.html",
            "hil compare history --html trends.html",
        ],
    ),
    (
        &["test"],
        &[
            "hil test sphere",
            "hil test . --junit trials.xml --html trials.html",
            "hil test . --accept",
        ],
    ),
    (
        &["review"],
        &[
            "hil review",
            "hil review accept press --why \"a lighter finger\"",
        ],
    ),
    (&["list"], &["hil list", "hil list scenes benches"]),
    (
        &["new"],
        &[
            "hil new scene mine --path circle",
            "hil new bench weak --current-ma 800",
        ],
    ),
    (&["new", "scene"], &["hil new scene mine --path circle"]),
    (
        &["new", "bench"],
        &[
            "hil new bench weak --current-ma 800",
            "hil new bench lab --can can0 --i2c /dev/i2c-1",
        ],
    ),
    (
        &["new", "layout"],
        &["hil new layout pad --rows 6 --columns 5 --pitch-mm 3"],
    ),
    (&["new", "wire"], &["hil new wire thin --diameter-um 50"]),
    (
        &["check"],
        &["hil check mine.toml", "hil check --migrate old.toml"],
    ),
    (
        &["export"],
        &[
            "hil export taxels sphere-along -o sphere.csv",
            "hil export views -o views",
        ],
    ),
    (
        &["contacts"],
        &["hil contacts taxels.csv --layout uskin-4x4 --kc 2 --rate 41.3"],
    ),
    (&["identify"], &["hil identify trace.csv -b emulated"]),
    (
        &["record"],
        &["hil record skin.log --can can0 --seconds 60"],
    ),
    (&["replay"], &["hil replay skin.log --can vcan0"]),
    (&["doctor"], &["hil doctor", "hil doctor -b lab.toml"]),
    (&["emulate"], &["hil emulate --can vcan0"]),
    (
        &["unit"],
        &[
            "hil unit --new-key unit.key",
            "hil unit --key unit.key --at 0.0.0.0",
        ],
    ),
    (&["pulse"], &["hil pulse 3", "hil pulse 3 -b lab.toml"]),
    (
        &["off"],
        &["hil off -b lab.toml", "hil off --i2c /dev/i2c-1"],
    ),
    (
        &["study"],
        &[
            "hil study simulate wearer --people 20",
            "hil study run wearer --participant 1 -o my-study",
            "hil study analyse my-study",
        ],
    ),
    (
        &["texture"],
        &["hil texture map", "hil texture strokes -o strokes --varied"],
    ),
    (
        &["texture", "strokes"],
        &["hil texture strokes -o strokes --varied"],
    ),
    (
        &["texture", "materials"],
        &["hil texture materials -o materials.toml --count 350"],
    ),
    (
        &["completions"],
        &["hil completions bash > ~/.local/share/bash-completion/completions/hil"],
    ),
    (&["man"], &["hil man", "hil man study run"]),
];

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
    let command = with_examples(Cli::command(), &[]);
    let groups = groups(&command);
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}{{options}}{{after-help}}\n"
    ))
}

/// A command at the end of these words, and those below it, with their examples.
fn with_examples(command: Command, path: &[&str]) -> Command {
    let own = EXAMPLES.iter().find(|(of, _)| *of == path);
    let command = match own {
        Some((_, lines)) => {
            let head = command.get_styles().get_header();
            let mut text = format!("{head}Examples:{head:#}");
            for line in *lines {
                let _ = write!(text, "\n  {line}");
            }
            command.after_help(text)
        }
        None => command,
    };
    command.mut_subcommands(|inner| {
        let name = inner.get_name().to_owned();
        with_examples(inner, &[path, &[&*name]].concat())
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

/// What a command does, in its first sentence.
fn sentence(command: &Command) -> String {
    let about = command.get_about().map(ToString::to_string);
    let about = about.unwrap_or_default();
    let first = about.split(". ").next().unwrap_or_default();
    first.to_owned()
}

#[cfg(test)]
#[path = "help_tests.rs"]
mod tests;
