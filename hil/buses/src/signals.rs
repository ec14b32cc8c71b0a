//! Signals that end a run in order: a first one is a wish, a second one is obeyed at once, and then the
//! guardian does what is left to do.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1};
use signal_hook::flag;

/// The wish to end.
#[derive(Debug)]
pub struct Signals {
    caught: Arc<AtomicUsize>,
    drill: Arc<AtomicBool>,
}

impl Signals {
    /// Catches SIGINT, SIGTERM and SIGHUP from now on.
    ///
    /// # Errors
    /// What the system says.
    pub fn catch() -> io::Result<Self> {
        let caught = Arc::new(AtomicUsize::new(0));
        let again = Arc::new(AtomicBool::new(false));
        for signal in [SIGINT, SIGTERM, SIGHUP] {
            // In this order: the first signal finds `again` unset, sets it, and is noted.
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&again))?;
            flag::register(signal, Arc::clone(&again))?;
            flag::register_usize(signal, Arc::clone(&caught), signal as usize)?;
        }
        let drill = Arc::new(AtomicBool::new(false));
        if std::env::var_os("PALPATE_DRILL").is_some() {
            flag::register(SIGUSR1, Arc::clone(&drill))?;
        }
        Ok(Self { caught, drill })
    }

    /// A drill: with `PALPATE_DRILL` in the environment SIGUSR1 asks for a panic of the loop, so that it can be
    /// seen what becomes of the outputs.
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
