//! Options of `hil unit`, and those that name a unit to other commands.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;
use palpate_buses::datagrams::address;

/// Options of `hil unit`.
#[derive(Debug, Args)]
pub struct UnitArgs {
    /// Where to listen: ADDRESS or ADDRESS:PORT. 0.0.0.0 lets other computers in; a key is needed in any case.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1", value_parser = address)]
    pub listen: SocketAddr,
    /// The file of the key that its host has too; its owner alone may read it.
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Make such a file, and nothing else.
    #[arg(long, value_name = "FILE", exclusive = true)]
    pub new_key: Option<PathBuf>,
    /// The bench whose boards, wires and limits it has: built in or a file (default: emulated).
    #[arg(long, value_name = "NAME|FILE")]
    pub bench: Option<String>,
    /// The I2C adapter (/dev/i2c-N) of real boards, in place of the bench's.
    #[arg(long, value_name = "DEVICE")]
    pub i2c: Option<PathBuf>,
    /// Print what happens as JSON Lines: sessions, stops, every edge of an emulated output, the record at the end.
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors.
    #[arg(long, conflicts_with = "json")]
    pub quiet: bool,
}
