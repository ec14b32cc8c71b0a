//! One adapter of a guardian, on a thread that is there from the start: orders are taken at once, and a transfer that hangs
//! holds up its own bus alone. Nothing here allocates once the thread runs.

use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use arrayvec::ArrayVec;
use palpate_core::driver::{Actuators, DriverError, Pca9685Bank, Seen};
use palpate_core::units::{Milliamps, Prescale};

use super::WatchedBus;
use crate::i2c::{Adapter, Direct, FaultKind, REST};
use crate::sys;

/// Most boards of a bus.
const BOARDS: usize = 16;
/// Stack of a thread that makes transfers, bytes.
const STACK: usize = 256 * 1024;
/// Bytes of the stack that are touched beforehand, so that no page is missing when it counts.
const TOUCHED: usize = 64 * 1024;
/// Priority above the guardian's own: its orders are carried out before its next decision.
const PRIORITY: u8 = 61;

/// Reasons why the state of a bus is unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Why {
    /// A transfer failed.
    #[error("address {0:#04x}: {words}", words = .1.words(*.0))]
    Bus(u8, FaultKind),
    /// A board reads back as on.
    #[error("address {0:#04x}: reads back as on")]
    On(u8),
    /// The driver found another error.
    #[error(transparent)]
    Driver(DriverError),
    /// The program failed.
    #[error("switching off has failed within the program")]
    Failed,
    /// No answer has come yet.
    #[error("the adapter has not answered yet")]
    Waits,
}

/// A board's address, and its registers as they were found.
pub(super) type Looked = (u8, Result<Seen, Why>);

/// Result of an order.
#[derive(Clone, Debug)]
pub(super) struct Report {
    /// `Ok` where everything is known to be off, else the reason. After a look alone, `Ok` where all boards answered.
    pub(super) off: Result<(), Why>,
    /// The boards, as they were read.
    pub(super) found: ArrayVec<Looked, BOARDS>,
}

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
    /// Error of the system where it gives no thread.
    pub(super) fn new(bus: WatchedBus, adapter: Box<dyn Adapter>) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        // Switching off and reading back need neither PRE_SCALE nor full scale.
        let bank = Pca9685Bank::new(Direct::new(adapter), &bus.boards, Prescale::MIN);
        let bank = bank.with_converters(&bus.converters, Milliamps(0));
        let addresses = bus.boards.iter().copied().take(BOARDS).collect();
        let worker = Worker {
            shared: Arc::clone(&shared),
            bank,
            addresses,
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
    bank: Pca9685Bank<Direct<Box<dyn Adapter>>>,
    addresses: ArrayVec<u8, BOARDS>,
}

impl Worker {
    fn work(mut self) {
        sys::touch_stack::<TOUCHED>();
        let _ = sys::set_fifo_priority(PRIORITY);
        while let Some(order) = self.wait() {
            let done = catch_unwind(AssertUnwindSafe(|| match order {
                Order::Look => self.look(false),
                Order::Off => self.off(),
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
            self.bank.bus_mut().rest();
        }
    }

    /// Switches everything off, sets every current that can be set to zero, and reads back.
    fn off(&mut self) -> Report {
        let off = self.bank.all_off();
        // A board that does not answer keeps no other one unread.
        let mut report = self.look(true);
        let zero = self
            .bank
            .numbers()
            .map(|board| self.bank.confirm_zero(board));
        let zero = zero.fold(Ok(()), Result::and);
        let said = off.and(zero).map_err(|error| self.why(error));
        report.off = said.and(report.off);
        if report.off.is_ok() {
            for board in self.bank.numbers() {
                // Old pulses only tell which outputs were on. The board is off.
                let _ = self.bank.forget_pulses(board);
            }
        }
        report
    }

    /// Reads every board; with `off`, a board that makes a pulse is wrong.
    fn look(&mut self, off: bool) -> Report {
        let mut report = Report {
            off: Ok(()),
            found: ArrayVec::new(),
        };
        for (board, &address) in self.bank.numbers().zip(&self.addresses) {
            let seen = self.bank.look(board).map_err(|error| self.why(error));
            let known = match &seen {
                Ok(seen) if off && seen.loaded != 0 => Err(Why::On(address)),
                Ok(_) => Ok(()),
                Err(why) => Err(*why),
            };
            report.off = report.off.and(known);
            report.found.push((address, seen));
        }
        report
    }

    fn why(&self, error: DriverError) -> Why {
        match (error, self.bank.bus().last_fault()) {
            (DriverError::Bus(..), Some((address, kind))) => Why::Bus(address, kind),
            _ => Why::Driver(error),
        }
    }
}
