//! The `hil` program: parses the command line, runs the command, turns its failure into an exit status.

use std::io::{IsTerminal, Write};
use std::process::ExitCode;

use clap::Parser;
use palpate_hil::cli::{Cli, Color, Command, RunArgs};
use palpate_hil::command;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let result = match cli.command {
        None => command::run(&RunArgs {
            seed: 1,
            ..RunArgs::default()
        }),
        Some(Command::Run(args)) => command::run(&args),
        Some(Command::Contacts(args)) => command::contacts(&args),
        Some(Command::Emulate(args)) => command::emulate(&args),
        Some(Command::Doctor(args)) => command::doctor(&args),
        Some(Command::Record(args)) => command::record(&args),
        Some(Command::Replay(args)) => command::replay(&args),
        Some(Command::Off(args)) => command::off(&args),
        Some(Command::Guardian(args)) => return ExitCode::from(command::guardian(args)),
        Some(Command::Texture(action)) => command::texture(&action),
        Some(Command::Diff(args)) => command::diff(&args),
        Some(Command::List(args)) => command::list(&args),
        Some(Command::New(kind)) => command::new(&kind),
        Some(Command::Check(args)) => command::check(&args),
        Some(Command::Export(kind)) => command::export(&kind),
        Some(Command::Completions(args)) => command::completions(&args),
        Some(Command::Man(args)) => command::man(&args),
        Some(Command::Test(args)) => command::test(&args),
        Some(Command::Review(args)) => command::review(&args, cli.color),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // Nobody may be reading standard error either.
            if !failure.to_string().is_empty() {
                let _ = writeln!(std::io::stderr(), "{} {failure}", prefix(cli.color));
            }
            ExitCode::from(failure.status())
        }
    }
}

/// What an error message starts with; the bytes are those of clap's own errors.
fn prefix(color: Color) -> &'static str {
    let colored = match color {
        Color::Always => true,
        Color::Never => false,
        Color::Auto => {
            let asked_not_to = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty());
            !asked_not_to && std::io::stderr().is_terminal()
        }
    };
    if colored {
        "\x1b[1m\x1b[31merror:\x1b[0m"
    } else {
        "error:"
    }
}
