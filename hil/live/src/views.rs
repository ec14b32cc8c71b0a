//! Views of a run: a terminal (`--watch`), pages (`--serve`), Foxglove (`--foxglove`), a study that can stop it, or none.

use std::path::PathBuf;

use palpate_core::units::{Duration, Instant};
use palpate_files::Format;
use palpate_run::picture::Wants;
use palpate_run::{Beginning, Failure, TurnView, Wish};

use crate::output::{Outputs, note};
use crate::serve::{Desk, Foxglove, FoxgloveRun, Live, LiveRun};
use crate::watch::Watch;

/// Time between two looks of an experimenter at the limits.
const LIMITS_EVERY: Duration = Duration::from_millis(250);

/// Name of a stop by a page, where the stop is kept.
pub const STOPPED_BY_PAGE: &str = "STOP on a page";

/// Views of a run that are open.
#[derive(Debug, Default)]
pub struct Views {
    watch: Option<Watch>,
    /// `true` once a terminal was looked for.
    sought: bool,
    live: Option<LiveRun>,
    foxglove: Option<FoxgloveRun>,
    desk: Option<Desk>,
    /// Time at which the experimenter sees the limits next.
    limits: Instant,
}

/// Views, words and files of a run while it goes on.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted<'a> {
    /// `true` for a view on a terminal, which notes would tear.
    pub watch: bool,
    /// A view in pages.
    pub live: Option<&'a Live>,
    /// A view in Foxglove, of the only display.
    pub foxglove: Option<&'a Foxglove>,
    /// The pages of a study, of which each may stop the run.
    pub desk: Option<&'a Desk>,
    /// `true` where standard error gets errors alone.
    pub quiet: bool,
    /// Files that grow.
    pub files: &'a [(Format, PathBuf)],
    /// Rules for files that those may replace.
    pub outputs: Outputs<'a>,
}

impl Wanted<'_> {
    /// Tells whether any view is wanted.
    pub const fn is_seen(self) -> bool {
        self.watch || self.live.is_some() || self.foxglove.is_some() || self.desk.is_some()
    }

    /// Tells whether a page has said STOP: everything is to go off and stay off, where the stop is kept.
    pub fn is_stopped(self) -> bool {
        self.desk.is_some_and(Desk::is_stopped) || self.live.is_some_and(Live::is_stopped)
    }
}

impl Views {
    /// Opens the wanted views of a run, or adds one more of its displays. Without a terminal a note tells so, and the
    /// run goes on without that view.
    ///
    /// # Errors
    /// [`Failure::Device`] when the system gives no thread.
    pub fn begin(&mut self, wanted: Wanted<'_>, run: &Beginning<'_>) -> Result<(), Failure> {
        if let Some(watch) = &mut self.watch {
            watch.add(run.header, run.projector.layout(), run.end);
        } else if wanted.watch && !self.sought {
            self.sought = true;
            self.watch = open_watch(run)?;
        }
        if let (None, Some(live)) = (&self.live, wanted.live) {
            self.live = Some(LiveRun::begin(live)?);
        }
        if let Some(live) = &mut self.live {
            live.add(run);
        }
        if let Some(foxglove) = wanted.foxglove {
            self.foxglove = Some(FoxgloveRun::begin(foxglove, run)?);
        }
        self.desk = wanted.desk.cloned();
        Ok(())
    }

    /// Tells whether any view is open.
    pub const fn are_open(&self) -> bool {
        self.watch.is_some()
            || self.live.is_some()
            || self.foxglove.is_some()
            || self.desk.is_some()
    }

    /// Wish of a key or a page since the last call.
    pub fn wish(&self) -> Option<Wish> {
        let key = self.watch.as_ref().and_then(Watch::wish);
        key.or_else(|| self.live.as_ref()?.wish())
    }

    /// Shows a turn. Returns whether those who look on want the run to end.
    pub fn turn(&mut self, seen: &TurnView<'_>) -> bool {
        if let Some(desk) = &self.desk {
            if desk.is_stopped() {
                return true;
            }
            if seen.now >= self.limits
                && let Some(used) = (seen.state)(Wants::READINGS).used()
            {
                self.limits = seen.now + LIMITS_EVERY;
                desk.limits(&used);
            }
        }
        if let Some(live) = &mut self.live {
            if live.is_stopped() {
                return true;
            }
            live.turn(seen);
        }
        if let Some(foxglove) = &mut self.foxglove {
            foxglove.turn(seen);
        }
        self.watch.as_mut().is_some_and(|watch| {
            watch.turn(seen.display, seen.now, seen.events, seen.counts, seen.buses)
        })
    }
}

fn open_watch(run: &Beginning<'_>) -> Result<Option<Watch>, Failure> {
    let opened = Watch::open(run.header, run.projector.layout(), run.end);
    let opened = opened.map_err(|e| Failure::Device(format!("the live view: {e}")))?;
    if opened.is_none() {
        note(
            "--watch: standard input or output is no terminal; the run goes on without a live view",
        );
    }
    Ok(opened)
}
