//! The server of a page: a thread that waits for browsers, and a thread for each of them.

use std::array;
use std::io;
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread::{Builder, park_timeout};
use std::time::Duration;

use palpate_run::Failure;
use tungstenite::Message;
use tungstenite::protocol::{Role, WebSocket};

use super::crowd::{Crowd, Leaves, Place};
use super::files::{self, Page};
use super::gate::Gate;
use super::http::{Brief, Request, answer, switch};
use super::post::{Mail, Post};

/// Time for a browser's request and for taking the answer, both together; time for each message of a page.
pub(super) const PATIENCE: Duration = Duration::from_secs(5);
/// Requests that are read or answered at once; a page that loads has ten at most.
const MOST_STRANGERS: usize = 64;
/// Pages at once.
const MOST_PAGES: usize = 64;
/// Pause after a connection that the system could not hand over, as where no descriptor is left.
const REST: Duration = Duration::from_millis(10);
/// Longest message of a page, bytes: a few words.
const MOST_WISH: usize = 4096;

/// Content that a server shows on its pages.
pub(super) trait Show: Send + Sync + 'static {
    /// Kind of session that the pages show.
    fn look(&self) -> Page;

    /// Serves a page through its socket, until either ends. `shown` is the number of the page whose token it has, none where
    /// pages need no token.
    fn page(&self, stream: TcpStream, shown: Option<usize>);
}

/// Listens, and serves pages of these paths from a thread of its own until the program ends. Returns their addresses, each
/// with a token of its own where one is needed.
///
/// # Errors
/// [`Failure::Device`] for an address that cannot be listened at.
pub(super) fn serve<const N: usize>(
    address: SocketAddr,
    paths: [&str; N],
    show: Arc<dyn Show>,
) -> Result<[String; N], Failure> {
    let (listener, address) = listen("--serve", address)?;
    let gate = Gate::at(address, N)?;
    let urls = array::from_fn(|page| gate.url(address, paths[page], page));
    let page = move |stream: TcpStream, place: Place, pages: &Arc<Crowd>| {
        connection(stream, place, pages, &gate, &*show)
    };
    attend(listener, page).map_err(|e| Failure::Device(format!("--serve {address}: {e}")))?;
    Ok(urls)
}

/// Listens at an address, for the option `flag`; port 0 takes a free one. Returns the address with its port.
///
/// # Errors
/// [`Failure::Device`] for an address that cannot be listened at.
pub(super) fn listen(
    flag: &str,
    address: SocketAddr,
) -> Result<(TcpListener, SocketAddr), Failure> {
    let failed = |e: io::Error| {
        let way = match e.kind() {
            io::ErrorKind::AddrInUse => "; another program listens there, port 0 takes a free one",
            io::ErrorKind::AddrNotAvailable => "; this computer has no such address",
            io::ErrorKind::PermissionDenied => "; ports below 1024 are for root",
            _ => "",
        };
        Failure::Device(format!("{flag} {address}: {e}{way}"))
    };
    let listener = TcpListener::bind(address).map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    Ok((listener, address))
}

/// Hands every connection to `answer`, on a thread of its own, until the program ends. A connection begins as a stranger with
/// a place; the crowd that `answer` gets is for those it takes in.
///
/// # Errors
/// Error of the system that gives no thread.
pub(super) fn attend(
    listener: TcpListener,
    answer: impl Fn(TcpStream, Place, &Arc<Crowd>) -> io::Result<()> + Send + Sync + 'static,
) -> io::Result<()> {
    let answer = Arc::new(answer);
    let accept = move || {
        let strangers = Crowd::new(MOST_STRANGERS, Leaves::First);
        let pages = Crowd::new(MOST_PAGES, Leaves::Last);
        for stream in listener.incoming() {
            let Ok(stream) = stream else {
                park_timeout(REST);
                continue;
            };
            let Ok(place) = strangers.enter(&stream) else {
                continue;
            };
            let (answer, pages) = (Arc::clone(&answer), Arc::clone(&pages));
            let page = move || {
                // A browser that went away, or is none, is its own matter.
                let _ = answer(stream, place, &pages);
            };
            // Without a thread the connection ends here.
            let _ = Builder::new().name("page".into()).spawn(page);
        }
    };
    Builder::new().name("pages".into()).spawn(accept).map(drop)
}

/// Reads a request and answers it, as a stranger. A stranger who asks for a socket and may have it becomes a page.
fn connection(
    stream: TcpStream,
    place: Place,
    pages: &Arc<Crowd>,
    gate: &Gate,
    show: &dyn Show,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    let mut brief = Brief::new(&stream, PATIENCE);
    let plain = "text/plain; charset=utf-8";
    let Some(request) = Request::read(&mut brief)? else {
        let expected = "expected a browser's GET";
        return answer(&mut brief, "400 Bad Request", plain, expected);
    };
    let admitted = match request.path.as_str() {
        "/live" => gate.admits_socket(&request),
        _ => gate.admits(&request).map(|()| None),
    };
    let shown = match admitted {
        Ok(shown) => shown,
        Err(why) => return answer(&mut brief, "403 Forbidden", plain, why),
    };
    match (request.path.as_str(), &request.socket_key) {
        ("/live", Some(key)) => {
            let _page = pages.enter(&stream)?;
            drop(place);
            switch(&mut brief, key, None)?;
            stream.set_read_timeout(None)?;
            stream.set_write_timeout(Some(PATIENCE))?;
            show.page(stream, shown);
            Ok(())
        }
        ("/live", None) => answer(
            &mut brief,
            "426 Upgrade Required",
            plain,
            "expected a WebSocket",
        ),
        (path, _) => match files::file(path, show.look()) {
            Some(file) => {
                let text = file.text(&request.host, show.look(), gate.wants_token());
                answer(&mut brief, "200 OK", file.media_type, &text)
            }
            None => answer(&mut brief, "404 Not Found", plain, "no such file"),
        },
    }
}

/// Speaks with a page until either ends. Reads on this thread, so that a STOP never waits for anything to be sent;
/// another thread sends the messages of `mail`. `hear` returns whether a text is a message of a page.
pub(super) fn converse<M: Mail>(
    mut words: WebSocket<TcpStream>,
    mail: &Arc<Post<M>>,
    mut hear: impl FnMut(&str) -> bool,
) {
    let write = |out: TcpStream| {
        let (mail, mut out) = (Arc::clone(mail), socket(out));
        move || {
            while let Some(message) = mail.take() {
                if out.send(message).is_err() {
                    break;
                }
            }
            mail.close();
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
    mail.close();
}

/// A socket over an agreed connection, for messages of a few words.
pub(super) fn socket(stream: TcpStream) -> WebSocket<TcpStream> {
    let mut socket = WebSocket::from_raw_socket(stream, Role::Server, None);
    widen(&mut socket, MOST_WISH);
    socket
}

/// Sets the longest message of a page, bytes.
pub(super) fn widen(socket: &mut WebSocket<TcpStream>, longest: usize) {
    socket.set_config(|config| {
        config.max_message_size = Some(longest);
        config.max_frame_size = Some(longest);
    });
}
