//! A scene or a recording on an emulated bench, to its end.

use std::path::PathBuf;

use palpate_files::{Columns, Timing};
use palpate_hil::command::{rate_of, report, save};
use palpate_live::clock;
use palpate_live::recording::{Reading, recorded};
use palpate_records::digest::{contacts_digest, schedule_digest, trace_digest};
use palpate_records::json::write_json;
use palpate_run::effort::Stopwatch;
use palpate_run::{Failure, Host, Input, Keep, KeptReadings, Outcome, TaxelTable, run_with};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

use crate::errors::{self, free};
use crate::setup::Setup;
use crate::table::Table;
use crate::tables::{self, About};

/// A run that is over.
#[pyclass(frozen, module = "palpate._palpate")]
#[derive(Debug)]
pub struct Run {
    setup: palpate_files::Setup,
    outcome: Outcome,
}

/// Turns between two looks for Ctrl-C: some milliseconds.
const TURNS: u32 = 1024;

/// Ends a run when Python has a signal to raise.
#[derive(Debug, Default)]
pub struct Interruptible {
    turns: u32,
    /// Exception that a signal raised.
    pub raised: Option<PyErr>,
}

impl Host for Interruptible {
    fn stopwatch(&self) -> Option<Stopwatch> {
        Some(clock::elapsed)
    }

    fn passed(&mut self, _part: f64) -> bool {
        self.turns += 1;
        if self.turns.is_multiple_of(TURNS) && self.raised.is_none() {
            self.raised = Python::attach(|py| py.check_signals()).err();
        }
        self.raised.is_some()
    }
}

/// Recorded readings of files, and what there is to say of them.
fn recording(
    paths: &[PathBuf],
    hz: Option<f64>,
    setup: &palpate_files::Setup,
) -> Result<(Input, Vec<String>), Failure> {
    let rate = rate_of(hz, paths)?;
    let reading = Reading {
        timing: Timing {
            rate_hz: rate.hz,
            rest_rows: setup.scene.value.reference_frames as usize + 1,
            ..Timing::default()
        },
        ..Reading::default()
    };
    recorded(paths, &setup.sensor.value, &reading)
}

/// Rows of raw counts of each module: bytes of times (u64) and of counts (u16).
pub fn arrays(setup: &Setup, modules: Vec<(Vec<u8>, Vec<u8>)>) -> PyResult<Vec<TaxelTable>> {
    let sensor = &setup.inner.sensor.value;
    let table = |(number, (times, counts)): (usize, (Vec<u8>, Vec<u8>))| {
        let columns = Columns::of_module(sensor, number).ok_or_else(|| {
            let text = format!("layout `{}` has no module {number}", sensor.name);
            errors::raise("InputError", &text)
        })?;
        Ok(TaxelTable {
            time_us: bytemuck::pod_collect_to_vec(&times),
            counts: bytemuck::pod_collect_to_vec(&counts),
            columns: columns.count(),
        })
    };
    modules.into_iter().enumerate().map(table).collect()
}

/// Runs a setup, in place of its touches from files (one per module, or one of all buses) or from arrays.
#[pyfunction]
pub fn run(
    py: Python<'_>,
    setup: &Bound<'_, Setup>,
    seed: u64,
    files: Vec<PathBuf>,
    rate_hz: Option<f64>,
    rows: Vec<(Vec<u8>, Vec<u8>)>,
) -> PyResult<Run> {
    let setup = setup.get();
    let own = match (files.is_empty(), rows.is_empty()) {
        (false, _) => None,
        (true, false) => Some(Input::tables(arrays(setup, rows)?)),
        (true, true) => Some(Input::Scene),
    };
    let setup = setup.inner.clone();
    let keep = Keep {
        can: true,
        i2c: true,
        audio: false,
        readings: KeptReadings::All,
        spread: true,
        summary: false,
    };
    let mut host = Interruptible::default();
    let run = free(py, || {
        let (input, notes) = match own {
            Some(input) => (input, Vec::new()),
            None => recording(&files, rate_hz, &setup)?,
        };
        let mut outcome = run_with(&setup, &input, seed, keep, &mut host)?;
        outcome.notes.extend(notes);
        outcome.summary.date = Some(clock::date(clock::unix_us()));
        Ok(Run { setup, outcome })
    });
    match host.raised {
        Some(raised) => Err(raised),
        None => run,
    }
}

impl Run {
    /// Outcome of one of several displays, or of all of them.
    fn outcome(&self, display: Option<usize>) -> PyResult<&Outcome> {
        let Some(number) = display else {
            return Ok(&self.outcome);
        };
        let display = self.outcome.displays.get(number);
        display
            .map(|display| &display.outcome)
            .ok_or_else(|| PyKeyError::new_err(number))
    }

    /// The modules that are read for a display, by the skin's numbers.
    fn modules(&self, display: Option<usize>) -> &[u16] {
        let displays = &self.outcome.trace.header.displays;
        let display = display.and_then(|number| displays.get(number));
        display.map_or(&[], |display| &display.modules)
    }
}

#[pymethods]
impl Run {
    /// The columns of a table: of the run, or of one of several displays.
    #[pyo3(signature = (name, display=None))]
    fn table(&self, name: &str, display: Option<usize>) -> PyResult<Table> {
        let outcome = self.outcome(display)?;
        match name {
            "margins" => Ok(tables::margins(&outcome.trace.ledger.margins)),
            "warmth" => Ok(tables::warmth(&outcome.warmth)),
            "taxels" => Ok(tables::taxels(
                outcome.readings.as_ref(),
                self.modules(display),
            )),
            name => tables::table(
                name,
                &outcome.trace.events,
                &About::new(&outcome.trace.header),
            )
            .ok_or_else(|| PyKeyError::new_err(name.to_owned())),
        }
    }

    /// The names of several displays; none where there is one.
    fn displays(&self) -> Vec<String> {
        let displays = self.outcome.displays.iter();
        displays.map(|display| display.name.clone()).collect()
    }

    /// The object that `hil run --json` prints, as text.
    fn summary(&self) -> PyResult<String> {
        let mut text = Vec::new();
        let written = write_json(&self.outcome.summary, &mut text);
        written.map_err(|error| errors::raise("BugError", &error.to_string()))?;
        Ok(String::from_utf8_lossy(&text).into_owned())
    }

    /// Remarks, such as a recording that ends too early.
    fn notes(&self) -> Vec<String> {
        self.outcome.notes.clone()
    }

    /// The report: one page of HTML, of the run or of one of several displays.
    #[pyo3(signature = (display=None))]
    fn html(&self, py: Python<'_>, display: Option<usize>) -> PyResult<String> {
        let outcome = self.outcome(display)?;
        free(py, || Ok(report(outcome)))
    }

    /// First 16 hex digits of the SHA-256 over the whole trace, its contacts, its schedule.
    fn digests(&self) -> (String, String, String) {
        let trace = &self.outcome.trace;
        (
            trace_digest(trace),
            contacts_digest(trace),
            schedule_digest(trace),
        )
    }

    /// Writes a record; the ending says which.
    fn save(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
        free(py, || save(&path, &self.setup, &self.outcome, force))
    }
}
