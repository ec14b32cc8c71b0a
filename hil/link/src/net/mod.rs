//! The network: a session of zenoh with settings that suit a wearer, rights to speak, certificates.

mod access;
mod certificates;
mod open;
mod words;

pub use access::{Access, Member};
pub use certificates::{Lab, LabError};
pub(crate) use open::zenoh;
pub use open::{At, Mode, Net, NetError, open, open_beside};

use std::borrow::Cow;

use palpate_run::Failure;
use zenoh::bytes::Encoding;
use zenoh::handlers::FifoChannelHandler;
use zenoh::pubsub::{Publisher, Subscriber};
use zenoh::qos::{CongestionControl, Priority};
use zenoh::query::{Query, Queryable, Reply};
use zenoh::sample::Sample;
use zenoh::{Session, Wait};

use crate::message::MOST_BYTES;
use crate::name::{Name, ROOT};

/// A publisher of frames: a frame that cannot be sent at once is dropped, and none waits to fill a packet.
///
/// # Errors
/// [`NetError`] where zenoh refuses.
pub fn frames(
    session: &Session,
    key: String,
    encoding: &str,
) -> Result<Publisher<'static>, NetError> {
    session
        .declare_publisher(key)
        .encoding(Encoding::from(encoding))
        .congestion_control(CongestionControl::Drop)
        .priority(Priority::RealTime)
        .express(true)
        .wait()
        .map_err(zenoh)
}

/// Hands every message of a key on, as it comes.
///
/// # Errors
/// [`NetError`] where zenoh refuses.
pub fn subscribe(
    session: &Session,
    key: String,
    hear: impl Fn(Sample) + Send + Sync + 'static,
) -> Result<Subscriber<()>, NetError> {
    let subscriber = session.declare_subscriber(key).callback(hear);
    subscriber.wait().map_err(zenoh)
}

/// Samples of a query's answers, as they come.
pub fn samples(answers: FifoChannelHandler<Reply>) -> impl Iterator<Item = Sample> {
    let replies = std::iter::from_fn(move || answers.recv().ok());
    replies.filter_map(|reply| reply.into_result().ok())
}

/// The bytes of a message. `None` for more than any message of this program has: they are neither looked at nor copied.
#[must_use]
pub fn bytes(sample: &Sample) -> Option<Cow<'_, [u8]>> {
    let payload = sample.payload();
    (payload.len() <= MOST_BYTES).then(|| payload.to_bytes())
}

impl Net {
    /// Name of a wearer: a certificate's name is the one that the access list knows.
    ///
    /// # Errors
    /// [`Failure::Input`] for a certificate's name that no wearer can have.
    pub fn wearer(&self, given: &Name) -> Result<Name, Failure> {
        let name = self.name.as_ref();
        let name = name.map_or(Ok(given.clone()), |name| name.parse());
        name.map_err(|e| Failure::Input(format!("the certificate's name: {e}")))
    }

    /// Answers questions whether a machine may publish a finger, where there is an access list: zenoh drops in
    /// silence everything that it forbids.
    ///
    /// # Errors
    /// [`NetError`] where zenoh refuses.
    pub fn answer_who_may_publish(&self, own: &str) -> Result<Option<Queryable<()>>, NetError> {
        let Some(access) = self.access.clone() else {
            return Ok(None);
        };
        let own = own.to_owned();
        let root = format!("{ROOT}/may/");
        let answer = move |query: Query| {
            let key = query.key_expr().as_str().to_owned();
            let asks = query.payload().filter(|p| p.len() <= 64);
            let name = asks.and_then(|p| p.try_to_string().ok().map(|n| n.into_owned()));
            let (Some(finger), Some(name)) = (key.strip_prefix(&root), name) else {
                return;
            };
            let word = match access.may_publish(&name, finger) {
                true => "yes",
                false => "no",
            };
            // A machine without an answer is refused in silence, as before.
            let _ = query.reply(key.clone(), format!("{word} {own}")).wait();
        };
        let queryable = self.session.declare_queryable(format!("{ROOT}/may/**"));
        let queryable = queryable.callback(answer).wait();
        queryable.map(Some).map_err(zenoh)
    }
}
