//! The `embedded_hal` face of a segment, blocking and async: a handle that any number of drivers share.

use std::cell::RefCell;
use std::future::Future;
use std::pin::pin;
use std::rc::Rc;
use std::task::{Context, Poll, Waker};

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{ErrorType, I2c, Operation};

use super::{Error, Segment};
use crate::time::Nanos;

/// A shared segment. As a bus it takes the time a transaction takes; as a delay it lets virtual time pass.
#[derive(Clone, Debug)]
pub struct Handle(Rc<RefCell<Segment>>);

impl Handle {
    /// Takes the segment in.
    pub fn new(segment: Segment) -> Self {
        Self(Rc::new(RefCell::new(segment)))
    }

    /// Gives access to the segment. [`Error::BusBusy`] from inside another such call.
    pub fn with<T>(&self, work: impl FnOnce(&mut Segment) -> T) -> Result<T, Error> {
        let mut segment = self.0.try_borrow_mut().map_err(|_| Error::BusBusy)?;
        Ok(work(&mut segment))
    }
}

impl ErrorType for Handle {
    type Error = Error;
}

impl I2c for Handle {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Error> {
        self.with(|segment| segment.transaction(address, operations))?
    }
}

impl embedded_hal_async::i2c::I2c for Handle {
    /// Ready at once: in virtual time nobody waits.
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Error> {
        I2c::transaction(self, address, operations)
    }
}

impl DelayNs for Handle {
    fn delay_ns(&mut self, ns: u32) {
        let passed = self.with(|segment| segment.set_now(segment.now() + Nanos(u64::from(ns))));
        debug_assert!(
            passed.is_ok(),
            "a driver waits inside a look at its segment"
        );
    }
}

impl embedded_hal_async::delay::DelayNs for Handle {
    async fn delay_ns(&mut self, ns: u32) {
        DelayNs::delay_ns(self, ns);
    }
}

/// Runs a future that never waits, as all futures over a [`Handle`] are; `None` if it did wait.
pub fn immediate<F: Future>(future: F) -> Option<F::Output> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => Some(output),
        Poll::Pending => None,
    }
}
