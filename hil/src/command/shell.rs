//! `hil completions` and `hil man`: the command line for shells and for `man`.

use clap::{Command, CommandFactory};
use palpate_files::did_you_mean;
use palpate_run::Failure;

use crate::cli::{Cli, CompletionsArgs, ManArgs};
use palpate_live::output::print;

/// Prints a script that completes commands and options.
///
/// # Errors
/// [`Failure::Write`] where standard output takes nothing.
pub fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    // The generator panics where its stream is gone, so it writes to memory.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut visible(), "hil", &mut script);
    print(|out| out.write_all(&script))
}

/// The program without what is internal.
fn visible() -> Command {
    let all = Cli::command();
    let shown = all.get_subcommands().filter(|c| !c.is_hide_set()).cloned();
    let shown: Vec<Command> = shown.collect();
    let about = all.get_about().cloned().unwrap_or_default();
    Command::new("hil")
        .version(env!("CARGO_PKG_VERSION"))
        .about(about)
        .args(all.get_arguments().cloned())
        .subcommands(shown)
}

/// Prints a page for `man`: of the program, or of one command.
///
/// # Errors
/// [`Failure::Input`] for a command that is none.
pub fn man(args: &ManArgs) -> Result<(), Failure> {
    let mut program = visible();
    program.build();
    let (page, title) = match &args.command {
        None => (program, "hil".to_owned()),
        Some(name) => {
            let commands = program.get_subcommands();
            let names: Vec<&str> = commands.map(Command::get_name).collect();
            let command = program.find_subcommand(name).cloned();
            let command = command.ok_or_else(|| {
                let meant = did_you_mean(name, names.iter().copied());
                let all = names.join(", ");
                Failure::Input(format!(
                    "man: expected a command ({all}), found `{name}`{meant}"
                ))
            })?;
            (command, format!("hil-{name}"))
        }
    };
    print(|out| clap_mangen::Man::new(page).title(title).render(out))
}
