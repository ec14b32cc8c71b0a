//! The command line of `hil serve`.

use std::net::SocketAddr;

use clap::Args;

use super::{Buses, RunArgs, SERVE_AT, Voice, serve_at};

/// Options of `hil serve`.
#[derive(Debug, Args)]
pub struct ServeArgs {
    /// A built-in scene or a file (default: sphere-along), or one or two recordings of runs (.mcap), or folders with them.
    #[arg(value_name = "SCENE|FILE", num_args = 0..=2)]
    pub what: Vec<String>,
    /// Bench of the run.
    #[command(flatten)]
    pub on: Buses,
    /// Address: PORT of this computer or ADDRESS or ADDRESS:PORT; port 0 takes a free one.
    #[arg(long, value_name = "ADDRESS", default_value = SERVE_AT, value_parser = serve_at)]
    pub at: SocketAddr,
    /// Open the page in this computer's browser (xdg-open).
    #[arg(long)]
    pub open: bool,
    /// Begin a scene anew whenever its run is over, until Ctrl-C or STOP. Emulated benches only.
    #[arg(long = "loop")]
    pub again: bool,
    /// Amount that the command says.
    #[command(flatten)]
    pub voice: Voice,
}

impl From<ServeArgs> for RunArgs {
    fn from(args: ServeArgs) -> Self {
        Self {
            scene: args.what.into_iter().next(),
            on: args.on,
            voice: args.voice,
            open: args.open,
            again: args.again,
            serve: Some(args.at),
            ..Self::default()
        }
    }
}
