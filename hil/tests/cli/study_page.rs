//! A page of a study's session, as a test holds it.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::net::TcpStream;
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Error, Message, WebSocket, client};

/// How long a server may take to answer.
const PATIENCE: Duration = Duration::from_secs(20);
/// A page that is told nothing says so often that it is there.
const ALIVE: Duration = Duration::from_millis(500);
/// Looks for something that is to be shown.
const LOOKS: usize = 120;

/// One person's page.
pub struct Page(WebSocket<TcpStream>);

impl Page {
    /// Opens it at `ADDRESS:PORT`, with the query of its socket.
    pub fn open(host: &str, query: &str, who: &str) -> Self {
        let mut request = format!("ws://{host}/live{query}")
            .into_client_request()
            .unwrap();
        let origin = format!("http://{host}").parse().unwrap();
        request.headers_mut().insert("Origin", origin);
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let (socket, _) = client(request, stream).unwrap();
        socket.get_ref().set_read_timeout(Some(ALIVE)).unwrap();
        let mut page = Self(socket);
        page.say(&json!({ "who": who }));
        page
    }

    /// Says something, if the server still listens.
    pub fn say(&mut self, words: &Value) {
        let _ = self.0.send(Message::text(words.to_string()));
    }

    /// What it shows next, with its number; none where the server has closed it.
    pub fn next(&mut self) -> Option<(u64, Value)> {
        for _ in 0..LOOKS {
            let read = self.0.read();
            self.say(&json!({ "alive": true }));
            match read {
                Ok(Message::Text(text)) => {
                    let told: Value = serde_json::from_str(&text).unwrap();
                    return Some((told["view"].as_u64().unwrap(), told["shows"].clone()));
                }
                Err(Error::Io(e)) if e.kind() == ErrorKind::WouldBlock => {}
                Ok(Message::Close(_)) | Err(_) => return None,
                Ok(_) => {}
            }
        }
        panic!("the page is shown nothing");
    }

    /// Waits for a screen; its number.
    pub fn on(&mut self, screen: &str) -> u64 {
        loop {
            let next = self.next();
            let (view, shows) = next.unwrap_or_else(|| panic!("it was closed before `{screen}`"));
            if shows["screen"] == screen {
                return view;
            }
        }
    }

    /// Waits for the limits that an experimenter's page shows: the share of each that is used.
    pub fn limits(&mut self) -> BTreeMap<String, f64> {
        loop {
            let (_, shows) = self.next().unwrap();
            if let Some(rows) = shows["rows"].as_array() {
                let row = |row: &Value| (row[0].as_str().unwrap().into(), row[1].as_f64().unwrap());
                return rows.iter().map(row).collect();
            }
        }
    }
}
