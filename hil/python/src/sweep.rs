//! Many runs: the table of a sweep that the caller's executor fills, and a batch of runs as its workers compute it.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use palpate_hil::sweep::{Growing, Work};
use palpate_live::output::Outputs;
use palpate_records::runs::{RunTable, TableForm};
use palpate_run::Failure;
use palpate_run::sweep::{Axis, Grid, Variant};
use pyo3::prelude::*;

use crate::errors::free;
use crate::run::Interruptible;
use crate::setup::Setup;

struct State {
    work: Work,
    /// The table, until the sweep is over.
    table: Option<Growing>,
}

/// The table of a sweep: what it has, what it lacks.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct Sweep(Mutex<State>);

fn ended() -> Failure {
    Failure::Input("sweep: expected a table that is open, found one that is finished".into())
}

#[pymethods]
impl Sweep {
    /// Opens or makes the table of a grid: keys with their values, and seeds.
    #[new]
    fn new(
        py: Python<'_>,
        base: &Bound<'_, Setup>,
        axes: Vec<(String, Vec<String>)>,
        seeds: Vec<u64>,
        out: PathBuf,
        force: bool,
    ) -> PyResult<Self> {
        let base = base.get().inner.clone();
        free(py, || {
            let axes = axes.into_iter().map(|(key, values)| Axis { key, values });
            let grid = Grid::new(axes.collect(), seeds)?;
            let outputs = Outputs::new(force);
            Growing::check(&out, outputs)?;
            let mut work = Work::read(&base, grid, None)?;
            let table = Some(work.open(&out, outputs)?);
            Ok(Self(Mutex::new(State { work, table })))
        })
    }

    /// Combinations and seeds of the runs that the table lacks, in the order of the grid.
    fn lacking(&self) -> Vec<(usize, u64)> {
        self.within(|state| state.work.lacking())
    }

    /// The values of a combination, by key.
    fn set(&self, combination: usize) -> Vec<(String, String)> {
        self.within(|state| state.work.grid().set(combination).into_iter().collect())
    }

    /// Adds the row of a run that a worker computed: a line of JSON.
    fn add(&self, py: Python<'_>, combination: usize, seed: u64, line: &str) -> PyResult<()> {
        free(py, || {
            self.within(|state| {
                let read = RunTable::read(line).ok().map(|table| table.rows);
                let row = read.and_then(|mut rows| rows.pop());
                let row = row.ok_or_else(|| {
                    Failure::Input(format!("a worker: expected a row of a sweep, found {line}"))
                })?;
                let key = state.work.key(combination, seed);
                if key.as_ref() != Some(&row.key) {
                    let expected = key.unwrap_or_default();
                    return Err(Failure::Input(format!(
                        "a worker: expected palpate {} with the driver's files (digest {}), found palpate {} and digest {}",
                        expected.version, expected.digest, row.key.version, row.key.digest
                    )));
                }
                let table = state.table.as_mut().ok_or_else(ended)?;
                table.add(&row)?;
                state.work.take(vec![row]);
                Ok(())
            })
        })
    }

    /// Puts the rows in the order of the grid, and hands them out as lines of JSON.
    fn finish(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        free(py, || {
            self.within(|state| {
                let table = state.table.take().ok_or_else(ended)?;
                state.work.finish(table)?;
                let rows = state.work.there();
                Ok(rows
                    .into_iter()
                    .map(|row| TableForm::Lines.line(row))
                    .collect())
            })
        })
    }

    /// Lets the table go as it is: its rows stay in the order in which they came.
    fn close(&self) {
        self.within(|state| state.table = None);
    }
}

impl Sweep {
    fn within<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The rows of a combination's runs with these seeds, as lines of JSON.
#[pyfunction]
pub fn sweep_rows(
    py: Python<'_>,
    base: &Bound<'_, Setup>,
    set: Vec<(String, String)>,
    seeds: Vec<u64>,
) -> PyResult<Vec<String>> {
    let base = base.get().inner.clone();
    let mut host = Interruptible::default();
    let rows = free(py, || {
        let variant = Variant::new(&base, set.into_iter().collect())?;
        let mut rows = Vec::with_capacity(seeds.len());
        for seed in seeds {
            let row = variant.row(seed, &mut host)?;
            if host.raised.is_some() {
                break;
            }
            rows.push(TableForm::Lines.line(&row));
        }
        Ok(rows)
    });
    match host.raised {
        Some(raised) => Err(raised),
        None => rows,
    }
}
