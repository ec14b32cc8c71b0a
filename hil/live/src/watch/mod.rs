//! `hil run --watch`: the run as it goes, on a terminal. A thread of its own draws; a view that comes while it
//! draws is left out, so the loop never waits for a screen.

mod ansi;
mod draw;
mod grid;
mod heat;
mod view;

pub use view::View;

use std::io::{self, BufWriter};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;

use palpate_buses::terminal::Terminal;
use palpate_core::skin::Layout;
use palpate_core::units::{Duration, Instant};
use palpate_records::trace::{Event, Header};
use palpate_run::Wish;

use ansi::Ansi;
use draw::{SMALLEST, draw, skin_size};
use heat::Raster;

/// Time between two views.
const EVERY: Duration = Duration::from_millis(50);
/// Time between two looks at the keys.
const KEYS: std::time::Duration = std::time::Duration::from_millis(50);

/// A display's view, and its skin's raster, to be drawn.
type Picture = (View, Arc<Raster>);

/// A display of the run.
#[derive(Debug)]
struct Shown {
    view: View,
    raster: Arc<Raster>,
    next: Instant,
    /// Events of the display that the view has seen.
    told: usize,
}

impl Shown {
    fn new(header: &Header, layout: &Layout, end: Instant) -> Self {
        let view = View::new(header, layout, end.as_micros());
        let (columns, rows) = skin_size();
        Self {
            raster: Arc::new(Raster::new(&view.taxels, columns, rows)),
            view,
            next: Instant::ZERO,
            told: 0,
        }
    }
}

/// Wishes of the keys.
#[derive(Debug, Default)]
struct Asked {
    stop: AtomicBool,
    /// The key of the newest wish, 0 once it is taken.
    wish: AtomicU8,
    /// Index of the display shown; beyond the last one, counted on from the first.
    display: AtomicUsize,
}

impl Asked {
    /// Takes a key: `q` ends the run, `z` takes the reference anew and `Z` does so by force, `p` passes the wires of a display
    /// that was put on anew, Tab shows the next display, 1 to 9 and 0 one of the first ten.
    fn key(&self, key: u8) {
        match key {
            b'q' | b'Q' => self.stop.store(true, Ordering::Relaxed),
            b'z' | b'Z' | b'p' | b'P' => self.wish.store(key, Ordering::Relaxed),
            b'\t' => {
                self.display.fetch_add(1, Ordering::Relaxed);
            }
            b'0' => self.display.store(9, Ordering::Relaxed),
            b'1'..=b'9' => self
                .display
                .store(usize::from(key - b'1'), Ordering::Relaxed),
            _ => {}
        }
    }

    /// Index of the shown one of `of` displays.
    fn display(&self, of: usize) -> usize {
        self.display.load(Ordering::Relaxed) % of.max(1)
    }
}

/// The run's end of a live view: of several displays one is shown at a time.
#[derive(Debug)]
pub struct Watch {
    shown: Vec<Shown>,
    views: Option<SyncSender<Picture>>,
    thread: Option<JoinHandle<()>>,
    asked: Arc<Asked>,
}

impl Watch {
    /// Opens a live view on a run that will end at `end`; `None` without a terminal.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn open(header: &Header, layout: &Layout, end: Instant) -> io::Result<Option<Self>> {
        let Some(terminal) = Terminal::open() else {
            return Ok(None);
        };
        let (views, arriving) = sync_channel(1);
        let asked = Arc::new(Asked::default());
        let keys = Arc::clone(&asked);
        let thread = std::thread::Builder::new()
            .name("watch".into())
            .spawn(move || show(&terminal, &arriving, &keys))?;
        Ok(Some(Self {
            shown: vec![Shown::new(header, layout, end)],
            views: Some(views),
            thread: Some(thread),
            asked,
        }))
    }

    /// Adds a display of the same run.
    pub fn add(&mut self, header: &Header, layout: &Layout, end: Instant) {
        self.shown.push(Shown::new(header, layout, end));
    }

    /// Wish of the newest key since the last call.
    pub fn wish(&self) -> Option<Wish> {
        match self.asked.wish.swap(0, Ordering::Relaxed) {
            b'z' => Some(Wish::Rezero { forced: false }),
            b'Z' => Some(Wish::Rezero { forced: true }),
            b'p' | b'P' => Some(Wish::HotPass),
            _ => None,
        }
    }

    /// Shows a display at `now` if it is the one to be shown. `counts` are the readings of all its taxels. True when the
    /// watcher wants the run to end.
    pub fn turn(
        &mut self,
        display: usize,
        now: Instant,
        events: &[Event],
        counts: &[f32],
        buses: impl FnOnce() -> Vec<String>,
    ) -> bool {
        let asked = self.asked.stop.load(Ordering::Relaxed);
        let of = self.shown.len();
        if display != self.asked.display(of) {
            return asked;
        }
        if let Some(shown) = self.shown.get_mut(display).filter(|s| now >= s.next) {
            shown.next = now + EVERY;
            let view = &mut shown.view;
            view.observe(events.get(shown.told..).unwrap_or_default());
            shown.told = events.len();
            view.now_us = now.as_micros();
            view.which = (of > 1).then_some((display, of));
            view.counts.clear();
            view.counts.extend_from_slice(counts);
            view.buses = buses();
            if let Some(views) = &self.views {
                // Full: it is still drawing, and the next view is newer.
                let _ = views.try_send((view.clone(), Arc::clone(&shown.raster)));
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
fn show(terminal: &Terminal, views: &Receiver<Picture>, asked: &Asked) {
    let mut screen = Ansi::new(BufWriter::new(io::stdout()));
    loop {
        match views.recv_timeout(KEYS) {
            Ok((view, raster)) => {
                let size = terminal.size().unwrap_or(SMALLEST);
                // A terminal that has gone away ends nothing.
                let _ = screen.show(draw(&view, &raster, size));
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return,
        }
        if let Some(key) = terminal.key() {
            asked.key(key);
        }
    }
}

#[cfg(test)]
mod tests;
