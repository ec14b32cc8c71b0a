//! `hil completions` and `hil man`: the command line for shells and for `man`.

use clap_complete::env::Shells;
use palpate_files::did_you_mean;
use palpate_run::Failure;

use crate::cli::{CompletionsArgs, ManArgs, VARIABLE, shown};
use palpate_live::output::print;

/// Prints a script by which a shell asks this program what a word may become.
///
/// # Errors
/// [`Failure::Write`] where standard output takes nothing.
pub fn completions(args: &CompletionsArgs) -> Result<(), Failure> {
    let shell = args.shell.to_string();
    let mut script = Vec::new();
    if let Some(completer) = Shells::builtins().completer(&shell) {
        let written = completer.write_registration(VARIABLE, "hil", "hil", "hil", &mut script);
        written.map_err(Failure::written("standard output"))?;
    }
    print(|out| out.write_all(&script))
}

/// Prints a page for `man`: of the program, of one command, or of one below it.
///
/// # Errors
/// [`Failure::Input`] for a command that is none.
pub fn man(args: &ManArgs) -> Result<(), Failure> {
    let mut page = shown();
    page.build();
    let mut title = "hil".to_owned();
    for name in &args.command {
        let commands = page.get_subcommands();
        let names: Vec<&str> = commands.map(clap::Command::get_name).collect();
        let found = page.find_subcommand(name).cloned();
        page = found.ok_or_else(|| {
            let meant = did_you_mean(name, names.iter().copied());
            let expected = match names.is_empty() {
                true => format!("nothing behind `{}`", title.replace('-', " ")),
                false => format!("a command ({})", names.join(", ")),
            };
            Failure::Input(format!("man: expected {expected}, found `{name}`{meant}"))
        })?;
        title = format!("{title}-{name}");
    }
    print(|out| clap_mangen::Man::new(page).title(title).render(out))
}
