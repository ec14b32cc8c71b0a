//! The `palpate-link` program.

use std::os::unix::process::CommandExt as _;
use std::process::{Command, ExitCode};

/// Variable from which alone zenoh takes the number of its threads.
const THREADS: &str = "ZENOH_RUNTIME";

/// Zenoh's threads: a link that is cut holds one of them up while it is closed, until the network is back. With zenoh's
/// own two, a cut of both connections of an end keeps it from connecting again for seconds.
const ENOUGH: &str = "(app: (worker_threads: 4), acc: (worker_threads: 4), tx: (worker_threads: 4), net: (worker_threads: 4), rx: (worker_threads: 8))";

fn main() -> ExitCode {
    if std::env::var_os(THREADS).is_none()
        && let Ok(program) = std::env::current_exe()
    {
        let mut again = Command::new(program);
        again.args(std::env::args_os().skip(1)).env(THREADS, ENOUGH);
        // It returns only where starting failed; zenoh's own number counts then.
        let _ = again.exec();
    }
    ExitCode::from(palpate_link::main(std::env::args_os()))
}
