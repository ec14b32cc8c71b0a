//! Progress of a training on standard error: one line, where that is a terminal. The program `hil` shows its own work
//! in the same way.

use std::io::{IsTerminal, stderr};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::settings::Progress;

/// Time between two drawings.
const EVERY: Duration = Duration::from_millis(125);

/// The line. Dropped, it is gone.
pub struct Shown(ProgressBar);

impl Shown {
    /// A line for a training of so many epochs.
    pub fn new(epochs: usize) -> Self {
        let set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
        let dumb = std::env::var_os("TERM").is_none_or(|term| term == "dumb");
        // A log that a CI keeps shows every drawing.
        let target = match stderr().is_terminal() && !set("CI") && !dumb {
            true => ProgressDrawTarget::stderr(),
            false => ProgressDrawTarget::hidden(),
        };
        let bar = ProgressBar::with_draw_target(Some(epochs as u64), target);
        let style = "training [{bar:30}] {pos} of {len} epochs, {eta} left, for {elapsed}{msg}";
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.enable_steady_tick(EVERY);
        Self(bar)
    }

    /// Shows the progress after an epoch.
    pub fn epoch(&self, progress: &Progress) {
        self.0.set_position(progress.epochs as u64);
        let best = progress.best_epoch;
        if let Some(error) = best.checked_sub(1).and_then(|n| progress.validation.get(n)) {
            self.0
                .set_message(format!("; validation error {error:.6} in epoch {best}"));
        }
    }
}

impl Drop for Shown {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
