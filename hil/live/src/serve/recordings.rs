//! Recordings in pages, one or two beside each other: every page is shown the moment that it asks for.
//!
//! A page sends `{"run": N}` once, and gets the head of that recording in a `hello`. From then on each `{"at_us": T}`
//! is answered by one `moment`, or by `failed` with a sentence. A page that asks again before it has its answer waits:
//! there is no queue but the socket.

use std::ffi::OsStr;
use std::fs::{File, OpenOptions, remove_file};
use std::io::{self, BufReader, Read};
use std::net::{SocketAddr, TcpStream};
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::PathBuf;
use std::sync::Arc;

use palpate_files::{Unpacked, open};
use palpate_run::Failure;
use palpate_run::recorded::{Player, Recorded};
use serde::Deserialize;
use serde_json::{Value, json};
use tungstenite::Message;

use super::files::Page;
use super::server::{self, Show, socket};
use crate::progress::Progress;

/// Recordings that pages are shown.
#[derive(Clone, Debug)]
pub struct Recordings {
    runs: Arc<Runs>,
}

#[derive(Debug)]
struct Runs {
    /// Number of the server: a page that comes back drops recordings of another one.
    number: u64,
    runs: Vec<Recording>,
}

/// A recording that is shown.
#[derive(Debug)]
struct Recording {
    name: String,
    file: Arc<File>,
    recorded: Arc<Recorded>,
}

/// Message that a page sends.
#[derive(Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Said {
    run: Option<usize>,
    at_us: Option<u64>,
}

/// A file from some byte on. Each reader has a place of its own in it.
#[derive(Debug)]
struct From {
    file: Arc<File>,
    at: u64,
}

impl Read for From {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read_at(into, self.at)?;
        self.at += read as u64;
        Ok(read)
    }
}

/// All that a reader gives, as a file without a name, which ends with the program.
fn laid_out(input: &mut impl Read) -> Result<File, Failure> {
    let number = u64::from_le_bytes(crate::link::key::random()?);
    let path = std::env::temp_dir().join(format!("palpate-{number:016x}.mcap"));
    let unwritten = |error| Failure::Write {
        path: path.display().to_string(),
        error,
    };
    let mut options = OpenOptions::new();
    let options = options.read(true).write(true).create_new(true).mode(0o600);
    let mut file = options.open(&path).map_err(unwritten)?;
    remove_file(&path).map_err(unwritten)?;
    io::copy(input, &mut file).map_err(unwritten)?;
    Ok(file)
}

impl Recordings {
    /// Reads recordings through, once.
    ///
    /// # Errors
    /// [`Failure::File`] for one that is not there or is no recording of a run.
    pub fn read(paths: &[PathBuf]) -> Result<Self, Failure> {
        let number = u64::from_le_bytes(crate::link::key::random()?);
        // Folders tell two files of one name apart.
        let alone = |name: &OsStr| {
            let same = paths.iter().filter(|path| path.file_name() == Some(name));
            same.count() == 1
        };
        let runs = paths.iter().map(|path| {
            let label = path.display().to_string();
            let file = Arc::new(open(path, "a recording of a run (.mcap)")?);
            let _shown = Progress::reading(path);
            let from_start = |file: &Arc<File>| {
                Unpacked::new(From {
                    file: Arc::clone(file),
                    at: 0,
                })
            };
            let mut whole = from_start(&file);
            let recorded = Arc::new(Recorded::read(&label, BufReader::new(&mut whole))?);
            // Moments are found by their places, which packed chunks do not have.
            let file = match whole.has_unpacked() {
                true => Arc::new(laid_out(&mut from_start(&file))?),
                false => file,
            };
            let own = path.file_name().filter(|own| alone(own));
            let name = own.map_or(label, |own| own.to_string_lossy().into_owned());
            Ok(Recording {
                name,
                file,
                recorded,
            })
        });
        let runs = runs.collect::<Result<_, Failure>>()?;
        let runs = Arc::new(Runs { number, runs });
        Ok(Self { runs })
    }

    /// Damage of the files, a sentence each.
    #[must_use]
    pub fn damages(&self) -> Vec<String> {
        let damaged = self.runs.runs.iter();
        let damaged = damaged.filter(|run| !run.recorded.damages().is_empty());
        let said = damaged.map(|run| format!("{}: {}", run.name, run.damaged()));
        said.collect()
    }

    /// Listens at an address, port 0 takes a free one, and returns the page's, with a token if it needs one.
    ///
    /// # Errors
    /// [`Failure::Device`] where that is not possible.
    pub fn serve(&self, address: SocketAddr) -> Result<String, Failure> {
        let [url] = server::serve(address, [""], Arc::clone(&self.runs) as _)?;
        Ok(url)
    }
}

impl Recording {
    /// Damage of the file, and the time until which it is shown.
    fn damaged(&self) -> String {
        let few: Vec<&str> = self
            .recorded
            .damages()
            .iter()
            .map(String::as_str)
            .take(4)
            .collect();
        let until_s = self.recorded.end_us() as f64 * 1e-6;
        format!("{}; shown until {until_s:.3} s", few.join("; "))
    }
}

impl Runs {
    fn hello(&self, shown: usize, run: &Recording) -> Value {
        let of = self.runs.iter().map(|run| {
            json!({ "file": run.name, "end_us": run.recorded.end_us(), "scene": run.recorded.head().scene })
        });
        let recording = json!({
            "shown": shown,
            "of": of.collect::<Vec<_>>(),
            "damaged": (!run.recorded.damages().is_empty()).then(|| run.damaged()),
            "lacks": run.recorded.lacks(),
        });
        json!({ "hello": {
            "run": self.number.to_string(),
            "heads": [run.recorded.head()],
            "end_us": run.recorded.end_us(),
            "recording": recording,
        } })
    }
}

impl Show for Runs {
    fn look(&self) -> Page {
        Page::Recording
    }

    fn page(&self, stream: TcpStream, _shown: Option<usize>) {
        let mut page = socket(stream);
        let mut player = None;
        loop {
            let text = match page.read() {
                Ok(Message::Text(text)) => text,
                Ok(Message::Ping(_) | Message::Pong(_)) => continue,
                _ => return,
            };
            // A text that is no message of a page ends its socket and nothing else.
            let Ok(said) = serde_json::from_str::<Said>(&text) else {
                return;
            };
            if let Some(number) = said.run {
                let Some(run) = self.runs.get(number) else {
                    return;
                };
                let file = Arc::clone(&run.file);
                let from = move |at| {
                    let file = Arc::clone(&file);
                    BufReader::new(From { file, at })
                };
                player = Some(Player::new(Arc::clone(&run.recorded), from));
                let hello = self.hello(number, run).to_string();
                if page.send(Message::text(hello)).is_err() {
                    return;
                }
            }
            if let (Some(at_us), Some(player)) = (said.at_us, &mut player) {
                let answer = match player.show(at_us) {
                    Ok(moment) => json!({ "moment": moment }),
                    Err(failure) => json!({ "failed": failure.to_string() }),
                };
                if page.send(Message::text(answer.to_string())).is_err() {
                    return;
                }
            }
        }
    }
}
