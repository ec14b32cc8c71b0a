//! `palpate-link ros`: contacts as ROS 2 reads them, by the keys of `rmw_zenoh` and standard messages, without a ROS crate.

mod cdr;
mod messages;

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use palpate_buses::signals::Signals;
use palpate_live::output::note;
use palpate_run::Failure;
use zenoh::liveliness::LivelinessToken;
use zenoh::pubsub::Publisher;
use zenoh::{Session, Wait as _};

use crate::cli::{RosArgs, after};
use crate::ends::Inbox;
use crate::message::{Body, Frame};
use crate::net::{self, Mode, NetError, zenoh};
pub use messages::{MARKERS, POINT, Stamp, Topic, markers, point};

/// Frames that wait at most.
const MOST_WAITING: usize = 256;

/// A topic of ROS that is published.
struct Published {
    publisher: Publisher<'static>,
    _token: LivelinessToken,
    gid: [u8; 16],
    sequence: AtomicI64,
}

/// Nanoseconds since 1970: the time of ROS.
#[allow(clippy::disallowed_methods)] // stamps of messages, which no run reads
fn unix_ns() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |t| i64::try_from(t.as_nanos()).unwrap_or(i64::MAX))
}

impl Published {
    /// Declares a topic and announces it in ROS's graph.
    fn new(
        session: &Session,
        domain: u16,
        (node, entity): (&str, u32),
        name: &str,
        topic: &Topic,
    ) -> Result<Self, NetError> {
        let id = session.zid();
        let kind = format!(
            "{}::msg::dds_::{}_/{}",
            topic.package, topic.name, topic.hash
        );
        let key = format!("{domain}/{name}/{kind}");
        let mangled = format!("%{}", name.replace('/', "%"));
        let token =
            format!("@ros2_lv/{domain}/{id}/0/{entity}/MP/%/%/{node}/{mangled}/{kind}/::,1:,:,:,,");
        let mut gid = [0; 16];
        gid[..8].copy_from_slice(&id.to_le_bytes()[..8]);
        gid[8..12].copy_from_slice(&entity.to_le_bytes());
        Ok(Self {
            publisher: session.declare_publisher(key).wait().map_err(zenoh)?,
            _token: session
                .liveliness()
                .declare_token(token)
                .wait()
                .map_err(zenoh)?,
            gid,
            sequence: AtomicI64::new(0),
        })
    }

    fn send(&self, bytes: Vec<u8>) -> Result<(), NetError> {
        let sequence = self.sequence.fetch_add(1, Ordering::Relaxed) + 1;
        let mut attachment = Vec::with_capacity(33);
        attachment.extend(sequence.to_le_bytes());
        attachment.extend(unix_ns().to_le_bytes());
        attachment.push(16);
        attachment.extend(self.gid);
        let put = self.publisher.put(bytes).attachment(attachment);
        put.wait().map_err(zenoh)
    }
}

/// Runs it.
///
/// # Errors
/// [`Failure`] with its exit status.
pub fn run(args: &RosArgs) -> Result<(), Failure> {
    let signals = Signals::catch().map_err(|e| Failure::Device(e.to_string()))?;
    let net = net::open(&args.at.at(), Mode::Peer, &signals)?;
    let (session, domain) = (&net.session, args.domain);
    let node = "palpate_link";
    let id = session.zid();
    let node_token = format!("@ros2_lv/{domain}/{id}/0/0/NN/%/%/{node}");
    let _node = session
        .liveliness()
        .declare_token(node_token)
        .wait()
        .map_err(zenoh)?;
    // A name of ROS has no hyphens.
    let base = format!("palpate/{}", args.finger).replace('-', "_");
    let points = Published::new(
        session,
        domain,
        (node, 1),
        &format!("{base}/contact"),
        &POINT,
    )?;
    let marks = Published::new(
        session,
        domain,
        (node, 2),
        &format!("{base}/markers"),
        &MARKERS,
    )?;
    let waiting = Arc::new(Inbox::new(MOST_WAITING));
    let subscriber = {
        let waiting = Arc::clone(&waiting);
        net::subscribe(session, args.finger.contacts(), move |sample| {
            if let Some(frame) = net::bytes(&sample).and_then(|bytes| Frame::touched(&bytes)) {
                waiting.push(frame);
            }
        })?
    };
    note(&format!(
        "/{base}/contact and /{base}/markers in domain {domain}"
    ));
    let frame_id = base.replace('/', "_");
    let clock = palpate_buses::pacer::RunClock::start();
    let end = args.seconds.map(after);
    while signals.caught().is_none() && end.is_none_or(|end| clock.now() < end) {
        waiting.wait(Duration::from_millis(50));
        while let Some(frame) = waiting.take() {
            let Body::Touched(contacts) = frame.body else {
                continue;
            };
            // Time of the reading: as long before now as before the frame was sent.
            let age_us = frame.head.sent_us.saturating_sub(frame.head.taken_us);
            let at =
                unix_ns().saturating_sub(i64::try_from(age_us).unwrap_or(0).saturating_mul(1000));
            let stamp = Stamp::new(at, &frame_id);
            let strongest = contacts
                .iter()
                .max_by(|a, b| a.intensity.total_cmp(&b.intensity));
            if let Some(contact) = strongest {
                points.send(point(&stamp, contact))?;
            }
            marks.send(markers(&stamp, &contacts))?;
        }
    }
    drop(subscriber);
    Ok(())
}
