//! Answers of a publisher: echoes to wearers, facts about itself, and notes about those who feel it.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use palpate_buses::pacer::RunClock;
use palpate_records::mcap::{decode, encoded};
use palpate_run::Failure;
use zenoh::Wait as _;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Subscriber;
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{Query, Queryable};
use zenoh::sample::Sample;

use crate::message::{self, About, Echo, VERSION, Wearer};
use crate::name::{FingerName, Name};
use crate::net::{self, Net, NetError, zenoh};

/// Wearers of a finger that are known at a time.
const MOST_WEARERS: usize = 64;
/// Payload with which a publisher that comes second asks the first for its facts.
pub(super) const SECOND: &[u8] = b"second";
/// Time after which a wearer who sends nothing is gone.
const LEASE_US: u64 = 1_000_000;

/// A wearer as its messages show it.
#[derive(Debug, Default)]
pub(super) struct WearerState {
    heard_us: u64,
    feels: bool,
    refuses: bool,
    stopped: String,
    trouble: String,
}

/// Everyone who feels this finger, and the news about them.
#[derive(Debug, Default)]
pub(super) struct Wearers {
    pub(super) known: BTreeMap<String, WearerState>,
    pub(super) news: Vec<String>,
    pub(super) stops: Vec<String>,
    pub(super) refused_by: Vec<String>,
    /// `true` once a publisher that came second and went was told of.
    second: bool,
}

impl Wearers {
    /// Takes a wearer's message.
    fn hear(&mut self, name: &str, said: &Wearer, own: u64, now_us: u64) {
        if !self.known.contains_key(name) {
            if self.known.len() >= MOST_WEARERS {
                return;
            }
            self.news.push(format!("wearer {name} is there"));
        }
        let known = self.known.entry(name.to_owned()).or_default();
        known.heard_us = now_us;
        let feels = said.feels == own;
        if feels != known.feels {
            let how = if feels {
                "feels this finger"
            } else {
                "feels this finger no more"
            };
            self.news.push(format!("wearer {name} {how}"));
            known.feels = feels;
        }
        if said.stopped != known.stopped {
            if !said.stopped.is_empty() {
                self.stops.push(format!("{name}: {}", said.stopped));
                self.news
                    .push(format!("STOP of wearer {name}: {}", said.stopped));
            }
            known.stopped.clone_from(&said.stopped);
        }
        if said.trouble != known.trouble {
            if !said.trouble.is_empty() {
                self.news
                    .push(format!("wearer {name} feels nothing: {}", said.trouble));
            }
            known.trouble.clone_from(&said.trouble);
        }
        if said.refused.contains(&own) {
            self.refused_by.push(name.to_owned());
        }
        if feels && !said.refused.is_empty() {
            let text = format!("a second publisher of this finger was refused by wearer {name}");
            if !known.refuses {
                self.news.push(text);
            }
            known.refuses = true;
        }
    }

    /// Takes note that another publisher of this finger came and went, because this one is here.
    fn second(&mut self) {
        if !std::mem::replace(&mut self.second, true) {
            self.news
                .push("a second publisher of this finger was refused".into());
        }
    }

    /// Forgets wearers who send nothing any more.
    pub(super) fn look(&mut self, now_us: u64) {
        let gone = |k: &WearerState| now_us.saturating_sub(k.heard_us) > LEASE_US;
        let news = &mut self.news;
        self.known.retain(|name, known| {
            if gone(known) {
                news.push(format!("nothing comes from wearer {name}"));
            }
            !gone(known)
        });
    }
}

/// Subscriptions that answer others while a skin is published.
pub(super) struct Answers {
    pub(super) wearers: Arc<Mutex<Wearers>>,
    pub(super) about: Arc<Mutex<About>>,
    _heard: Subscriber<()>,
    _told: Queryable<()>,
    _token: LivelinessToken,
}

impl Answers {
    pub(super) fn begin(
        net: &Net,
        finger: &FingerName,
        clock: RunClock,
        about: About,
    ) -> Result<Self, Failure> {
        let session = about.session;
        let (about, wearers) = (Arc::new(Mutex::new(about)), Arc::default());
        let alive = finger.skin_alive(&format!("{session:016x}"));
        Ok(Self {
            _heard: hear(net, finger, (clock, session), Arc::clone(&wearers))?,
            _told: tell(net, finger, Arc::clone(&about), Arc::clone(&wearers))?,
            _token: (net.session.liveliness().declare_token(alive))
                .wait()
                .map_err(zenoh)?,
            about,
            wearers,
        })
    }
}

/// Echoes messages of wearers at once: by this they know how old readings can be.
fn hear(
    net: &Net,
    finger: &FingerName,
    (clock, session): (RunClock, u64),
    wearers: Arc<Mutex<Wearers>>,
) -> Result<Subscriber<()>, NetError> {
    let (of, own) = (net.session.clone(), finger.clone());
    let heard = move |sample: Sample| {
        let heard_us = clock.now().as_micros();
        let Some((name, said)) = said(&sample) else {
            return;
        };
        let mut echo = Echo {
            version: VERSION,
            session,
            wearer: said.session,
            said_us: said.said_us,
            heard_us,
        };
        // An echo that is lost is followed by the next.
        let _ = of
            .put(own.echo(&name), encoded(&mut echo).bytes())
            .encoding(message::encoding::<Echo>())
            .congestion_control(CongestionControl::Drop)
            .priority(Priority::RealTime)
            .express(true)
            .wait();
        let mut wearers = wearers.lock().unwrap_or_else(PoisonError::into_inner);
        wearers.hear(name.as_str(), &said, session, heard_us);
    };
    net::subscribe(&net.session, finger.wearer("*"), heard)
}

/// Answers questions about the publisher.
fn tell(
    net: &Net,
    finger: &FingerName,
    about: Arc<Mutex<About>>,
    wearers: Arc<Mutex<Wearers>>,
) -> Result<Queryable<()>, NetError> {
    let key = finger.about();
    let tell = move |query: Query| {
        if query
            .payload()
            .is_some_and(|said| said.to_bytes() == SECOND)
        {
            let mut wearers = wearers.lock().unwrap_or_else(PoisonError::into_inner);
            wearers.second();
        }
        let mut about = about.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes = encoded(&mut *about);
        drop(about);
        // An asker without an answer asks again.
        let _ = query.reply(key.clone(), bytes.bytes()).wait();
    };
    let queryable = net.session.declare_queryable(finger.about());
    queryable.callback(tell).wait().map_err(zenoh)
}

/// Sender and message of a sample; `None` for one that is no message of a wearer.
fn said(sample: &Sample) -> Option<(Name, Wearer)> {
    let bytes = net::bytes(sample)?;
    let name = sample.key_expr().as_str().rsplit('/').next()?;
    Some((name.parse().ok()?, decode(&bytes)?))
}
