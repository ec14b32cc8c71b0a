//! What a run is handed from outside here: the wall clock to time frames by, live views if wanted, and the records
//! that are written while it runs.

use std::path::PathBuf;

use palpate_buses::pacer::RunClock;
use palpate_buses::signals::Signals;
use palpate_records::mcap::Attachment;
use palpate_records::readings::Readings;
use palpate_run::effort::Stopwatch;
use palpate_run::{Beginning, Failure, Host, Passed, TurnView};

use crate::clock;
use crate::output::Outputs;
use crate::progress::Progress;
use crate::record::{About, Kind, Piece, Sink};
use crate::views::{Views, Wanted};

/// A clock, and perhaps live views.
#[derive(Debug, Default)]
pub struct Onlooker<'a> {
    /// The live views that are wanted; virtual time is then held to the wall clock.
    wanted: Wanted<'a>,
    views: Views,
    pace: Option<Pace>,
    progress: Option<Progress>,
    records: Option<Records>,
    sinks: Vec<Sink>,
}

/// What holds a run in virtual time to the wall clock, and what ends it meanwhile.
#[derive(Debug)]
struct Pace {
    clock: RunClock,
    signals: Signals,
}

impl Pace {
    fn start() -> Result<Self, Failure> {
        let signals = Signals::catch().map_err(|e| Failure::Device(format!("signals: {e}")))?;
        let clock = RunClock::start();
        Ok(Self { clock, signals })
    }
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

impl<'a> Onlooker<'a> {
    /// One that times frames, and shows the run as it is wanted.
    pub fn new(wanted: Wanted<'a>, records: Option<Records>) -> Self {
        Self {
            wanted,
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

impl Host for Onlooker<'_> {
    fn stopwatch(&self) -> Option<Stopwatch> {
        Some(clock::elapsed)
    }

    fn looks_on(&self) -> bool {
        self.wanted.any()
    }

    fn begin(&mut self, run: &Beginning<'_>) -> Result<(), Failure> {
        self.views.begin(self.wanted, run)?;
        if self.views.are_open() && self.pace.is_none() {
            self.pace = Some(Pace::start()?);
        }
        let (header, layout) = (run.header, run.projector.layout());
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
        let Some(pace) = &self.pace else {
            return false;
        };
        pace.clock.sleep_until(seen.now);
        self.views.turn(seen).is_some() || pace.signals.caught().is_some()
    }

    fn passed(&mut self, part: f64) -> bool {
        let progress = &mut self.progress;
        progress
            .get_or_insert_with(|| Progress::of_part("run"))
            .part(part);
        false
    }

    fn end(&mut self) {
        self.views = Views::default();
        self.progress = None;
    }
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
