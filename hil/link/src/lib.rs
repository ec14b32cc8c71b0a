//! Several machines: a robot's skin here, a wearer's finger there, over zenoh.
//!
#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

pub mod budget;
pub mod cli;
pub mod ends;
pub mod judge;
pub mod message;
pub mod name;
pub mod net;
pub mod others;
pub mod records;
pub mod ros;

use std::ffi::OsString;
use std::io::Write as _;

use clap::Parser as _;
use palpate_run::Failure;

use cli::{Cli, Command, SchemaArgs};

/// Runs a command line, the program's name first, and returns the exit status.
pub fn main(line: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(line) {
        Ok(cli) => cli,
        Err(error) => return palpate_hil::program::told(&error),
    };
    let done = match cli.command {
        Command::Skin(args) => ends::skin::run(&args),
        Command::Display(args) => ends::display::run(&args),
        Command::Glove(args) => ends::glove::run(&args),
        Command::Relay(args) => others::relay::run(&args),
        Command::List(args) => others::list::run(&args),
        Command::Record(args) => others::record::run(&args),
        Command::Merge(args) => others::merge::run(&args),
        Command::Keys(args) => others::keys::run(&args),
        Command::Ros(args) => ros::run(&args),
        Command::Schema(args) => schema(&args),
        Command::Guardian(args) => return palpate_hil::command::guardian(args),
    };
    match done {
        Ok(()) => 0,
        Err(failure) => {
            // Standard error may be closed as well.
            let _ = writeln!(std::io::stderr(), "error: {failure}");
            failure.status()
        }
    }
}

fn schema(args: &SchemaArgs) -> Result<(), Failure> {
    let bytes = match args.binary {
        true => message::descriptor(),
        false => message::proto_file().into_bytes(),
    };
    palpate_live::output::print(|out| out.write_all(&bytes))
}
