//! The `hil` program: parses the command line, runs the command, turns its failure into an exit status.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use palpate_hil::cli::{Buses, Cli, Color, Command, RunArgs};
use palpate_hil::{command, progress};

fn main() -> ExitCode {
    let cli = Cli::parse();
    if !cli.command.as_ref().is_some_and(Command::is_quiet) {
        progress::allow();
    }
    let result = match cli.command {
        None => {
            let on = Buses {
                seed: 1,
                ..Buses::default()
            };
            let args = RunArgs {
                on,
                ..RunArgs::default()
            };
            command::run(&args, cli.color)
        }
        Some(Command::Run(args)) => command::run(&args, cli.color),
        Some(Command::Contacts(args)) => command::contacts(&args),
        Some(Command::Emulate(args)) => command::emulate(&args),
        Some(Command::Unit(args)) => command::unit(&args),
        Some(Command::Doctor(args)) => command::doctor(&args),
        Some(Command::Record(args)) => command::record(&args),
        Some(Command::Replay(args)) => command::replay(&args),
        Some(Command::Off(args)) => command::off(&args),
        Some(Command::Guardian(args)) => return ExitCode::from(command::guardian(args)),
        Some(Command::Texture(action)) => command::texture(&action),
        Some(Command::Diff(args)) => command::diff(&args, cli.color),
        Some(Command::List(args)) => command::list(&args),
        Some(Command::New(kind)) => command::new(&kind),
        Some(Command::Check(args)) => command::check(&args),
        Some(Command::Export(kind)) => command::export(&kind),
        Some(Command::Completions(args)) => command::completions(&args),
        Some(Command::Man(args)) => command::man(&args),
        Some(Command::Identify(args)) => command::identify(&args),
        Some(Command::Compare(args)) => command::compare(&args, cli.color),
        Some(Command::Design(args)) => command::design(&args, cli.color),
        Some(Command::Sweep(args)) => command::sweep(&args, cli.color),
        Some(Command::Test(args)) => command::test(&args, cli.color),
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
    if color.on(&std::io::stderr()) {
        "\x1b[1m\x1b[31merror:\x1b[0m"
    } else {
        "error:"
    }
}
