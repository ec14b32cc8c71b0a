//! One adapter of a guardian, on a thread that is there from the start: orders are taken at once, and a transfer that hangs
//! holds up its own bus alone. Nothing here allocates once the thread runs.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use arrayvec::ArrayVec;

use super::WatchedBus;
use super::outputs::{Outputs, Report, Why};
use crate::i2c::{Adapter, REST};
use crate::sys;

/// Stack of a thread that makes transfers, bytes.
const STACK: usize = 256 * 1024;
/// Bytes of the stack that are touched beforehand, so that no page is missing when it counts.
const TOUCHED: usize = 64 * 1024;
/// Priority above the guardian's own: its orders are carried out before its next decision.
const PRIORITY: u8 = 61;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// Read every board and change nothing.
    Look,
    /// Switch everything off, and read back.
    Off,
}

#[derive(Debug, Default)]
struct State {
    order: Option<Order>,
    /// `true` while an order is carried out.
    busy: bool,
    report: Option<Report>,
    over: bool,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    /// Signals a new order or report.
    changed: Condvar,
}

impl Shared {
    /// Locks the state. It is whole even where a thread panicked with the lock.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The guardian's end of an adapter. Dropped, it lets its thread end by itself, which may hang in a transfer.
#[derive(Debug)]
pub(super) struct Hand {
    shared: Arc<Shared>,
    bus: WatchedBus,
}

impl Hand {
    /// Puts an adapter on a thread. Nothing is sent.
    ///
    /// # Errors
    /// Error of the system where it gives no thread, and places at which no drivers of motors can be.
    pub(super) fn new(bus: WatchedBus, adapter: Box<dyn Adapter>) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let worker = Worker {
            shared: Arc::clone(&shared),
            outputs: Outputs::new(&bus, adapter)?,
        };
        let thread = Builder::new().name("off".into()).stack_size(STACK);
        thread.spawn(move || worker.work())?;
        Ok(Self { shared, bus })
    }

    pub(super) const fn bus(&self) -> &WatchedBus {
        &self.bus
    }

    /// Orders everything off; an earlier order that has not begun is left out.
    pub(super) fn off(&self) {
        self.order(Order::Off);
    }

    /// Orders a look at every board.
    pub(super) fn look(&self) {
        self.order(Order::Look);
    }

    fn order(&self, order: Order) {
        let mut state = self.shared.state();
        (state.order, state.report) = (Some(order), None);
        self.shared.changed.notify_all();
    }

    /// Takes the report of the last order; `None` before the answer, and after the first call.
    pub(super) fn report(&self) -> Option<Report> {
        self.shared.state().report.take()
    }

    /// Takes the report of the last order, waiting for it until `patience` is over.
    pub(super) fn wait(&self, patience: Duration) -> Option<Report> {
        let waits =
            |state: &mut State| state.report.is_none() && (state.busy || state.order.is_some());
        let changed = &self.shared.changed;
        let waited = changed.wait_timeout_while(self.shared.state(), patience, waits);
        waited
            .unwrap_or_else(PoisonError::into_inner)
            .0
            .report
            .take()
    }
}

impl Drop for Hand {
    fn drop(&mut self) {
        self.shared.state().over = true;
        self.shared.changed.notify_all();
    }
}

/// State of an adapter's thread.
struct Worker {
    shared: Arc<Shared>,
    outputs: Outputs,
}

impl Worker {
    fn work(mut self) {
        sys::touch_stack::<TOUCHED>();
        let _ = sys::set_fifo_priority(PRIORITY);
        while let Some(order) = self.wait() {
            let done = catch_unwind(AssertUnwindSafe(|| match order {
                Order::Look => self.outputs.look(false),
                Order::Off => self.outputs.off(),
            }));
            let report = done.unwrap_or_else(|_| Report {
                off: Err(Why::Failed),
                found: ArrayVec::new(),
            });
            let mut state = self.shared.state();
            state.busy = false;
            // A newer order makes it stale.
            if state.order.is_none() {
                state.report = Some(report);
            }
            self.shared.changed.notify_all();
        }
    }

    /// The next order; `None` once nobody can give one. Meanwhile the adapter rests.
    fn wait(&mut self) -> Option<Order> {
        let shared = Arc::clone(&self.shared);
        let idle = |state: &mut State| state.order.is_none() && !state.over;
        loop {
            let waited = shared
                .changed
                .wait_timeout_while(shared.state(), REST, idle);
            let (mut state, timeout) = waited.unwrap_or_else(PoisonError::into_inner);
            if !timeout.timed_out() {
                state.busy = true;
                return state.order.take();
            }
            drop(state);
            // A node that is held on to never comes back after it was unplugged.
            self.outputs.rest();
        }
    }
}
