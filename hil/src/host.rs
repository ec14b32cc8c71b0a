//! What a run is handed from outside here: the wall clock to time frames by, a live view if wanted, and the records
//! that are written while it runs.

use std::path::PathBuf;

use palpate_core::skin::Layout;
use palpate_core::units::Instant;
use palpate_records::mcap::Attachment;
use palpate_records::readings::Readings;
use palpate_records::trace::Header;
use palpate_run::effort::Stopwatch;
use palpate_run::{BusReport, Failure, Host, Passed, TurnView};

use crate::clock;
use crate::output::{Outputs, note};
use crate::progress::Progress;
use crate::record::{About, Kind, Piece, Sink};
use crate::watch::Watch;

/// A clock, and perhaps a live view.
#[derive(Debug, Default)]
pub struct Onlooker {
    /// Whether a live view is wanted; virtual time is then held to the wall clock.
    pub watches: bool,
    watch: Option<Watch>,
    /// Whether a terminal was looked for.
    sought: bool,
    progress: Option<Progress>,
    records: Option<Records>,
    sinks: Vec<Sink>,
}

/// Records that are written while a run goes on.
#[derive(Debug)]
pub struct Records {
    /// What, and where to.
    pub files: Vec<(Kind, PathBuf)>,
    /// The files that the run goes back to.
    pub attachments: Vec<Attachment>,
    /// Whether files that are no earlier outputs may be replaced.
    pub force: bool,
    /// The recordings that the run reads.
    pub inputs: Vec<PathBuf>,
    /// The module that drives.
    pub drives: usize,
}

impl Onlooker {
    /// One that times frames and, if it `watches`, shows the run on a terminal.
    pub fn new(watches: bool, records: Option<Records>) -> Self {
        Self {
            watches,
            records,
            ..Self::default()
        }
    }

    /// Ends the records.
    ///
    /// # Errors
    /// [`Failure::Write`] with the file and what the system said.
    pub fn finish(self) -> Result<(), Failure> {
        self.sinks.into_iter().try_for_each(Sink::finish)
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
        if let Some(watch) = &mut self.watch {
            watch.add(header, layout, end);
        } else if self.watches && !self.sought {
            self.sought = true;
            self.watch = open_watch(header, layout, end, true)?;
        }
        if let Some(records) = &self.records {
            let readings = Readings::whole(layout, records.drives);
            let about = About::Run(header, readings.modules(), &records.attachments);
            let outputs = Outputs {
                force: records.force,
                inputs: &records.inputs,
            };
            self.sinks = Sink::begin_all(&records.files, &about, outputs)?;
        }
        Ok(())
    }

    fn records(&self) -> bool {
        self.records.is_some()
    }

    fn record(&mut self, passed: Passed) -> Result<(), Failure> {
        let piece = Piece::from(passed);
        self.sinks
            .iter_mut()
            .try_for_each(|sink| sink.piece(&piece))
    }

    fn turn(&mut self, seen: &TurnView<'_>) -> bool {
        let Some(watch) = &mut self.watch else {
            return false;
        };
        let buses = || (seen.buses)().iter().map(BusReport::words).collect();
        watch.turn(seen.display, seen.now, seen.events, seen.counts, buses)
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

/// The command line, when and where.
pub fn made() -> Vec<(&'static str, String)> {
    let words = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
    let mut made = vec![
        ("command", words.collect::<Vec<_>>().join(" ")),
        ("palpate", env!("CARGO_PKG_VERSION").to_owned()),
        ("date", clock::date(clock::unix_us())),
    ];
    if let Ok(host) = std::fs::read_to_string("/proc/sys/kernel/hostname") {
        made.push(("host", host.trim().to_owned()));
    }
    made
}
