//! Options of `hil unit`, and those that name a unit to other commands.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;
use palpate_buses::datagrams::address;
use palpate_files::Overrides;

/// Options of `hil unit`.
#[derive(Debug, Args)]
pub struct UnitArgs {
    /// Listen at ADDRESS or ADDRESS:PORT. 0.0.0.0 lets other computers in; a key is needed in any case.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1", value_parser = address)]
    pub at: SocketAddr,
    /// The file of the key that its host has too; its owner alone may read it.
    #[arg(long, value_name = "FILE")]
    pub key: Option<PathBuf>,
    /// Make such a file, and nothing else.
    #[arg(long, value_name = "FILE", exclusive = true)]
    pub new_key: Option<PathBuf>,
    /// The bench whose boards, wires and limits it has: built in or a file (default: emulated).
    #[arg(short = 'b', long, value_name = "NAME|FILE")]
    pub bench: Option<String>,
    /// The I2C adapter (/dev/i2c-N) of real boards, in place of the bench's.
    #[arg(long, value_name = "DEVICE")]
    pub i2c: Option<PathBuf>,
    /// Print what happens as JSON Lines: sessions, stops, every edge of an emulated output, the record at the end.
    #[arg(long)]
    pub json: bool,
    /// Print nothing but errors.
    #[arg(short = 'q', long, conflicts_with = "json")]
    pub quiet: bool,
}

/// A driver unit in place of a bench's boards.
#[derive(Clone, Debug, Default, Args)]
pub struct UnitOn {
    /// A driver unit that has the boards (`hil unit`, or firmware): ADDRESS or ADDRESS:PORT.
    #[arg(long, value_name = "ADDRESS", requires = "key")]
    pub unit: Option<String>,
    /// The file of the key that is shared with the unit.
    #[arg(long, value_name = "FILE", requires = "unit")]
    pub key: Option<PathBuf>,
}

impl UnitOn {
    /// Puts the unit into a bench.
    pub fn change(&self, overrides: &mut Overrides) {
        let quoted =
            |text: &str| format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""));
        if let (Some(unit), Some(key)) = (&self.unit, &self.key) {
            overrides.bench("--unit", "unit.address", quoted(unit));
            overrides.bench("--key", "unit.key", quoted(&key.to_string_lossy()));
        }
    }
}
