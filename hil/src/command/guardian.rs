//! `hil guardian`: not for people; `hil run` starts it with a socket as its standard input.

use std::time::Duration;

use palpate_buses::guardian::{Watch, serve};

use crate::cli::GuardianArgs;

/// Guards; returns the exit status.
pub fn guardian(args: GuardianArgs) -> u8 {
    serve(&Watch {
        buses: args.i2c,
        oe: args.oe,
        heartbeat: Duration::from_millis(args.heartbeat_ms),
        transfer: Duration::from_millis(args.transfer_ms),
    })
}
