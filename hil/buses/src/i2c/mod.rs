//! Linux I2C buses for the core's driver: a thread a bus, because a transfer may take as long as the
//! adapter likes, and the loop may not.
//!
//! Linux has no I2C transfer that does not block, so the thread does it, and [`Line`] waits for the thread no longer
//! than its limit.

mod adapter;
mod direct;
mod fault;
mod shared;

pub use adapter::{AdapterError, LinuxAdapter, number};
pub use direct::Direct;
pub use fault::{Fault, FaultKind, FaultWords};
pub use shared::SharedLine;

use std::sync::mpsc::{
    Receiver, RecvTimeoutError, Sender, SyncSender, TryRecvError, channel, sync_channel,
};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use embedded_hal::i2c::{ErrorType, I2c, Operation};

use crate::pulse::Pulse;
use crate::sys::{fifo_priority, set_fifo_priority};

/// Anything that makes I2C transfers: an adapter of the system, or a test's double.
pub trait Adapter: Send {
    /// Name of the adapter in messages.
    fn name(&self) -> String;

    /// One transaction with one STOP: a write, a read, or a write and a read after a repeated START.
    ///
    /// # Errors
    /// Failure that the adapter reports.
    fn transfer(&mut self, address: u8, write: &[u8], read: &mut [u8]) -> Result<(), FaultKind>;

    /// Rests: called now and then while nothing is to be transferred.
    fn rest(&mut self) {}
}

impl Adapter for Box<dyn Adapter> {
    fn name(&self) -> String {
        (**self).name()
    }

    fn transfer(&mut self, address: u8, write: &[u8], read: &mut [u8]) -> Result<(), FaultKind> {
        (**self).transfer(address, write, read)
    }

    fn rest(&mut self) {
        (**self).rest();
    }
}

/// Time between two heartbeats of a waiting loop.
const BEAT: Duration = Duration::from_millis(10);
/// Time after which an adapter without a request rests.
pub(crate) const REST: Duration = Duration::from_millis(100);

/// Answer to a transaction: the bytes read.
type Answer = Result<Vec<u8>, FaultKind>;

/// A transaction on its way to the thread, and the receiver of its answer.
struct Request {
    address: u8,
    write: Vec<u8>,
    read: usize,
    /// The real-time priority of the caller, who waits for the answer.
    priority: Option<u8>,
    answer: SyncSender<Answer>,
}

/// A bus for those who wait, the core's driver and the guardian, but no longer than a transaction's limit.
#[derive(Debug)]
pub struct Line {
    name: String,
    requests: Option<Sender<Request>>,
    /// The answer of a transaction that took too long. While it is out, nothing else is sent: a queue
    /// would carry out orders whose caller has given up.
    overdue: Option<Receiver<Answer>>,
    limit: Duration,
    /// Heartbeat while the loop waits.
    pulse: Option<Pulse>,
    last: Option<Fault>,
    thread: Option<JoinHandle<()>>,
}

/// Serves a bus until its last caller is gone. The thread takes on the real-time priority of each caller that has one.
fn serve(mut adapter: impl Adapter, orders: &Receiver<Request>) {
    let mut priority = None;
    loop {
        match orders.recv_timeout(REST) {
            Ok(order) => {
                // An ordinary thread would keep a loop with real-time priority waiting, and its wires on.
                if priority != order.priority {
                    priority = order.priority;
                    let _ = priority.map(set_fifo_priority);
                }
                let mut read = vec![0; order.read];
                let result = adapter.transfer(order.address, &order.write, &mut read);
                // The answer to a caller that has stopped waiting is dropped.
                let _ = order.answer.send(result.map(|()| read));
            }
            Err(RecvTimeoutError::Timeout) => adapter.rest(),
            Err(RecvTimeoutError::Disconnected) => return,
        }
    }
}

impl Line {
    /// Puts an adapter on a thread; transactions that take longer than `limit` fail.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn new(adapter: impl Adapter + 'static, limit: Duration) -> std::io::Result<Self> {
        let name = adapter.name();
        let (requests, orders) = channel();
        let thread = std::thread::Builder::new()
            .name("i2c".into())
            .spawn(move || serve(adapter, &orders))?;
        Ok(Self {
            name,
            requests: Some(requests),
            overdue: None,
            limit,
            pulse: None,
            last: None,
            thread: Some(thread),
        })
    }

    /// Sends heartbeats while a transaction goes on: the limit bounds the wait, and on a bus that is stuck a guardian
    /// can do no more than the loop.
    pub fn set_pulse(&mut self, pulse: Pulse) {
        self.pulse = Some(pulse);
    }

    /// The last transaction that failed, in full: the driver's own error keeps only its kind.
    pub const fn last_fault(&self) -> Option<&Fault> {
        self.last.as_ref()
    }

    #[allow(clippy::disallowed_methods)] // how long a real adapter hangs has no emulated time
    fn exchange(&mut self, address: u8, write: &[u8], read: &mut [u8]) -> Result<(), FaultKind> {
        if let Some(overdue) = self.overdue.take() {
            // What it says came too late for its caller.
            if overdue.try_recv() == Err(TryRecvError::Empty) {
                self.overdue = Some(overdue);
                return Err(FaultKind::Stuck);
            }
        }
        let (answer, answered) = sync_channel(1);
        let request = Request {
            address,
            write: write.to_vec(),
            read: read.len(),
            priority: fifo_priority(),
            answer,
        };
        let sent = self.requests.as_ref().map(|r| r.send(request));
        let Some(Ok(())) = sent else {
            return Err(FaultKind::Gone);
        };
        let began = Instant::now();
        let bytes = loop {
            let left = self.limit.saturating_sub(began.elapsed());
            match answered.recv_timeout(left.min(BEAT)) {
                Ok(answer) => break answer?,
                // No answer: the thread has ended.
                Err(RecvTimeoutError::Disconnected) => return Err(FaultKind::Gone),
                Err(RecvTimeoutError::Timeout) if began.elapsed() >= self.limit => {
                    self.overdue = Some(answered);
                    return Err(FaultKind::Stuck);
                }
                Err(RecvTimeoutError::Timeout) => {
                    if let Some(pulse) = &self.pulse {
                        pulse.beat();
                    }
                }
            }
        };
        read.copy_from_slice(&bytes);
        Ok(())
    }
}

impl ErrorType for Line {
    type Error = Fault;
}

impl I2c for Line {
    /// Writes, then reads: what the driver uses. Adjacent writes become one message, since adapters that
    /// can chain messages without a START are rare.
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Fault> {
        let mut write = Vec::new();
        let mut lengths = 0;
        let mut ordered = true;
        for operation in operations.iter() {
            match operation {
                Operation::Write(bytes) => {
                    ordered &= lengths == 0;
                    write.extend_from_slice(bytes);
                }
                Operation::Read(bytes) => lengths += bytes.len(),
            }
        }
        let mut read = vec![0; lengths];
        let result = if ordered {
            self.exchange(address, &write, &mut read)
        } else {
            Err(FaultKind::Unsupported)
        };
        if let Err(kind) = result {
            let fault = Fault {
                bus: self.name.clone(),
                address,
                kind,
            };
            self.last = Some(fault.clone());
            return Err(fault);
        }
        let mut rest = read.as_slice();
        for operation in operations {
            if let Operation::Read(bytes) = operation {
                let (these, others) = rest.split_at(bytes.len());
                bytes.copy_from_slice(these);
                rest = others;
            }
        }
        Ok(())
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.requests = None;
        // A thread that is stuck in the adapter must not keep the program from ending.
        if let Some(thread) = self.thread.take()
            && self.overdue.is_none()
        {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests;
