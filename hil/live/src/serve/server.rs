//! The server of a page: a thread that waits for browsers, and a thread for each of them.

use std::io;
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::Builder;
use std::time::Duration;

use palpate_run::Failure;
use tungstenite::Message;
use tungstenite::protocol::{Role, WebSocket, WebSocketConfig};

use super::files::{self, Page};
use super::gate::Gate;
use super::http::{Request, answer, switch};
use super::slot::Slot;

/// A browser has so long for the head of its request, and for taking what it is sent.
const PATIENCE: Duration = Duration::from_secs(5);
/// Connections at once; a page needs two at most, once it is loaded one.
const MOST: usize = 64;
/// Longest message of a page that looks on, bytes.
const MOST_WISH: usize = 4096;

/// What pages are shown.
pub(super) trait Show: Send + Sync + 'static {
    /// What the page is over.
    fn look(&self) -> Page;

    /// Longest message of a page, bytes: a wish in a few words, if nothing else is said.
    fn longest(&self) -> usize {
        MOST_WISH
    }

    /// Serves a page through its socket, until either ends.
    fn page(&self, stream: TcpStream);
}

/// Listens, and serves from a thread of its own until the program ends. Returns the address of the page.
///
/// # Errors
/// [`Failure::Device`] for an address that cannot be listened at.
pub(super) fn serve(address: SocketAddr, show: Arc<dyn Show>) -> Result<String, Failure> {
    let failed = |e: io::Error| {
        let way = match e.kind() {
            io::ErrorKind::AddrInUse => "; another program listens there, port 0 takes a free one",
            _ => "",
        };
        Failure::Device(format!("--serve {address}: {e}{way}"))
    };
    let listener = TcpListener::bind(address).map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let gate = Gate::at(address)?;
    let url = gate.url(address);
    let accept = move || {
        let connected = Arc::new(AtomicUsize::new(0));
        for stream in listener.incoming().flatten() {
            let (gate, show, connected) = (gate.clone(), Arc::clone(&show), Arc::clone(&connected));
            if connected.fetch_add(1, Ordering::Relaxed) >= MOST {
                connected.fetch_sub(1, Ordering::Relaxed);
                continue;
            }
            let held = Arc::clone(&connected);
            let page = move || {
                // A browser that went away, or is none, is its own matter.
                let _ = connection(stream, &gate, &*show);
                held.fetch_sub(1, Ordering::Relaxed);
            };
            if Builder::new().name("page".into()).spawn(page).is_err() {
                connected.fetch_sub(1, Ordering::Relaxed);
            }
        }
    };
    Builder::new()
        .name("pages".into())
        .spawn(accept)
        .map_err(failed)?;
    Ok(url)
}

fn connection(mut stream: TcpStream, gate: &Gate, show: &dyn Show) -> io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    stream.set_nodelay(true)?;
    let plain = "text/plain; charset=utf-8";
    let Some(request) = Request::read(&mut stream)? else {
        return answer(
            &mut stream,
            "400 Bad Request",
            plain,
            "expected a browser's GET",
        );
    };
    let admitted = match request.path.as_str() {
        "/live" => gate.admits_socket(&request),
        _ => gate.admits(&request),
    };
    if let Err(why) = admitted {
        return answer(&mut stream, "403 Forbidden", plain, why);
    }
    match (request.path.as_str(), &request.socket_key) {
        ("/live", Some(key)) => {
            switch(&mut stream, key)?;
            stream.set_read_timeout(None)?;
            show.page(stream);
            Ok(())
        }
        ("/live", None) => answer(
            &mut stream,
            "426 Upgrade Required",
            plain,
            "expected a WebSocket",
        ),
        (path, _) => match files::file(path, show.look()) {
            Some(file) => {
                let text = file.text(&request.host, show.look(), gate.wants_token());
                answer(&mut stream, "200 OK", file.media_type, &text)
            }
            None => answer(&mut stream, "404 Not Found", plain, "no such file"),
        },
    }
}

/// Speaks with a page until either ends. Reads on this thread, so that a STOP waits for nothing that is sent; another one
/// sends what `slot` has. `hear` says whether a text is a message of a page.
pub(super) fn converse(
    mut words: WebSocket<TcpStream>,
    slot: &Arc<Slot>,
    mut hear: impl FnMut(&str) -> bool,
) {
    let write = |out: TcpStream| {
        let (slot, mut out) = (Arc::clone(slot), socket(out, MOST_WISH));
        move || {
            while let Some(text) = slot.next() {
                if out.send(Message::text(&*text)).is_err() {
                    break;
                }
            }
            slot.close();
            // Wakes the reader.
            let _ = out.get_ref().shutdown(Shutdown::Both);
        }
    };
    let out = words.get_ref().try_clone();
    let writer = out.and_then(|out| Builder::new().name("page".into()).spawn(write(out)));
    while writer.is_ok() {
        match words.read() {
            Ok(Message::Text(text)) if hear(&text) => {}
            Ok(Message::Ping(_) | Message::Pong(_)) => {}
            Err(tungstenite::Error::Io(e)) if e.kind() == io::ErrorKind::Interrupted => {}
            _ => break,
        }
    }
    slot.close();
}

/// A socket over an agreed connection, for messages up to so many bytes.
pub(super) fn socket(stream: TcpStream, longest: usize) -> WebSocket<TcpStream> {
    let config = WebSocketConfig::default()
        .max_message_size(Some(longest))
        .max_frame_size(Some(longest));
    WebSocket::from_raw_socket(stream, Role::Server, Some(config))
}
