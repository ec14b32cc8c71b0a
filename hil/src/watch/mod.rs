//! `hil run --watch`: the run as it goes, on a terminal. A thread of its own draws; a view that comes while it
//! draws is left out, so the loop never waits for a screen.

mod ansi;
mod draw;
mod heat;
mod view;

pub use view::View;

use std::io::{self, BufWriter, Stdout};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;

use palpate_buses::pacer::RunClock;
use palpate_buses::terminal::Terminal;
use palpate_core::skin::Layout;
use palpate_core::units::{Duration, Instant};
use palpate_records::trace::{Event, Header};
use ratatui_core::terminal::Terminal as Screen;

use ansi::Ansi;
use draw::{SMALLEST, draw, skin_size};
use heat::Raster;
use palpate_buses::signals::Signals;

/// Time between two views.
const EVERY: Duration = Duration::from_millis(50);
/// Time between two looks at the keys.
const KEYS: std::time::Duration = std::time::Duration::from_millis(50);

/// The run's end of a live view.
#[derive(Debug)]
pub struct Watch {
    view: View,
    next: Instant,
    /// How many of the run's events it has seen.
    told: usize,
    views: Option<SyncSender<View>>,
    thread: Option<JoinHandle<()>>,
    stop: Arc<AtomicBool>,
    /// For a run in virtual time: the clock that it is held to, and what ends it.
    pace: Option<(RunClock, Signals)>,
}

impl Watch {
    /// Opens a live view on a run that will end at `end`; `None` without a terminal.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn open(
        header: &Header,
        layout: &Layout,
        end: Instant,
        virtual_time: bool,
    ) -> io::Result<Option<Self>> {
        let Some(terminal) = Terminal::open() else {
            return Ok(None);
        };
        let pace = match virtual_time {
            true => Some((RunClock::start(), Signals::catch()?)),
            false => None,
        };
        let (views, arriving) = sync_channel(1);
        let stop = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stop);
        let view = View::new(header, layout, end.as_micros());
        let (columns, rows) = skin_size();
        let raster = Raster::new(&view.taxels, columns, rows);
        let thread = std::thread::Builder::new()
            .name("watch".into())
            .spawn(move || show(&terminal, &raster, &arriving, &asked))?;
        Ok(Some(Self {
            view,
            next: Instant::ZERO,
            told: 0,
            views: Some(views),
            thread: Some(thread),
            stop,
            pace,
        }))
    }

    /// Shows the run at `now` and, for one in virtual time, waits until it is that late. `counts` are the
    /// readings of all taxels. True when somebody wants the run to end.
    pub fn turn(
        &mut self,
        now: Instant,
        events: &[Event],
        counts: &[f32],
        buses: impl FnOnce() -> Vec<String>,
    ) -> bool {
        let mut asked = self.stop.load(Ordering::Relaxed);
        if let Some((clock, signals)) = &self.pace {
            clock.sleep_until(now);
            asked |= signals.caught().is_some();
        }
        if now >= self.next {
            self.next = now + EVERY;
            self.view
                .observe(events.get(self.told..).unwrap_or_default());
            self.told = events.len();
            self.view.now_us = now.as_micros();
            self.view.counts.clear();
            self.view.counts.extend_from_slice(counts);
            self.view.buses = buses();
            if let Some(views) = &self.views {
                // Full: it is still drawing, and the next view is newer.
                let _ = views.try_send(self.view.clone());
            }
        }
        asked
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.views = None;
        if let Some(thread) = self.thread.take() {
            // It has given the terminal back even if it panicked.
            let _ = thread.join();
        }
    }
}

/// Draws views until there are no more.
fn show(terminal: &Terminal, raster: &Raster, views: &Receiver<View>, stop: &AtomicBool) {
    let size = || terminal.size().unwrap_or(SMALLEST);
    let (columns, rows) = size();
    let backend: Ansi<BufWriter<Stdout>> = Ansi::new(BufWriter::new(io::stdout()), columns, rows);
    let Ok(mut screen) = Screen::new(backend) else {
        return;
    };
    loop {
        match views.recv_timeout(KEYS) {
            Ok(view) => {
                let (columns, rows) = size();
                screen.backend_mut().size.width = columns;
                screen.backend_mut().size.height = rows;
                // A terminal that has gone away ends nothing.
                let _ = screen.draw(|frame| draw(&view, raster, frame.buffer_mut()));
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        if matches!(terminal.key(), Some(b'q' | b'Q')) {
            stop.store(true, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests;
