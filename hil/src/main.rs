//! The `hil` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(palpate_hil::program::main(std::env::args_os(), None))
}
