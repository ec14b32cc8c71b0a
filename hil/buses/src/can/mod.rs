//! SocketCAN interfaces as the core's [`CanBus`]: one or several, read on a thread of their own.
//!
//! An interface that goes down, is renamed or unplugged, or a controller that goes bus-off, ends nothing here: it
//! becomes a note, the frames stop, and the loop's watchdog answers the silence.

mod controller;
mod errors;
mod interface;
mod socket;
mod stamp;

pub(crate) use controller::{CanState, Controller};
pub use errors::Tally;
pub use interface::is_up;
pub use socket::Endpoint;

use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;

use embedded_can::{Error as CanError, ErrorKind};
use nix::errno::Errno;
use palpate_core::bus::{CanBus, Received};
use palpate_core::codec::can::CanFrame;
use palpate_core::units::Instant;
use tokio::sync::mpsc::error::{TryRecvError, TrySendError};
use tokio::sync::mpsc::{self, Receiver, Sender, UnboundedReceiver};

use crate::pacer::RunClock;
use interface::Interface;

/// Frames kept for the loop: more than two seconds of 24,000 a second.
const QUEUE: usize = 1 << 16;
/// Commands kept for an interface.
const OUTBOX: usize = 64;

/// Error of an interface that cannot be used from the start.
#[derive(Debug, thiserror::Error)]
#[error("{interface}: {reason}")]
pub struct OpenError {
    /// The interface's name.
    pub interface: String,
    /// Reason, and the command that mends it.
    pub reason: String,
}

impl OpenError {
    fn new(interface: &str, error: &io::Error) -> Self {
        let reason = match error.raw_os_error().map(Errno::from_raw) {
            Some(Errno::ENODEV) => format!(
                "no such interface; `ip link` lists what is there, `ip link add dev {interface} type vcan` makes a virtual one"
            ),
            Some(Errno::EAFNOSUPPORT | Errno::EPROTONOSUPPORT) => {
                "this kernel has no CAN sockets; try `modprobe can_raw`".into()
            }
            _ => error.to_string(),
        };
        Self {
            interface: interface.into(),
            reason,
        }
    }
}

/// Errors of a bus's user.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BusError {
    /// The command queue is full: try again later.
    #[error("transmit queue full, try again later")]
    QueueFull,
    /// No bus has this number.
    #[error("no such sensor bus")]
    NoBus,
    /// The thread that reads the interfaces is gone.
    #[error("the CAN reader has ended; this is a defect of the program")]
    ReaderGone,
}

impl CanError for BusError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// A line worth telling: an interface that went down, came back, was renamed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Note {
    /// Time at which the event was noticed.
    pub at: Instant,
    /// Words of the event, beginning with the interface's name.
    pub text: String,
}

/// Several CAN interfaces, numbered in the order in which they were opened.
#[derive(Debug)]
pub struct CanBuses {
    frames: Receiver<Received>,
    notes: UnboundedReceiver<Note>,
    /// Dropping these ends the thread.
    commands: Vec<Sender<CanFrame>>,
    tallies: Arc<[Mutex<Tally>]>,
    thread: Option<JoinHandle<()>>,
}

impl CanBuses {
    /// Opens interfaces, each with the numbers of the boards on it (none: all frames).
    ///
    /// # Errors
    /// [`OpenError`] for the first that is not there, not up or not allowed.
    pub fn open(interfaces: &[(String, Vec<u8>)], clock: RunClock) -> Result<Self, OpenError> {
        let mut endpoints = Vec::new();
        for (name, boards) in interfaces {
            let endpoint = Endpoint::open(name, boards).map_err(|e| OpenError::new(name, &e))?;
            if !is_up(name) {
                return Err(OpenError {
                    interface: name.clone(),
                    reason: format!(
                        "is down; bring it up: `ip link set {name} up type can bitrate 1000000 restart-ms 100` (a virtual one: `ip link set {name} up`)"
                    ),
                });
            }
            endpoints.push((name.clone(), boards.clone(), endpoint));
        }
        Self::over(endpoints, clock).map_err(|e| OpenError::new("CAN", &e))
    }

    /// Reads from endpoints that are open already.
    ///
    /// # Errors
    /// When the system gives no thread or event queue.
    pub fn over(endpoints: Vec<(String, Vec<u8>, Endpoint)>, clock: RunClock) -> io::Result<Self> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .build()?;
        let tallies: Arc<[Mutex<Tally>]> = endpoints.iter().map(|_| Mutex::default()).collect();
        let (frame_in, frames) = mpsc::channel(QUEUE);
        let (note_in, notes) = mpsc::unbounded_channel();
        let (mut commands, mut interfaces) = (Vec::new(), Vec::new());
        for (bus, (name, boards, endpoint)) in endpoints.into_iter().enumerate() {
            let (command_in, outbox) = mpsc::channel(OUTBOX);
            commands.push(command_in);
            interfaces.push(Interface::new(
                bus as u8, // a bench has at most 256
                name,
                boards,
                clock,
                Arc::clone(&tallies),
                frame_in.clone(),
                note_in.clone(),
                (endpoint, outbox),
            ));
        }
        let thread = std::thread::Builder::new()
            .name("can".into())
            .spawn(move || {
                runtime.block_on(async {
                    let tasks = interfaces.into_iter().map(|i| tokio::spawn(i.serve()));
                    for task in tasks.collect::<Vec<_>>() {
                        // A task that panicked drops its end of the queue; the others go on.
                        let _ = task.await;
                    }
                });
            })?;
        Ok(Self {
            frames,
            notes,
            commands,
            tallies,
            thread: Some(thread),
        })
    }

    /// Tally of each interface.
    pub fn tallies(&self) -> Vec<Tally> {
        let read = |t: &Mutex<Tally>| *t.lock().unwrap_or_else(PoisonError::into_inner);
        self.tallies.iter().map(read).collect()
    }

    /// The oldest note not yet taken.
    pub fn note(&mut self) -> Option<Note> {
        self.notes.try_recv().ok()
    }
}

impl CanBus for CanBuses {
    type Error = BusError;

    fn receive(&mut self) -> Result<Option<Received>, BusError> {
        match self.frames.try_recv() {
            Ok(received) => Ok(Some(received)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(BusError::ReaderGone),
        }
    }

    fn transmit(&mut self, bus: u8, frame: &CanFrame) -> Result<(), BusError> {
        let outbox = self.commands.get(usize::from(bus));
        let sent = outbox.ok_or(BusError::NoBus)?.try_send(*frame);
        sent.map_err(|error| match error {
            TrySendError::Full(_) => BusError::QueueFull,
            TrySendError::Closed(_) => BusError::ReaderGone,
        })
    }
}

impl Drop for CanBuses {
    fn drop(&mut self) {
        self.commands.clear();
        if let Some(thread) = self.thread.take() {
            // The end of the queue has reported a panic already.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests;
