//! One interface through its life: it is read and written, goes down, is renamed, is unplugged and comes back, or its
//! controller leaves the bus.

use std::collections::VecDeque;
use std::fs;
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use nix::errno::Errno;
use nix::net::if_::{if_indextoname, if_nametoindex};
use palpate_core::bus::Received;
use palpate_core::codec::can::CanFrame;
use tokio::io::Interest;
use tokio::io::unix::AsyncFd;
use tokio::sync::mpsc::{Receiver, Sender, UnboundedSender};

use super::controller::{Controller, restart};
use super::errors::{Change, Tally};
use super::socket::{Content, Endpoint};
use super::stamp::Stamps;
use super::{Note, OUTBOX};
use crate::pacer::RunClock;

/// Time between two looks at an interface, and from its return to its opening.
const ROUND: Duration = Duration::from_millis(100);
/// Time until a frame that found the kernel's queue full is tried again.
const RETRY: Duration = Duration::from_millis(2);
/// Packets taken in one go before the other interfaces have their turn.
const BATCH: usize = 64;

/// State of the network interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Link {
    Up,
    Down,
    Gone,
}

/// An interface and everything needed to open it again.
#[derive(Debug)]
pub(super) struct Interface {
    bus: u8,
    name: String,
    boards: Vec<u8>,
    /// The kernel's number of the interface, to which the socket is bound whatever the name. A test's interface has
    /// none.
    index: Option<u32>,
    link: Link,
    bus_off: bool,
    passive: bool,
    dropped: u32,
    clock: RunClock,
    stamps: Stamps,
    tallies: Arc<[Mutex<Tally>]>,
    frames: Sender<Received>,
    notes: UnboundedSender<Note>,
    endpoint: Option<Endpoint>,
    commands: Receiver<CanFrame>,
    outbox: VecDeque<CanFrame>,
}

/// Tells whether an interface is administratively up.
pub fn is_up(name: &str) -> bool {
    let flags = fs::read_to_string(format!("/sys/class/net/{name}/flags"));
    let flags = flags.ok().and_then(|text| {
        let digits = text.trim().trim_start_matches("0x").to_owned();
        u32::from_str_radix(&digits, 16).ok()
    });
    flags.is_some_and(|flags| flags & 1 != 0)
}

/// A socket in the event queue.
#[allow(unsafe_code)]
fn watched(endpoint: Endpoint) -> io::Result<AsyncFd<Endpoint>> {
    // SAFETY: an endpoint owns its descriptor, gives the same one every time, and closes it only when it
    // is dropped, which the queue's own end comes before.
    let registered = unsafe { AsyncFd::register_with_interest(endpoint, Interest::READABLE) };
    registered.map_err(Into::into)
}

impl Interface {
    #[allow(clippy::too_many_arguments)] // one call, from the bench's table to its threads
    pub(super) fn new(
        bus: u8,
        name: String,
        boards: Vec<u8>,
        clock: RunClock,
        tallies: Arc<[Mutex<Tally>]>,
        frames: Sender<Received>,
        notes: UnboundedSender<Note>,
        (endpoint, commands): (Endpoint, Receiver<CanFrame>),
    ) -> Self {
        Self {
            bus,
            index: if_nametoindex(name.as_str()).ok(),
            name,
            boards,
            link: Link::Up,
            bus_off: false,
            passive: false,
            dropped: 0,
            clock,
            stamps: Stamps::new(clock),
            tallies,
            frames,
            notes,
            endpoint: Some(endpoint),
            commands,
            outbox: VecDeque::new(),
        }
    }

    /// Serves until the program drops its end of the command queue.
    pub(super) async fn serve(mut self) {
        loop {
            let open = self.endpoint.take();
            let registered = open.map(watched);
            if let Some(Err(error)) = &registered {
                self.note(format!("cannot be waited for: {error}"));
            }
            if let Some(Ok(fd)) = registered
                && self.serve_open(&fd).await.is_none()
            {
                return;
            }
            tokio::time::sleep(ROUND).await;
            if self.commands.is_closed() {
                return;
            }
            self.reopen();
        }
    }

    /// Serves an open socket until it is of no use (`Some`) or the program ends (`None`).
    async fn serve_open(&mut self, fd: &AsyncFd<Endpoint>) -> Option<()> {
        let mut round = tokio::time::interval(ROUND);
        loop {
            tokio::select! {
                ready = fd.readable() => match ready {
                    Ok(mut ready) => match self.take(fd.get_ref()) {
                        Err(Errno::EAGAIN) => ready.clear_ready(),
                        Ok(()) => tokio::task::yield_now().await,
                        Err(error) => if !self.survives(error) { return Some(()) },
                    },
                    Err(_) => return Some(()), // the event queue is closed: the socket is of no use
                },
                command = self.commands.recv() => {
                    self.outbox.push_back(command?);
                    self.outbox.truncate(OUTBOX);
                    self.send(fd.get_ref());
                }
                _ = tokio::time::sleep(RETRY), if !self.outbox.is_empty() => self.send(fd.get_ref()),
                _ = round.tick() => if !self.look() { return Some(()) },
            }
        }
    }

