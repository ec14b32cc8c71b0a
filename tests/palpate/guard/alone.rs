#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]
#[path = "mod.rs"]
mod guard;
