//! A run on any bench, with the host of one in virtual time: the wall clock to time frames by, live views if wanted,
//! and the records that are written while it runs.

use palpate_buses::pacer::RunClock;
use palpate_buses::signals::Signals;
use palpate_emulators::worn::Aside;
use palpate_files::Setup;
use palpate_records::readings::Readings;
use palpate_run::effort::Stopwatch;
use palpate_run::pass::PassReport;
use palpate_run::{
    Beginning, Failure, Host, Input, Keep, Outcome, Piece, TurnView, Wish, attachments, run_with,
};

use crate::progress::Progress;
use crate::record::{About, Sink};
use crate::views::{Views, Wanted};
use crate::{clock, real};

/// Runs a scene or a recording on its bench, hardware or emulated. An emulated run keeps what `keep` says; with a view
/// its virtual time is held to the wall clock.
///
/// # Errors
/// The errors of [`run_with`] and [`real::run`]; [`Failure::Write`] for a file that grows.
pub fn run(
    setup: &Setup,
    input: &Input,
    seed: u64,
    keep: Keep,
    wanted: Wanted<'_>,
) -> Result<Outcome, Failure> {
    if setup.bench.value.is_hardware() {
        return real::run(setup, input, seed, wanted);
    }
    let mut host = Onlooker {
        wanted,
        ..Onlooker::default()
    };
    let outcome = run_with(setup, input, seed, keep, &mut host)?;
    host.sinks.into_iter().try_for_each(Sink::finish)?;
    Ok(outcome)
}

/// Passes the wires of a setup that need it, with the wanted views. Returns the setup of what follows and, where there was a
/// pass, the report on it.
///
/// # Errors
/// The errors of [`run()`].
pub fn passed(
    setup: &Setup,
    seed: u64,
    wanted: Wanted<'_>,
) -> Result<(Setup, Option<PassReport>), Failure> {
    let (after, report) = match setup.bench.value.is_hardware() {
        true => real::passed(setup, &Input::Scene, seed, wanted)?,
        false => palpate_run::passed(setup, seed)?,
    };
    Ok((after.into_owned(), report))
}

/// The host of an emulated run: a clock, and perhaps live views and records.
#[derive(Debug, Default)]
struct Onlooker<'a> {
    wanted: Wanted<'a>,
    views: Views,
    pace: Option<Pace>,
    progress: Option<Progress>,
    sinks: Vec<Sink>,
}

/// Pace of a run in virtual time by the wall clock, and signals that end it.
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

impl Host for Onlooker<'_> {
    fn stopwatch(&self) -> Option<Stopwatch> {
        Some(clock::elapsed)
    }

    fn aside(&self) -> Option<Aside> {
        Some(|work| {
            let thread = std::thread::Builder::new().name("wires beside".to_owned());
            thread.spawn(work).is_ok()
        })
    }

    fn looks_on(&self) -> bool {
        self.wanted.is_seen()
    }

    fn begin(&mut self, run: &Beginning<'_>) -> Result<(), Failure> {
        self.views.begin(self.wanted, run)?;
        if self.views.are_open() && self.pace.is_none() {
            self.pace = Some(Pace::start()?);
        }
        if self.records() {
            let drives = run.setup.scene.value.drives;
            let readings = Readings::whole(run.projector.layout(), drives);
            let attached = attachments(run.setup);
            let about = About::Run(run.header, readings.modules(), &attached);
            self.sinks = Sink::begin_all(self.wanted.files, &about, self.wanted.outputs)?;
        }
        Ok(())
    }

    fn records(&self) -> bool {
        !self.wanted.files.is_empty()
    }

    fn record(&mut self, piece: Piece) -> Result<(), Failure> {
        self.sinks
            .iter_mut()
            .try_for_each(|sink| sink.piece(&piece))
    }

    fn turn(&mut self, seen: &TurnView<'_>) -> bool {
        let Some(pace) = &self.pace else {
            return false;
        };
        pace.clock.sleep_until(seen.now);
        self.views.turn(seen) || pace.signals.caught().is_some()
    }

    fn wish(&mut self) -> Option<Wish> {
        self.views.wish()
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
