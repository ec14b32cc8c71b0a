//! The `embedded_hal` face of a segment, blocking and async: a handle that any number of drivers share.

use std::future::Future;
use std::pin::pin;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll, Waker};

use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::{ErrorType, I2c, Operation};

use super::{Error, I2cSegment};
use crate::time::Nanos;

/// A shared segment. As a bus it takes the time a transaction takes; as a delay it lets virtual time pass.
///
/// ```
/// use embedded_hal::i2c::I2c;
/// use palpate_core::units::Channel;
/// use palpate_emulators::display::i2c::{BusClock, I2cHandle, I2cSegment, immediate};
/// use palpate_emulators::display::pca9685::{Config, Pca9685, Pin};
/// use palpate_emulators::time::Nanos;
///
/// let chip = Pca9685::new(Config::new(0x40));
/// let bus = I2cHandle::new(I2cSegment::new(BusClock::Fast, vec![chip]));
///
/// // What a driver does, blocking or not: wake the chip with auto-increment, switch output 3 full on.
/// bus.clone().write(0x40, &[0x00, 0x20])?;
/// let mut held = bus.clone();
/// let full_on = embedded_hal_async::i2c::I2c::write(&mut held, 0x40, &[0x12, 0, 0x10, 0, 0]);
/// immediate(full_on).ok_or("virtual time never waits")??;
///
/// // What the chip does with it, once the oscillator runs: here 6 ms after the start.
/// let pin = bus.with(|segment| {
///     segment.advance(Nanos::from_micros(6_000), &mut |_, _| ());
///     segment.chips()[0].pin(Channel(3))
/// })?;
/// assert_eq!(pin, Pin::High);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// A handle may cross to another thread. Threads take turns, a transaction at a time; what each of them meets then
/// depends on their order.
#[derive(Clone, Debug)]
pub struct I2cHandle(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    segment: Mutex<I2cSegment>,
    /// The thread that is inside [`I2cHandle::with`], as [`this_thread`] names it; zero outside.
    inside: AtomicUsize,
}

/// A number of the running thread, never zero: where one of its own variables lies.
fn this_thread() -> usize {
    thread_local!(static MARK: u8 = const { 0 });
    MARK.with(|mark| std::ptr::from_ref(mark).addr())
}

impl I2cHandle {
    /// Takes the segment in.
    pub fn new(segment: I2cSegment) -> Self {
        Self(Arc::new(Inner {
            segment: Mutex::new(segment),
            inside: AtomicUsize::new(0),
        }))
    }

    /// Gives access to the segment. [`Error::BusBusy`] from inside another such call.
    pub fn with<T>(&self, work: impl FnOnce(&mut I2cSegment) -> T) -> Result<T, Error> {
        let me = this_thread();
        // A mutex would wait for ever for its own thread. No other thread ever writes this one's number.
        if self.0.inside.load(Ordering::Relaxed) == me {
            return Err(Error::BusBusy);
        }
        // A thread that panicked in here leaves chips that are still chips.
        let segment = self.0.segment.lock();
        let mut segment = segment.unwrap_or_else(PoisonError::into_inner);
        let _stay = Stay::new(&self.0.inside, me);
        Ok(work(&mut segment))
    }
}

/// A thread's stay inside a segment: it ends however the work ends.
struct Stay<'a>(&'a AtomicUsize);

impl<'a> Stay<'a> {
    fn new(inside: &'a AtomicUsize, thread: usize) -> Self {
        inside.store(thread, Ordering::Relaxed);
        Self(inside)
    }
}

impl Drop for Stay<'_> {
    fn drop(&mut self) {
        self.0.store(0, Ordering::Relaxed);
    }
}

impl ErrorType for I2cHandle {
    type Error = Error;
}

impl I2c for I2cHandle {
    fn transaction(&mut self, address: u8, operations: &mut [Operation<'_>]) -> Result<(), Error> {
        self.with(|segment| segment.transaction(address, operations))?
    }
}

impl embedded_hal_async::i2c::I2c for I2cHandle {
    /// Ready at once: virtual time has no waiting.
    async fn transaction(
        &mut self,
        address: u8,
        operations: &mut [Operation<'_>],
    ) -> Result<(), Error> {
        I2c::transaction(self, address, operations)
    }
}

impl DelayNs for I2cHandle {
    fn delay_ns(&mut self, ns: u32) {
        let passed = self.with(|segment| segment.set_now(segment.now() + Nanos(u64::from(ns))));
        debug_assert!(
            passed.is_ok(),
            "a driver waits inside a look at its segment"
        );
    }
}

impl embedded_hal_async::delay::DelayNs for I2cHandle {
    async fn delay_ns(&mut self, ns: u32) {
        DelayNs::delay_ns(self, ns);
    }
}

/// Runs a future that never waits, as all futures over a [`I2cHandle`] are; `None` if it did wait.
pub fn immediate<F: Future>(future: F) -> Option<F::Output> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(output) => Some(output),
        Poll::Pending => None,
    }
}
