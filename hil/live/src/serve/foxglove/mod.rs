//! A run as topics for [Foxglove](https://foxglove.dev) and its kin while it goes on: messages of the recording's schemas
//! over a WebSocket of this computer. Clients look; nothing that they say reaches the run.

mod client;
mod hub;
mod run;
mod words;

pub use run::FoxgloveRun;

use std::io;
use std::net::{Ipv4Addr, TcpStream};
use std::sync::Arc;
use std::time::Duration;

use palpate_run::Failure;

use super::crowd::{Crowd, Place};
use super::gate::Gate;
use super::http::{Brief, Request, answer, switch};
use super::server::{PATIENCE, attend, converse, listen, socket, widen};
use crate::link::key::random;
use crate::output::note;
use hub::Hub;
use words::PROTOCOLS;

/// Port at which Foxglove looks first.
pub const FOXGLOVE_PORT: u16 = 8765;

/// Time for clients to take in the end of the run.
const LAST: Duration = Duration::from_millis(500);
/// Longest message of a client, bytes: subscriptions to all topics of a hand.
const MOST_WISH: usize = 1 << 16;
/// Site whose pages may connect.
const SITE: &str = "https://app.foxglove.dev";

/// A server of a run's topics.
#[derive(Clone, Debug)]
pub struct Foxglove {
    hub: Arc<Hub>,
    /// Address for clients.
    pub url: String,
}

impl Foxglove {
    /// Listens at a port of this computer alone; port 0 takes a free one.
    ///
    /// # Errors
    /// [`Failure::Device`] where that is not possible.
    pub fn open(port: u16) -> Result<Self, Failure> {
        let (listener, address) = listen("--foxglove", (Ipv4Addr::LOCALHOST, port).into())?;
        let session = u64::from_le_bytes(random()?).to_string();
        let hub = Arc::new(Hub::new(session));
        let gate = Gate::at(address, 1)?;
        let served = Arc::clone(&hub);
        let connect = move |stream: TcpStream, place: Place, clients: &Arc<Crowd>| {
            connection(stream, place, clients, (&gate, &served))
        };
        attend(listener, connect)
            .map_err(|e| Failure::Device(format!("--foxglove {address}: {e}")))?;
        let url = format!("ws://{address}");
        Ok(Self { hub, url })
    }

    /// Tells whether a client has come.
    #[must_use]
    pub fn is_seen(&self) -> bool {
        self.hub.is_seen()
    }

    /// Tells clients that the run is over, with its summary. They have a moment to take it in. A note says how many messages
    /// found no room.
    pub fn over(&self, line: &str) {
        self.hub.last_words(line, LAST);
        match self.hub.left_out() {
            0 => {}
            left_out => note(&format!(
                "--foxglove: {left_out} messages were left out for clients that read too slowly"
            )),
        }
    }
}

/// Reads a request and answers it. One that speaks the protocol becomes a client, until either side ends.
fn connection(
    stream: TcpStream,
    place: Place,
    clients: &Arc<Crowd>,
    (gate, hub): (&Gate, &Hub),
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let mut brief = Brief::new(&stream, PATIENCE);
    let plain = "text/plain; charset=utf-8";
    let Some(request) = Request::read(&mut brief)? else {
        let expected = "expected a GET of a WebSocket";
        return answer(&mut brief, "400 Bad Request", plain, expected);
    };
    if let Err(why) = admits(gate, &request) {
        return answer(&mut brief, "403 Forbidden", plain, why);
    }
    let Some(key) = &request.socket_key else {
        let expected =
            "expected a WebSocket: open this address in Foxglove, with ws in place of http";
        return answer(&mut brief, "426 Upgrade Required", plain, expected);
    };
    let offered = |name: &&str| request.protocols.split(',').any(|own| own.trim() == *name);
    let Some(protocol) = PROTOCOLS.into_iter().find(offered) else {
        let expected = "Sec-WebSocket-Protocol: expected foxglove.sdk.v1 or foxglove.websocket.v1";
        return answer(&mut brief, "400 Bad Request", plain, expected);
    };
    let _client = clients.enter(&stream)?;
    drop(place);
    switch(&mut brief, key, Some(protocol))?;
    stream.set_read_timeout(None)?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut words = socket(stream);
    widen(&mut words, MOST_WISH);
    let client = hub.enter();
    converse(words, &client, |text| hub.hear(&client, text));
    hub.sweep();
    Ok(())
}

/// Checks that a request comes from a program of this computer or from Foxglove's own pages: any page of any site can ask a
/// browser to connect here. The error is a sentence.
fn admits(gate: &Gate, request: &Request) -> Result<(), &'static str> {
    gate.admits(request)?;
    let is_of_a_site = match &*request.origin {
        "" | SITE => false,
        "null" => true,
        origin => match origin.strip_prefix("http://") {
            Some(host) => !super::gate::is_this_computer(host),
            // A desktop program has a scheme of its own.
            None => origin.starts_with("https://"),
        },
    };
    match is_of_a_site {
        true => Err("Origin: expected a program of this computer, or https://app.foxglove.dev"),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests;
