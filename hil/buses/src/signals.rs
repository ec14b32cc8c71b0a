//! Signals that end a run in order: a first one is a wish, a second one is obeyed at once, and then the guardian does
//! the rest.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};
use signal_hook::{SigId, flag, low_level};

/// Number of [`Signals`] that wait.
static WAITING: AtomicUsize = AtomicUsize::new(0);

/// The wish to end.
#[derive(Debug)]
pub struct Signals {
    caught: Arc<AtomicUsize>,
    drill: Arc<AtomicBool>,
    registered: Vec<SigId>,
}

impl Signals {
    /// Catches SIGINT, SIGTERM and SIGHUP from now on.
    ///
    /// # Errors
    /// Error of the system.
    pub fn catch() -> io::Result<Self> {
        let caught = Arc::new(AtomicUsize::new(0));
        let again = Arc::new(AtomicBool::new(false));
        let mut registered = Vec::new();
        WAITING.fetch_add(1, Ordering::Relaxed);
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            // In this order: the first signal finds `again` unset, sets it, and is noted.
            let now = flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&again));
            registered.push(now?);
            registered.push(flag::register(signal, Arc::clone(&again))?);
            let caught = Arc::clone(&caught);
            registered.push(flag::register_usize(signal, caught, signal as usize)?);
        }
        let drill = Arc::new(AtomicBool::new(false));
        if std::env::var_os("PALPATE_DRILL").is_some() {
            flag::register(SIGUSR1, Arc::clone(&drill))?;
        }
        Ok(Self {
            caught,
            drill,
            registered,
        })
    }

    /// Tells whether signals are caught somewhere in the program: then they end the work there, not the program.
    pub fn are_caught() -> bool {
        WAITING.load(Ordering::Relaxed) > 0
    }

    /// A drill: with `PALPATE_DRILL` in the environment SIGUSR1 asks for a panic of the loop, so that a person can see
    /// the outputs after one.
    pub fn wants_panic(&self) -> bool {
        self.drill.load(Ordering::Relaxed)
    }

    /// The signal that came, by name.
    pub fn caught(&self) -> Option<&'static str> {
        match self.caught.load(Ordering::Relaxed) as i32 {
            SIGINT => Some("SIGINT"),
            SIGTERM => Some("SIGTERM"),
            SIGHUP => Some("SIGHUP"),
            _ => None,
        }
    }
}

/// Ends the wait for signals; the next one is for code that comes after it.
impl Drop for Signals {
    fn drop(&mut self) {
        for id in self.registered.drain(..) {
            low_level::unregister(id);
        }
        WAITING.fetch_sub(1, Ordering::Relaxed);
    }
}
