//! The part of HTTP that a page needs: the head of a request in, a file or a refusal out, or the way to a socket.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::handshake::derive_accept_key;

use crate::clock;

/// Longest head of a request, bytes, and most fields in it.
const MOST_HEAD: usize = 8192;
const MOST_FIELDS: usize = 64;

/// A connection that ends at a moment, however little comes or is taken at a time.
#[derive(Debug)]
pub(super) struct Brief<'a> {
    stream: &'a TcpStream,
    until: Instant,
}

impl<'a> Brief<'a> {
    /// A connection for so long from now on.
    pub(super) fn new(stream: &'a TcpStream, most: Duration) -> Self {
        let until = clock::now() + most;
        Self { stream, until }
    }

    fn left(&self) -> io::Result<Duration> {
        let left = self.until.saturating_duration_since(clock::now());
        match left.is_zero() {
            true => Err(io::ErrorKind::TimedOut.into()),
            false => Ok(left),
        }
    }
}

impl Read for Brief<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(Some(self.left()?))?;
        self.stream.read(into)
    }
}

impl Write for Brief<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(Some(self.left()?))?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

/// Head of a request.
#[derive(Debug, Default)]
pub(super) struct Request {
    pub(super) path: String,
    query: String,
    pub(super) host: String,
    pub(super) origin: String,
    /// The key of a handshake; none where no socket is wanted.
    pub(super) socket_key: Option<String>,
    /// Names of the protocols that the other side speaks, with commas between them.
    pub(super) protocols: String,
}

impl Request {
    /// Token that the request shows.
    pub(super) fn token(&self) -> Option<&str> {
        let mut pairs = self
            .query
            .split('&')
            .filter_map(|pair| pair.split_once('='));
        pairs
            .find(|(key, _)| *key == "token")
            .map(|(_, token)| token)
    }

    /// Reads the head of a request; `None` for text that is no request of a browser.
    pub(super) fn read(stream: &mut impl Read) -> io::Result<Option<Self>> {
        let (mut head, mut piece) = (Vec::new(), [0; 1024]);
        loop {
            let read = stream.read(&mut piece)?;
            head.extend_from_slice(&piece[..read]);
            let mut fields = [httparse::EMPTY_HEADER; MOST_FIELDS];
            let mut parsed = httparse::Request::new(&mut fields);
            match parsed.parse(&head) {
                Ok(status) if status.is_complete() => return Ok(Self::new(&parsed)),
                Ok(_) if read > 0 && head.len() < MOST_HEAD => {}
                _ => return Ok(None),
            }
        }
    }

    fn new(parsed: &httparse::Request<'_, '_>) -> Option<Self> {
        let field = |name: &str| {
            let mut same = parsed
                .headers
                .iter()
                .filter(|h| h.name.eq_ignore_ascii_case(name));
            let value = same
                .next()
                .map(|h| String::from_utf8_lossy(h.value).into_owned());
            // Of two fields with one name, nobody knows which one the browser meant.
            value.filter(|_| same.next().is_none())
        };
        if parsed.method != Some("GET") {
            return None;
        }
        let (path, query) = parsed.path?.split_once('?').unwrap_or((parsed.path?, ""));
        let upgrade = field("upgrade").is_some_and(|to| to.eq_ignore_ascii_case("websocket"));
        Some(Self {
            path: path.to_owned(),
            query: query.to_owned(),
            host: field("host").unwrap_or_default(),
            origin: field("origin").unwrap_or_default(),
            socket_key: field("sec-websocket-key").filter(|_| upgrade),
            protocols: field("sec-websocket-protocol").unwrap_or_default(),
        })
    }
}

/// Answers with a text; the connection ends with it.
pub(super) fn answer(
    stream: &mut impl Write,
    status: &str,
    media_type: &str,
    text: &str,
) -> io::Result<()> {
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {media_type}\r\nContent-Length: {}\r\nConnection: close\r\n\
         Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\n\
         X-Frame-Options: SAMEORIGIN\r\n\r\n{text}",
        text.len()
    )?;
    stream.flush()
}

/// Agrees to a socket, for a protocol where the other side asked for one.
pub(super) fn switch(stream: &mut impl Write, key: &str, protocol: Option<&str>) -> io::Result<()> {
    let accept = derive_accept_key(key.as_bytes());
    let protocol = protocol.map(|name| format!("Sec-WebSocket-Protocol: {name}\r\n"));
    let protocol = protocol.unwrap_or_default();
    write!(
        stream,
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {accept}\r\n{protocol}\r\n"
    )?;
    stream.flush()
}
