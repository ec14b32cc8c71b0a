//! Cost of recording: a minute of a hand of 240 taxels, each record written to a file; and the time that handing a
//! turn over to the journal takes from the loop.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration as Wall;

use palpate_core::units::Duration;
use palpate_records::contacts_csv::write_table;
use palpate_records::mcap::{BusTraffic, write_mcap};
use palpate_records::schedule::write_schedule;
use palpate_records::trace::Event;
use palpate_records::vcd::write_vcd;

use palpate_files::{Format, Setup};
use palpate_live::clock;
use palpate_live::output::{Outputs, write_file};
use palpate_live::record::{About, Journal, Sink};
use palpate_live::recording::write_can_log;
use palpate_run::{Failure, Input, Keep, KeptReadings, Outcome, attachments, run_with};

use crate::findings::Findings;
use crate::timing::{Race, Samples};

/// Length of the run, seconds.
const LENGTH_S: f64 = 60.0;
const CASE: &str = "hand, 60 s";

fn device(error: &dyn std::fmt::Display) -> Failure {
    Failure::Device(error.to_string())
}

/// The scene on four buses, touched for its whole minute.
fn setup() -> Result<Setup, Failure> {
    let mut setup = Setup::load("allegro-four-buses", "emulated")?;
    let scene = &mut setup.scene.value;
    scene.length_s = LENGTH_S;
    for touch in &mut scene.touches {
        touch.end_s = LENGTH_S;
    }
    Ok(setup)
}

/// Everything of a run.
const ALL: Keep = Keep {
    spread: false,
    can: true,
    i2c: true,
    audio: false,
    readings: KeptReadings::All,
    summary: false,
};

fn write(format: Format, path: &Path, setup: &Setup, outcome: &Outcome) -> Result<(), Failure> {
    write_file(path, |out| match format {
        Format::Contacts => write_table(&outcome.trace, out),
        Format::Schedule => write_schedule(&outcome.trace, out),
        Format::Candump => write_can_log(&outcome.can, &[], out),
        Format::Vcd => write_vcd(&outcome.trace, out),
        _ => {
            let traffic = BusTraffic {
                can: &outcome.can,
                i2c: &outcome.i2c,
                ..BusTraffic::default()
            };
            let run = (&outcome.trace, outcome.readings.as_ref());
            write_mcap(run, traffic, &attachments(setup), out)
        }
    })
}

const FORMATS: [(Format, &str); 5] = [
    (Format::Mcap, "mcap"),
    (Format::Candump, "log"),
    (Format::Vcd, "vcd"),
    (Format::Contacts, "csv"),
    (Format::Schedule, "jsonl"),
];

/// Measures every record.
///
/// # Errors
/// [`Failure`] for a run that cannot be built, or a full disk.
pub fn measure() -> Result<Findings, Failure> {
    let folder = std::env::temp_dir().join(format!("palpate-bench-{}", std::process::id()));
    fs::create_dir_all(&folder).map_err(|e| device(&e))?;
    let found = measured(&folder);
    // Best effort: what matters is known.
    let _ = fs::remove_dir_all(&folder);
    found
}

fn measured(folder: &Path) -> Result<Findings, Failure> {
    let setup = setup()?;
    let run = |keep| run_with(&setup, &Input::Scene, 1, keep, &mut ());
    let outcome = run(ALL)?;
    let path = |ending: &str| folder.join(format!("a.{ending}"));
    let mut race = Race::default();
    race.enter(|| run(Keep::default()).map(drop));
    race.enter(|| run(ALL).map(drop));
    for (format, ending) in FORMATS {
        let (outcome, setup, path) = (&outcome, &setup, path(ending));
        race.enter(move || write(format, &path, setup, outcome));
    }
    let samples = race.run(7, Wall::from_secs(20));
    let (alone, keeping) = (samples[0].median(), samples[1].median());
    let mut found = Findings::new("records");
    found.row(CASE, "default", (0.0, "MB"), alone);
    let kept = (keeping - alone).max(0.0);
    found.row(CASE, "frames and transfers kept", (0.0, "MB"), kept);
    for ((format, ending), samples) in FORMATS.iter().zip(&samples[2..]) {
        write(*format, &path(ending), &setup, &outcome)?;
        let bytes = fs::metadata(path(ending)).map_err(|e| device(&e))?.len();
        let size = bytes as f64 * 1e-6;
        found.row(CASE, ending, (size, "MB"), samples.median());
        let real = samples.median() / (LENGTH_S * 1e6) * 100.0;
        let computed = samples.median() / alone * 100.0;
        found.words.push(format!(
            "{ending}: {size:.1} MB; {real:.2} % of the minute that is recorded, {computed:.0} % of the {:.2} s in which it is emulated",
            alone * 1e-6
        ));
    }
    let turn = turns(&setup, &outcome, &path("mcap"))?;
    let share = turn.sum_us / (LENGTH_S * 1e6) * 100.0;
    found.words.push(format!(
        "handing over to the journal: {:.2} us per turn, 99 % in {:.2} us; {share:.3} % of the loop's time (at most 2)",
        turn.samples.median(),
        turn.samples.quantile(0.99)
    ));
    let case = "a turn of the loop, 24 frames";
    let error = (share, "% of the loop");
    found.row(case, "default", error, turn.samples.median());
    Ok(found)
}

struct Turns {
    samples: Samples,
    sum_us: f64,
}

/// The minute again, turn by turn as a real run hands it over.
fn turns(setup: &Setup, outcome: &Outcome, path: &Path) -> Result<Turns, Failure> {
    let files = [(Format::Mcap, PathBuf::from(path))];
    let attached = attachments(setup);
    let sinks = Sink::create_all(
        &files,
        &About::Run(&outcome.trace.header, &[], &attached),
        Outputs::default(),
    )?;
    let mut journal = Journal::start(sinks, false)?;
    let (mut samples, mut sum_us) = (Samples::default(), 0.0);
    let (mut told, mut sent, mut now) = (0, 0, Duration::from_millis(0));
    while told < outcome.trace.events.len() || sent < outcome.can.len() {
        now = Duration::from_micros(now.as_micros() + 1000);
        let (begin, until) = (sent, now.as_micros());
        while outcome
            .can
            .get(sent)
            .is_some_and(|r| r.at.as_micros() < until)
        {
            sent += 1;
        }
        let past = |e: &&Event| e.t_ns() < until * 1000;
        let events = &outcome.trace.events[told..];
        let events = &events[..events.iter().take_while(past).count()];
        told += events.len();
        let frames = outcome.can[begin..sent].to_vec();
        let begun = clock::now();
        journal.add(events, frames, Vec::new());
        let us = begun.elapsed().as_secs_f64() * 1e6;
        samples.push(us);
        sum_us += us;
    }
    journal.finish()?;
    Ok(Turns { samples, sum_us })
}
