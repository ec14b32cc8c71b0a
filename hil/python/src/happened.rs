//! Events of a loop since it was last asked.

use palpate_records::trace::Event;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;

use crate::table::Table;
use crate::tables::{self, About};

/// Events since the last call.
#[pyclass(frozen, module = "palpate._palpate")]
#[derive(Debug)]
pub struct Happened {
    /// The events.
    pub events: Vec<Event>,
    /// Facts of the run that its tables need besides the events.
    pub about: About,
    /// Events before these that were dropped.
    #[pyo3(get)]
    pub dropped: u64,
    /// Virtual time, microseconds.
    #[pyo3(get)]
    pub time_us: u64,
}

#[pymethods]
impl Happened {
    /// The columns of a table of these events.
    fn table(&self, name: &str) -> PyResult<Table> {
        tables::table(name, &self.events, &self.about)
            .ok_or_else(|| PyKeyError::new_err(name.to_owned()))
    }
}
