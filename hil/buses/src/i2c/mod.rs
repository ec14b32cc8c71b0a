//! Linux I2C buses for the core's driver: a thread a bus, because a transfer may take as long as the
//! adapter likes, and the loop may not.

mod adapter;
mod fault;

pub use adapter::{LinuxAdapter, OpenError, number};
pub use fault::{Fault, FaultKind};

use std::sync::mpsc::{
    Receiver, RecvTimeoutError, Sender, SyncSender, TryRecvError, channel, sync_channel,
};
use std::thread::JoinHandle;
use std::time::Duration;

use embedded_hal::i2c::{ErrorType, I2c, Operation};

use crate::guardian::Pulse;

/// What transfers: an adapter of the system, or a test's double.
pub trait Adapter: Send {
    /// Its name in messages.
    fn name(&self) -> String;

    /// One transaction with one STOP: a write, a read, or a write and a read after a repeated START.
    ///
    /// # Errors
    /// What the adapter said.
    fn transfer(&mut self, address: u8, write: &[u8], read: &mut [u8]) -> Result<(), FaultKind>;
}

/// How often a waiting loop says that it is alive.
const BEAT: Duration = Duration::from_millis(10);

/// What came of a transaction: the bytes read.
type Answer = Result<Vec<u8>, FaultKind>;

/// A transaction on its way to the thread, and where its answer goes.
struct Request {
    address: u8,
    write: Vec<u8>,
    read: usize,
    answer: SyncSender<Answer>,
}

/// The loop's end of a bus. Waits for each transaction, but no longer than its limit.
#[derive(Debug)]
pub struct Line {
    name: String,
    requests: Option<Sender<Request>>,
    /// The answer of a transaction that took too long. While it is out, nothing else is sent: a queue
    /// would carry out orders that nobody wants any more.
    overdue: Option<Receiver<Answer>>,
    limit: Duration,
    /// Told while the loop waits.
    pulse: Option<Pulse>,
    last: Option<Fault>,
    thread: Option<JoinHandle<()>>,
}

impl Line {
    /// Puts an adapter on a thread; transactions that take longer than `limit` fail.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn new(mut adapter: impl Adapter + 'static, limit: Duration) -> std::io::Result<Self> {
        let name = adapter.name();
        let (requests, orders) = channel::<Request>();
        let thread = std::thread::Builder::new()
            .name("i2c".into())
            .spawn(move || {
                while let Ok(order) = orders.recv() {
                    let mut read = vec![0; order.read];
                    let result = adapter.transfer(order.address, &order.write, &mut read);
                    // The answer to one who has stopped waiting is for nobody.
                    let _ = order.answer.send(result.map(|()| read));
                }
            })?;
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

    /// While a transaction goes on the guardian hears that the loop is alive: the limit is what bounds the
    /// wait, and on a bus that is stuck a guardian can do no more than the loop.
    pub fn set_pulse(&mut self, pulse: Pulse) {
        self.pulse = Some(pulse);
    }

    /// Waits for an answer, no longer than the limit.
    fn wait(&self, answer: &Receiver<Answer>) -> Result<Answer, RecvTimeoutError> {
        let mut left = self.limit;
        while left > BEAT {
            match answer.recv_timeout(BEAT) {
                Err(RecvTimeoutError::Timeout) => {}
                other => return other,
            }
            left -= BEAT;
            if let Some(pulse) = &self.pulse {
                pulse.beat();
            }
        }
        answer.recv_timeout(left)
    }

    /// The last transaction that failed, in full: the driver's own error keeps only its kind.
    pub const fn last_fault(&self) -> Option<&Fault> {
        self.last.as_ref()
    }

    fn exchange(&mut self, address: u8, write: &[u8], read: &mut [u8]) -> Result<(), FaultKind> {
        if let Some(overdue) = self.overdue.take() {
            // What it says came too late for whoever asked.
            if let Err(TryRecvError::Empty) = overdue.try_recv() {
                self.overdue = Some(overdue);
                return Err(FaultKind::Stuck);
            }
        }
        let (answer, answered) = sync_channel(1);
        let request = Request {
            address,
            write: write.to_vec(),
            read: read.len(),
            answer,
        };
        let sent = self.requests.as_ref().map(|r| r.send(request));
        let Some(Ok(())) = sent else {
            return Err(FaultKind::Gone);
        };
        match self.wait(&answered) {
            Ok(Ok(bytes)) => {
                read.copy_from_slice(&bytes);
                Ok(())
            }
            Ok(Err(kind)) => Err(kind),
            Err(RecvTimeoutError::Timeout) => {
                self.overdue = Some(answered);
                Err(FaultKind::Stuck)
            }
            Err(RecvTimeoutError::Disconnected) => Err(FaultKind::Gone),
        }
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
