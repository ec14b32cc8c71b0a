//! The program as a whole: parses the command line, runs the command, turns its failure into an exit status. The binary
//! `hil` is this, and so is the console script of the wheel.

use std::ffi::OsString;
use std::io::{self, Write};

use clap::FromArgMatches;

use crate::cli::{self, Buses, Cli, Color, Command, RunArgs};
use crate::command;
use palpate_live::{again, progress};
use palpate_run::Failure;

/// Runs a command line, the program's name first, and returns the exit status.
///
/// `words` are those that start this program in a process of its own, without a command. None where it is this
/// executable; an interpreter that has the program as a module says how it is to be called.
pub fn main(line: impl IntoIterator<Item = OsString>, words: Option<Vec<OsString>>) -> u8 {
    if let Some(words) = words.filter(|words| !words.is_empty()) {
        again::is_started_by(words);
    }
    let line: Vec<OsString> = line.into_iter().collect();
    if cli::complete(&line) {
        return 0;
    }
    let parsed = cli::command().try_get_matches_from(&line);
    let cli = match parsed.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(error) => return told(&cli::meant(error, &line)),
    };
    if !cli.command.as_ref().is_some_and(Command::is_quiet) {
        progress::allow();
    }
    let color = cli.color;
    match run(cli) {
        Ok(status) => status,
        Err(failure) => {
            // Standard error may be closed as well.
            if !failure.to_string().is_empty() {
                let _ = writeln!(io::stderr(), "{} {failure}", prefix(color));
            }
            failure.status()
        }
    }
}

/// Prints the help or the error of a command line that starts nothing; returns the exit status.
pub fn told(error: &clap::Error) -> u8 {
    let printed = error.print().and_then(|()| io::stdout().flush());
    match printed {
        // Help that was asked for and is not there; a reader that has gone away is no error.
        Err(cause) if !error.use_stderr() && cause.kind() != io::ErrorKind::BrokenPipe => {
            let failure = Failure::written("standard output")(cause);
            let _ = writeln!(io::stderr(), "{} {failure}", prefix(Color::Auto));
            failure.status()
        }
        _ => u8::try_from(error.exit_code()).unwrap_or(2),
    }
}

fn run(cli: Cli) -> Result<u8, Failure> {
    match cli.command {
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
        Some(Command::Serve(args)) => command::serve(args, cli.color),
        Some(Command::Contacts(args)) => command::contacts(&args),
        Some(Command::Import(args)) => command::import(&args),
        Some(Command::Emulate(args)) => command::emulate(&args),
        Some(Command::Unit(args)) => command::unit(&args),
        Some(Command::Doctor(args)) => command::doctor(&args),
        Some(Command::Record(args)) => command::record(&args),
        Some(Command::Replay(args)) => command::replay(&args),
        Some(Command::Pulse(args)) => command::pulse(&args),
        Some(Command::Off(args)) => command::off(&args),
        Some(Command::Guardian(args)) => return Ok(command::guardian(args)),
        Some(Command::Texture(action)) => command::texture(&action),
        Some(Command::Study(action)) => command::study(action),
        Some(Command::Diff(args)) => command::diff(&args, cli.color),
        Some(Command::List(args)) => command::list(&args),
        Some(Command::New(kind)) => command::new(&kind),
        Some(Command::Check(args)) => command::check(&args),
        Some(Command::Export(kind)) => command::export(&kind),
        Some(Command::Completions(args)) => command::completions(&args),
        Some(Command::Man(args)) => command::man(&args),
        Some(Command::Identify(args)) => command::identify(&args),
        Some(Command::Calibrate(args)) => command::calibrate(&args),
        Some(Command::Compare(args)) => command::compare(&args, cli.color),
        Some(Command::Design(args)) => match &args.response {
            Some(bench) => command::response(&args, bench, cli.color),
            None => command::design(&args, cli.color),
        },
        Some(Command::Reproduce(args)) => command::reproduce(&args),
        Some(Command::Sweep(args)) => command::sweep(&args, cli.color),
        Some(Command::Test(args)) => command::test(&args, cli.color),
        Some(Command::Review(args)) => command::review(&args, cli.color),
    }
    .map(|()| 0)
}

/// Start of an error message: the bytes are those of clap's own errors.
fn prefix(color: Color) -> &'static str {
    if color.on(&io::stderr()) {
        "\x1b[1m\x1b[31merror:\x1b[0m"
    } else {
        "error:"
    }
}
