//! Pages for browsers: over a run (`hil run --serve`) or a recording (`hil serve`) in the playground's looks, with pictures
//! through a WebSocket; those of a study's participant and experimenter; and a run's topics for Foxglove.

mod crowd;
mod desk;
mod files;
mod foxglove;
mod gate;
mod http;
mod live;
mod pictures;
mod post;
mod recordings;
mod server;
mod slot;

pub use desk::{Desk, Heard};
pub use files::notebook;
pub use foxglove::{FOXGLOVE_PORT, Foxglove, FoxgloveRun};
pub use live::Live;
pub use pictures::LiveRun;
pub use recordings::Recordings;

use std::net::{Ipv4Addr, SocketAddr};

use palpate_buses::datagrams::address_or;

/// Port of a page where an address names none.
pub const PORT: u16 = 8137;

/// An address to serve at: `PORT` of this computer, `ADDRESS` or `ADDRESS:PORT`.
///
/// # Errors
/// Words of the expected address.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    match text.parse::<u16>() {
        Ok(port) => Ok((Ipv4Addr::LOCALHOST, port).into()),
        // A resolver takes a number for the bits of an address.
        Err(_) if !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit()) => {
            Err(format!("expected a port from 0 to 65535, found {text}"))
        }
        Err(_) => address_or(text, PORT),
    }
}
