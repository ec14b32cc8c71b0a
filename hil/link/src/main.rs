//! The `palpate-link` program.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(palpate_link::main(std::env::args_os()))
}
