//! Subscriptions of a wearer's machine, which hand messages of a finger on to the loop, and the wearer's voice.

use std::sync::Arc;

use palpate_buses::pacer::RunClock;
use palpate_core::units::Instant;
use palpate_run::Failure;
use zenoh::pubsub::Subscriber;
use zenoh::{Session, Wait as _};

use super::inbox::Inbox;
use super::shrunk::{Rest, Shrunk};
use super::voice::Voice;
use crate::cli::DisplayArgs;
use crate::message::{self, Wearer};
use crate::name::{FingerName, Name};
use crate::net::{self, Net, zenoh};

/// Message that arrives.
pub(super) enum Arrived {
    Touched(Vec<u8>),
    Scanned(Vec<u8>),
    Echo(Vec<u8>),
    /// Compression of a publisher of scans, with the publisher's session.
    Reference(u64, Box<Shrunk>),
    /// A message with more bytes than any has, which were not copied.
    Oversized,
}

/// Messages that wait for the loop, each with its time of arrival.
pub(super) type Waiting = Arc<Inbox<(Instant, Arrived)>>;

/// Subscriptions of a wearer, and its voice.
pub(super) struct Heard {
    pub(super) voice: Voice,
    _again: Option<Session>,
    _frames: Vec<Subscriber<()>>,
    _token: zenoh::liveliness::LivelinessToken,
    _may: Option<zenoh::query::Queryable<()>>,
}

impl Heard {
    /// Subscribes to a finger over one session or two, and lets the wearer be known.
    pub(super) fn begin(
        (net, again): (&Net, Option<Session>),
        (args, wearer): (&DisplayArgs, &Name),
        (clock, rest): (RunClock, Rest),
        waiting: &Waiting,
    ) -> Result<Self, Failure> {
        let finger = &args.finger;
        let subscribe = |session: &Session, key: String, of: fn(Vec<u8>) -> Arrived| {
            let waiting = Arc::clone(waiting);
            net::subscribe(session, key, move |sample| {
                // The time is taken before the message is looked at or copied.
                let at = clock.now();
                let arrived = net::bytes(&sample).map(|bytes| of(bytes.into_owned()));
                waiting.push((at, arrived.unwrap_or(Arrived::Oversized)));
            })
        };
        let (contacts, scans) = (finger.contacts(), finger.scans());
        let own = &net.session;
        let mut frames = vec![
            subscribe(own, contacts.clone(), Arrived::Touched)?,
            subscribe(own, scans.clone(), Arrived::Scanned)?,
            subscribe(own, finger.echo(wearer), Arrived::Echo)?,
        ];
        // The gate takes whichever comes first. The end that connects has the second connection, and a relay has one of both.
        let is_direct = again.is_some() && args.at.relay.is_none();
        let second = again.as_ref().unwrap_or(own);
        for (key, of) in [
            (contacts, Arrived::Touched as fn(Vec<u8>) -> Arrived),
            (scans, Arrived::Scanned),
        ] {
            let key = if is_direct {
                key
            } else {
                FingerName::again(&key)
            };
            frames.push(subscribe(second, key, of)?);
        }
        let token = net
            .session
            .liveliness()
            .declare_token(finger.wearer_alive(wearer));
        let name = message::encoding::<Wearer>();
        let publisher = net::frames(&net.session, finger.wearer(wearer.as_str()), &name);
        let answered = {
            let waiting = Arc::clone(waiting);
            // The work is done here, where it may take its time, and not in the loop.
            move |bytes: Vec<u8>| {
                if let Some((owner, shrunk)) = rest.compress(&bytes) {
                    let reference = Arrived::Reference(owner, Box::new(shrunk));
                    waiting.push((clock.now(), reference));
                }
            }
        };
        let session = net.session.clone();
        let voice = Voice::begin(session, publisher?, finger.about(), answered)?;
        Ok(Self {
            voice,
            _again: again,
            _frames: frames,
            _token: token.wait().map_err(zenoh)?,
            _may: net.answer_who_may_publish(wearer.as_str())?,
        })
    }
}
