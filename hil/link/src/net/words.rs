//! Messages of zenoh in the words of this program: each kind of trouble once in a while, on standard error.

use std::collections::BTreeMap;
use std::fmt::{self, Write as _};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Level, Metadata, Subscriber};

/// Shortest time between two tellings of the same trouble.
const ONCE_IN: Duration = Duration::from_secs(5);

/// Troubles that are remembered.
const MOST: usize = 64;

/// Words of zenoh about a peer, and their meaning here.
const MEANINGS: [(&str, &str); 7] = [
    (
        "UnknownIssuer",
        "a certificate of another lab was refused: all machines need keys of one `palpate-link keys`",
    ),
    (
        "UnknownCA",
        "the other machine refused our certificate: it has keys of another lab",
    ),
    (
        "BadSignature",
        "a certificate of another lab was refused: all machines need keys of one `palpate-link keys`",
    ),
    (
        "DecryptError",
        "the other machine refused our certificate: it has keys of another lab",
    ),
    (
        "xpired",
        "a certificate has expired: make another with `palpate-link keys`",
    ),
    (
        "NoCertificatesPresented",
        "a stranger without a certificate was refused",
    ),
    (
        "InvalidContentType",
        "plain text met TLS: one machine has --keys, the other has none",
    ),
];

#[derive(Debug, Default)]
struct Words(Mutex<BTreeMap<String, Instant>>);

#[derive(Default)]
struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn fmt::Debug) {
        if field.name() == "message" {
            // Writing to a string cannot fail.
            let _ = write!(self.0, "{value:?}");
        }
    }
}

/// Words for a message of zenoh; `None` for one that is no trouble.
pub(super) fn told(level: Level, text: &str) -> Option<String> {
    let meaning = MEANINGS.iter().find(|(word, _)| text.contains(word));
    if let Some((_, meaning)) = meaning {
        return Some((*meaning).into());
    }
    (level == Level::ERROR).then(|| format!("zenoh: {text}"))
}

impl Words {
    #[allow(clippy::disallowed_methods)] // how often to say something, and nothing else
    fn is_news(&self, text: &str) -> bool {
        let now = Instant::now();
        let mut said = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if said.get(text).is_some_and(|at| now - *at < ONCE_IN) {
            return false;
        }
        if said.len() >= MOST {
            said.clear();
        }
        said.insert(text.to_owned(), now);
        true
    }
}

impl Subscriber for Words {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target().starts_with("zenoh")
            && *metadata.level() <= Level::DEBUG
            && (*metadata.level() <= Level::WARN || metadata.target().starts_with("zenoh_link_tls"))
    }

    fn event(&self, event: &Event<'_>) {
        let mut text = Text::default();
        event.record(&mut text);
        if let Some(text) = told(*event.metadata().level(), &text.0)
            && self.is_news(&text)
        {
            eprintln!("palpate-link: {text}");
        }
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }
    fn record(&self, _: &Id, _: &Record<'_>) {}
    fn record_follows_from(&self, _: &Id, _: &Id) {}
    fn enter(&self, _: &Id) {}
    fn exit(&self, _: &Id) {}
}

/// Tells zenoh's troubles from now on.
pub(super) fn begin() {
    // A program that has set another one keeps it.
    let _ = tracing::subscriber::set_global_default(Words::default());
}
