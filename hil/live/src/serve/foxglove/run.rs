//! A run's end of its Foxglove topics: the loop hands over copies, and a thread makes messages of them in its own time.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

use palpate_core::units::{Duration, Instant};
use palpate_records::mcap::{Recording, Store};
use palpate_records::readings::Readings;
use palpate_records::trace::Event;
use palpate_run::{Beginning, Failure, TurnView};

use super::Foxglove;
use super::hub::{Hub, Topics};
use super::words::Channel;

/// Time between two looks at the run.
const EVERY: Duration = Duration::from_millis(40);
/// Looks that wait for the thread. While there is no room, events stay with the run, and come with a later look.
const QUEUE: usize = 4;

/// Topics of a file that a view lacks: it has neither frames of the buses nor the axes of each taxel.
fn is_for_files(topic: &str) -> bool {
    topic == "/can" || topic == "/i2c" || topic.starts_with("/taxels/")
}

/// A run's end of its topics.
#[derive(Debug)]
pub struct FoxgloveRun {
    looks: Option<SyncSender<Look>>,
    thread: Option<JoinHandle<()>>,
    /// Events that were handed over.
    told: usize,
    next: Instant,
}

/// Copies of what is new in a run.
#[derive(Debug)]
struct Look {
    now: Instant,
    events: Vec<Event>,
    counts: Vec<f32>,
}

impl FoxgloveRun {
    /// A run's end, for a run that is about to begin.
    ///
    /// # Errors
    /// [`Failure::Device`] when the system gives no thread.
    pub fn begin(foxglove: &Foxglove, run: &Beginning<'_>) -> Result<Self, Failure> {
        let failed = |e: io::Error| Failure::Device(format!("--foxglove: {e}"));
        let readings = Readings::whole(run.projector.layout(), run.setup.scene.value.drives);
        let channels = Channels::new(Arc::clone(&foxglove.hub));
        let mut recording = Recording::of_run_in(channels, run.header, readings.modules());
        if let Ok(recording) = &mut recording {
            recording.store_mut().advertise();
        }
        let mut recording = recording.map_err(failed)?;
        let (looks, orders) = sync_channel(QUEUE);
        let publish = move || publish(&mut recording, &orders);
        let thread = Builder::new().name("foxglove".into()).spawn(publish);
        Ok(Self {
            looks: Some(looks),
            thread: Some(thread.map_err(failed)?),
            told: 0,
            next: Instant::ZERO,
        })
    }

    /// Hands over what is new, if a look is due. Waits for nothing.
    pub fn turn(&mut self, seen: &TurnView<'_>) {
        if seen.now < self.next {
            return;
        }
        self.next = (self.next + EVERY).max(seen.now);
        let look = Look {
            now: seen.now,
            events: seen.events.get(self.told..).unwrap_or_default().to_vec(),
            counts: seen.counts.to_vec(),
        };
        if self
            .looks
            .as_ref()
            .is_some_and(|looks| looks.try_send(look).is_ok())
        {
            self.told = seen.events.len();
        }
    }
}

impl Drop for FoxgloveRun {
    /// Waits for the last messages to be made.
    fn drop(&mut self) {
        self.looks = None;
        // A panic of the thread has been reported already.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Publishes looks until there are no more.
fn publish(recording: &mut Recording<Channels>, looks: &Receiver<Look>) {
    for look in looks {
        let t_us = look.now.as_micros();
        // Publishing has no errors: a client that is gone or slow is the hub's matter.
        let _ = recording.piece(&look.events, Default::default());
        let _ = recording.picture(t_us, &look.counts);
        recording.store_mut().hub.show(t_us.saturating_mul(1000));
    }
}

/// The topics of a run, before clients.
#[derive(Debug)]
pub(super) struct Channels {
    hub: Arc<Hub>,
    /// Number of the first topic.
    base: u32,
    /// Topics so far, files' own among them.
    count: u16,
    /// Name and descriptor of each schema.
    schemas: Vec<(String, Vec<u8>)>,
    /// Topics that are not advertised yet; `None` once they are.
    begun: Option<Topics>,
}

impl Channels {
    /// No topics yet.
    pub(super) fn new(hub: Arc<Hub>) -> Self {
        Self {
            base: hub.next_id(),
            hub,
            count: 0,
            schemas: Vec::new(),
            begun: Some(Topics::default()),
        }
    }

    /// Tells clients of the topics; messages from here on are published.
    pub(super) fn advertise(&mut self) {
        if let Some(topics) = self.begun.take() {
            self.hub.begin(topics);
        }
    }
}

impl Store for Channels {
    fn schema(&mut self, name: &str, descriptor: &[u8]) -> io::Result<u16> {
        self.schemas.push((name.to_owned(), descriptor.to_vec()));
        Ok(self.schemas.len() as u16) // a dozen
    }

    fn channel(&mut self, schema: u16, topic: &str) -> io::Result<u16> {
        let number = self.count;
        self.count += 1;
        let schema = self.schemas.get(usize::from(schema).saturating_sub(1));
        if let (Some((name, descriptor)), Some(topics)) = (schema, &mut self.begun)
            && !is_for_files(topic)
        {
            let id = self.base + u32::from(number);
            topics
                .channels
                .push(Channel::new(id, topic, name, descriptor));
        }
        Ok(number)
    }

    fn message(&mut self, channel: u16, time: u64, data: &[u8]) -> io::Result<()> {
        let id = self.base + u32::from(channel);
        match &mut self.begun {
            Some(topics) => topics.first.push((id, time, data.to_vec())),
            None => self.hub.publish(id, time, data),
        }
        Ok(())
    }
}
