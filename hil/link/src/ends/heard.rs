//! What a wearer's machine hears of a finger, and where it speaks: subscriptions that hand on to the loop.

use std::sync::Arc;

use palpate_buses::pacer::RunClock;
use palpate_core::units::Instant;
use palpate_run::Failure;
use zenoh::Wait as _;
use zenoh::pubsub::Subscriber;
use zenoh::sample::Sample;

use super::inbox::Inbox;
use super::voice::Voice;
use crate::cli::DisplayArgs;
use crate::message::{self, MOST_BYTES};
use crate::name::{FingerName, Name};
use crate::net::{self, Net};
use crate::records::failed;

/// What arrives.
pub(super) enum Arrived {
    Touched(Vec<u8>),
    Scanned(Vec<u8>),
    Echo(Vec<u8>),
    About(Vec<u8>),
    /// More bytes than any message has, which were not copied.
    Oversized,
}

/// With its time of arrival.
pub(super) type Waiting = Arc<Inbox<(Instant, Arrived)>>;

/// What is subscribed to, and where the wearer speaks.
pub(super) struct Heard {
    pub(super) voice: Voice,
    _again: Option<Net>,
    _frames: Vec<Subscriber<()>>,
    _token: zenoh::liveliness::LivelinessToken,
    _may: Option<zenoh::query::Queryable<()>>,
}

impl Heard {
    /// Subscribes to a finger over one session or two, and lets the wearer be known.
    pub(super) fn begin(
        (net, again): (&Net, Option<Net>),
        (args, wearer): (&DisplayArgs, &Name),
        clock: RunClock,
        waiting: &Waiting,
    ) -> Result<Self, Failure> {
        let zenoh = |e: zenoh::Error| Failure::Device(format!("zenoh: {e}"));
        let finger = &args.finger;
        let subscribe = |net: &Net, key: String, of: fn(Vec<u8>) -> Arrived| {
            let waiting = Arc::clone(waiting);
            let take = move |sample: Sample| {
                let at = clock.now();
                // Before it is looked at, and before it is copied.
                let arrived = match sample.payload().len() {
                    0..=MOST_BYTES => of(sample.payload().to_bytes().into_owned()),
                    _ => Arrived::Oversized,
                };
                waiting.push((at, arrived));
            };
            let subscriber = net.session.declare_subscriber(key);
            subscriber.callback(take).wait().map_err(zenoh)
        };
        let mut frames = vec![
            subscribe(net, finger.contacts(), Arrived::Touched)?,
            subscribe(net, finger.scans(), Arrived::Scanned)?,
            subscribe(net, finger.echo(wearer), Arrived::Echo)?,
        ];
        // The gate takes whichever comes first.
        if let Some(net) = &again {
            let (contacts, scans) = (finger.contacts(), finger.scans());
            frames.push(subscribe(
                net,
                FingerName::again(&contacts),
                Arrived::Touched,
            )?);
            frames.push(subscribe(net, FingerName::again(&scans), Arrived::Scanned)?);
        }
        let token = net
            .session
            .liveliness()
            .declare_token(finger.wearer_alive(wearer));
        let name = message::encoding(message::WEARER.name);
        let publisher = net::frames(&net.session, finger.wearer(wearer.as_str()), &name);
        let answered = {
            let waiting = Arc::clone(waiting);
            move |bytes| waiting.push((clock.now(), Arrived::About(bytes)))
        };
        let session = net.session.clone();
        let voice = Voice::begin(
            session,
            publisher.map_err(failed)?,
            finger.about(),
            answered,
        )?;
        Ok(Self {
            voice,
            _again: again,
            _frames: frames,
            _token: token.wait().map_err(zenoh)?,
            _may: net
                .answer_who_may_publish(wearer.as_str())
                .map_err(failed)?,
        })
    }
}
