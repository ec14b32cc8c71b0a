//! What a run is handed from outside here: the wall clock to time frames by, and a live view if wanted.

use palpate_core::skin::Layout;
use palpate_core::units::Instant;
use palpate_records::trace::Header;
use palpate_run::effort::Stopwatch;
use palpate_run::{BusReport, Failure, Host, TurnView};

use crate::clock;
use crate::output::note;
use crate::progress::Progress;
use crate::watch::Watch;

/// A clock, and perhaps a live view.
#[derive(Debug, Default)]
pub struct Onlooker {
    /// Whether a live view is wanted; virtual time is then held to the wall clock.
    pub watches: bool,
    watch: Option<Watch>,
    progress: Option<Progress>,
}

impl Onlooker {
    /// One that times frames and, if it `watches`, shows the run on a terminal.
    pub const fn new(watches: bool) -> Self {
        Self {
            watches,
            watch: None,
            progress: None,
        }
    }
}

impl Host for Onlooker {
    fn stopwatch(&self) -> Option<Stopwatch> {
        Some(clock::elapsed)
    }

    fn looks_on(&self) -> bool {
        self.watches
    }

    fn begin(&mut self, header: &Header, layout: &Layout, end: Instant) -> Result<(), Failure> {
        if self.watches {
            self.watch = open_watch(header, layout, end, true)?;
        }
        Ok(())
    }

    fn turn(&mut self, seen: &TurnView<'_>) -> bool {
        let Some(watch) = &mut self.watch else {
            return false;
        };
        let buses = || (seen.buses)().iter().map(BusReport::words).collect();
        watch.turn(seen.now, seen.events, seen.counts, buses)
    }

    fn passed(&mut self, part: f64) -> bool {
        let progress = &mut self.progress;
        progress
            .get_or_insert_with(|| Progress::of_part("run"))
            .part(part);
        false
    }

    fn end(&mut self) {
        self.watch = None;
        self.progress = None;
    }
}

/// A live view of a run that ends at `end`; without a terminal a note says so, and the run goes on without.
///
/// # Errors
/// [`Failure::Device`] when the system gives no thread.
pub fn open_watch(
    header: &Header,
    layout: &Layout,
    end: Instant,
    virtual_time: bool,
) -> Result<Option<Watch>, Failure> {
    let opened = Watch::open(header, layout, end, virtual_time);
    let opened = opened.map_err(|e| Failure::Device(format!("the live view: {e}")))?;
    if opened.is_none() {
        note(
            "--watch: standard input or output is no terminal; the run goes on without a live view",
        );
    }
    Ok(opened)
}
