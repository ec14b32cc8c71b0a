//! Voice of a wearer's loop: a thread of its own, so that no network can hold up the guard.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use palpate_run::Failure;
use zenoh::pubsub::Publisher;
use zenoh::{Session, Wait as _};

use crate::message::MOST_BYTES;

/// Orders that wait at most; more are left out, and the next message makes up for them.
const MOST_WAITING: usize = 8;

/// Order to the voice's thread.
enum Order {
    Say(Vec<u8>),
    Ask,
}

/// A wearer's voice.
pub(super) struct Voice {
    orders: Option<SyncSender<Order>>,
    thread: Option<JoinHandle<()>>,
}

impl Voice {
    /// Speaks through `publisher`, and asks publishers for their facts under the key `about`; answers go to `answered`.
    pub(super) fn begin(
        session: Session,
        publisher: Publisher<'static>,
        about: String,
        answered: impl Fn(Vec<u8>) + Clone + Send + Sync + 'static,
    ) -> Result<Self, Failure> {
        let (orders, waiting) = sync_channel(MOST_WAITING);
        let thread = std::thread::Builder::new()
            .name("voice".into())
            .spawn(move || speak(&waiting, &session, &publisher, &about, &answered));
        let thread = thread.map_err(|e| Failure::Device(format!("the voice's thread: {e}")))?;
        Ok(Self {
            orders: Some(orders),
            thread: Some(thread),
        })
    }

    fn order(&self, order: Order) {
        if let Some(orders) = &self.orders {
            // The next message makes up for one that finds no room.
            let _ = orders.try_send(order);
        }
    }

    /// Sends a message.
    pub(super) fn say(&self, bytes: Vec<u8>) {
        self.order(Order::Say(bytes));
    }

    /// Asks publishers for their facts.
    pub(super) fn ask(&self) {
        self.order(Order::Ask);
    }
}

impl Drop for Voice {
    /// Waits until the last order is carried out.
    fn drop(&mut self) {
        drop(self.orders.take());
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has nothing left to say.
            let _ = thread.join();
        }
    }
}

fn speak(
    waiting: &Receiver<Order>,
    session: &Session,
    publisher: &Publisher<'static>,
    about: &str,
    answered: &(impl Fn(Vec<u8>) + Clone + Send + Sync + 'static),
) {
    for order in waiting {
        match order {
            // A message that does not reach the network is sent again.
            Order::Say(bytes) => drop(publisher.put(bytes).wait()),
            Order::Ask => {
                let answered = answered.clone();
                // A wearer without an answer asks again with a later frame.
                let asked = session.get(about).timeout(Duration::from_millis(500));
                let asked = asked.callback(move |reply| {
                    if let Ok(sample) = reply.result()
                        && sample.payload().len() <= 16 * MOST_BYTES
                    {
                        answered(sample.payload().to_bytes().into_owned());
                    }
                });
                drop(asked.wait());
            }
        }
    }
}