    /// Takes packets off the socket, a batch at most.
    fn take(&mut self, endpoint: &Endpoint) -> Result<(), Errno> {
        for _ in 0..BATCH {
            let packet = match endpoint.receive() {
                Err(Errno::EINTR) => continue,
                other => other?,
            };
            let at = self.stamps.time(&packet);
            let mut change = None;
            let mut lost = 0;
            {
                let tallies = Arc::clone(&self.tallies);
                let slot = &tallies[usize::from(self.bus)];
                let mut tally = slot.lock().unwrap_or_else(PoisonError::into_inner);
                tally.hardware_stamps = self.stamps.hardware();
                if let Some(count) = packet.dropped {
                    lost = tally.drops(&mut self.dropped, count);
                }
                match packet.content {
                    Content::Frame(frame) => {
                        tally.frames += 1;
                        let received = Received {
                            at,
                            bus: self.bus,
                            frame,
                        };
                        tally.discarded += u64::from(self.frames.try_send(received).is_err());
                    }
                    Content::Error(class, data) => change = tally.error(class, data),
                    Content::Other => tally.other += 1,
                }
            }
            if lost > 0 {
                self.note(format!("{lost} frames lost, this computer was too slow"));
            }
            if let Some(change) = change {
                self.changed(change);
            }
        }
        Ok(())
    }

    /// Takes in a change of the controller's state.
    fn changed(&mut self, change: Change) {
        match change {
            Change::BusOff if !self.bus_off => {
                self.bus_off = true;
                self.note("bus-off: short circuit, wrong bit rate or bad wiring".into());
            }
            Change::Restarted => {
                self.bus_off = false;
                self.passive = false;
                self.note("restarted, back on the bus".into());
            }
            Change::Passive if !self.passive => {
                self.passive = true;
                self.note(
                    "error passive: no node acknowledges, wrong bit rate or bad wiring".into(),
                );
            }
            Change::BusOff | Change::Passive => {}
        }
    }

    /// Tells whether the socket is still of use after an error.
    fn survives(&mut self, error: Errno) -> bool {
        match error {
            Errno::ENETDOWN => {
                self.set_link(Link::Down);
                true
            }
            Errno::ENODEV | Errno::ENXIO => {
                self.set_link(Link::Gone);
                false
            }
            other => {
                self.note(format!("{}; opening it again", other.desc()));
                self.link = Link::Gone;
                false
            }
        }
    }

    fn send(&mut self, endpoint: &Endpoint) {
        while let Some(frame) = self.outbox.front() {
            match endpoint.send(frame) {
                // A full queue empties by itself.
                Err(Errno::ENOBUFS | Errno::EAGAIN | Errno::EINTR) => return,
                // Sent, or of no use to anybody: the sender asks again.
                _ => drop(self.outbox.pop_front()),
            }
        }
    }

    /// Looks at the interface: down, up, renamed, gone (`false`), or bus-off without a restart by the kernel.
    fn look(&mut self) -> bool {
        let Some(index) = self.index else {
            return true;
        };
        let name = if_indextoname(index)
            .ok()
            .and_then(|n| n.into_string().ok());
        // An interface that is being taken away may have lost its name already, and its socket reports nothing any
        // more.
        let Some(name) = name.filter(|name| !name.is_empty()) else {
            self.set_link(Link::Gone);
            return false;
        };
        if name != self.name {
            self.note(format!("renamed to {name}, goes on"));
            self.name = name;
        }
        let link = if is_up(&self.name) {
            Link::Up
        } else {
            Link::Down
        };
        self.set_link(link);
        if self.bus_off && link == Link::Up {
            self.restart();
        }
        true
    }

    /// Restarts a controller that the kernel will not restart by itself.
    fn restart(&mut self) {
        let restart_ms = match Controller::ask(&self.name) {
            Err(Errno::ENODEV) => return,
            asked => asked.ok().and_then(|controller| controller.restart_ms),
        };
        if restart_ms.unwrap_or(0) > 0 {
            return; // it restarts by itself, and says so by an error frame
        }
        // An adapter on a serial line has no device of its own and knows no restart; kernels that do not check
        // for that crash when they are asked for one.
        let knows_restart = Path::new("/sys/class/net")
            .join(&self.name)
            .join("device")
            .exists();
        if !knows_restart {
            self.stays_off("`ip link set NAME down; ip link set NAME up`");
        } else if restart(&self.name).is_err() {
            self.stays_off("`ip link set NAME type can restart` (now), `ip link set NAME type can restart-ms 100` (always, while it is down)");
        }
    }

    /// Tells the remedy once. By then the controller begins anew, and its next message is news.
    fn stays_off(&mut self, remedy: &str) {
        self.bus_off = false;
        self.passive = false;
        let remedy = remedy.replace("NAME", &self.name);
        self.note(format!("stays bus-off: {remedy}"));
    }

    fn set_link(&mut self, link: Link) {
        let before = std::mem::replace(&mut self.link, link);
        if before == link {
            return;
        }
        let text = match link {
            Link::Up => "up again",
            Link::Down => "went down; waiting for `ip link set NAME up`",
            Link::Gone => "gone (unplugged?); waiting for it to come back",
        };
        let text = text.replace("NAME", &self.name);
        self.note(text);
    }

    fn reopen(&mut self) {
        if let Ok(endpoint) = Endpoint::open(&self.name, &self.boards) {
            self.index = if_nametoindex(self.name.as_str()).ok();
            self.endpoint = Some(endpoint);
            self.dropped = 0;
            self.stamps = Stamps::new(self.clock);
            self.set_link(if is_up(&self.name) {
                Link::Up
            } else {
                Link::Down
            });
        }
    }

    fn note(&self, text: String) {
        // The receiver is gone only while the program ends.
        let _ = self.notes.send(Note {
            at: self.clock.now(),
            text: format!("{}: {text}", self.name),
        });
    }
}
