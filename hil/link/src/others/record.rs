//! `palpate-link record`: records messages as they cross the network, with their schemas.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use mcap::records::{MessageHeader, Metadata};
use mcap::{WriteOptions, Writer};
use palpate_buses::pacer::RunClock;
use palpate_buses::signals::Signals;
use palpate_core::units::Instant;
use palpate_live::output::note;
use palpate_records::mcap::full_name;
use palpate_run::Failure;

use crate::cli::{RecordArgs, after};
use crate::ends::Inbox;
use crate::message::{About, Echo, Scanned, Touched, Wearer, descriptor};
use crate::name::ROOT;
use crate::net::{self, Mode};

/// Messages that wait for the disk at most.
const MOST_WAITING: usize = 1 << 14;
/// Topics of a recording at most.
const MOST_TOPICS: usize = 4096;

/// A recording of any topics.
pub(super) struct Recording {
    writer: Writer<BufWriter<File>>,
    topics: BTreeMap<String, (u16, u32)>,
    path: String,
}

/// Failure to write a recording's file.
fn wrong(path: &str, error: &mcap::McapError) -> Failure {
    Failure::written(path)(std::io::Error::other(error.to_string()))
}

impl Recording {
    /// Begins a recording with these facts in it.
    pub(super) fn begin(
        path: &Path,
        force: bool,
        facts: BTreeMap<String, String>,
    ) -> Result<Self, Failure> {
        let name = path.display().to_string();
        if path.extension().is_none_or(|e| e != "mcap") {
            return Err(Failure::Input(format!(
                "{name}: expected a name that ends in .mcap"
            )));
        }
        if path.exists() && !force {
            return Err(Failure::Input(format!(
                "{name}: is there already; --force replaces it"
            )));
        }
        let file = File::create(path).map_err(Failure::written(path))?;
        let options = WriteOptions::new()
            .compression(None)
            .profile("palpate-link")
            .library(concat!("palpate-link ", env!("CARGO_PKG_VERSION")));
        let writer = options
            .create(BufWriter::new(file))
            .map_err(|e| wrong(&name, &e))?;
        let mut recording = Self {
            writer,
            topics: BTreeMap::new(),
            path: name,
        };
        let facts = Metadata {
            name: "palpate-link".into(),
            metadata: facts,
        };
        let written = recording.writer.write_metadata(&facts);
        written.map_err(|e| wrong(&recording.path, &e))?;
        Ok(recording)
    }

    /// A message of a topic; `schema` is its name and descriptor.
    pub(super) fn message(
        &mut self,
        topic: &str,
        (schema, descriptor): (&str, &[u8]),
        t_ns: u64,
        data: &[u8],
    ) -> Result<(), Failure> {
        let (writer, path) = (&mut self.writer, &self.path);
        let is_full = self.topics.len() >= MOST_TOPICS;
        let (channel_id, sequence) = match self.topics.get_mut(topic) {
            Some((channel, sequence)) => {
                *sequence = sequence.wrapping_add(1);
                (*channel, *sequence)
            }
            None if is_full => return Ok(()),
            None => {
                let schema = writer.add_schema(schema, "protobuf", descriptor);
                let schema = schema.map_err(|e| wrong(path, &e))?;
                let channel = writer.add_channel(schema, topic, "protobuf", &BTreeMap::new());
                let channel = channel.map_err(|e| wrong(path, &e))?;
                self.topics.insert(topic.into(), (channel, 0));
                (channel, 0)
            }
        };
        let head = MessageHeader {
            channel_id,
            sequence,
            log_time: t_ns,
            publish_time: t_ns,
        };
        writer
            .write_to_known_channel(&head, data)
            .map_err(|e| wrong(path, &e))
    }

    /// Ends the recording.
    pub(super) fn finish(mut self) -> Result<(), Failure> {
        let finished = self.writer.finish();
        finished.map(drop).map_err(|e| wrong(&self.path, &e))
    }
}

/// The schema's name of a key's messages.
fn schema_of(key: &str) -> Option<String> {
    let mut parts = key.split('/').skip(4);
    Some(match parts.next()? {
        "contacts" => full_name::<Touched>(),
        "scans" => full_name::<Scanned<'_>>(),
        "echo" => full_name::<Echo>(),
        "wearers" => full_name::<Wearer>(),
        "about" => full_name::<About>(),
        _ => return None,
    })
}

/// Runs it.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &RecordArgs) -> Result<(), Failure> {
    let signals = Signals::catch().map_err(|e| Failure::Device(e.to_string()))?;
    let facts = BTreeMap::from([(
        "clock".to_owned(),
        "this machine's, from the start".to_owned(),
    )]);
    let mut recording = Recording::begin(&args.file, args.force, facts)?;
    let net = net::open(&args.at.at(), Mode::Peer, &signals)?;
    let clock = RunClock::start();
    let waiting = Arc::new(Inbox::new(MOST_WAITING));
    let subscriber = {
        let waiting = Arc::clone(&waiting);
        net::subscribe(&net.session, format!("{ROOT}/**"), move |sample| {
            let at = clock.now();
            if let Some(bytes) = net::bytes(&sample) {
                let key = sample.key_expr().as_str().to_owned();
                waiting.push((at, key, bytes.into_owned()));
            }
        })?
    };
    let end = args.seconds.map_or(Instant::FAR_FUTURE, after);
    let mut messages = 0_u64;
    let all = descriptor();
    while signals.caught().is_none() && clock.now() < end {
        waiting.wait(Duration::from_millis(50));
        while let Some((at, key, bytes)) = waiting.take() {
            if let Some(schema) = schema_of(&key) {
                let t_ns = at.as_micros() * 1000;
                recording.message(&format!("/{key}"), (&schema, &all), t_ns, &bytes)?;
                messages += 1;
            }
        }
    }
    drop(subscriber);
    recording.finish()?;
    let lost = match waiting.overflowed() {
        0 => String::new(),
        n => format!(", {n} found no room"),
    };
    note(&format!(
        "{}: {messages} messages{lost}",
        args.file.display()
    ));
    Ok(())
}
