//! The `hil` program: parses the command line, runs the command, turns its failure into an exit status.

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;
use palpate_hil::cli::{Cli, Command, RunArgs};
use palpate_hil::command;

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        None => command::run(&RunArgs {
            seed: 1,
            ..RunArgs::default()
        }),
        Some(Command::Run(args)) => command::run(&args),
        Some(Command::Contacts(args)) => command::contacts(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // Nobody may be reading standard error either.
            let _ = writeln!(std::io::stderr(), "error: {failure}");
            ExitCode::from(failure.status())
        }
    }
}
