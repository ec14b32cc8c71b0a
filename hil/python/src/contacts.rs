//! Compression alone: the contacts of rows of raw counts, as `hil contacts` finds them.

use std::borrow::Cow;
use std::sync::{Mutex, PoisonError};

use palpate_core::contact::{Levels, Settings};
use palpate_core::skin::BaselineSettings;
use palpate_files::{Columns, axes_named, load_skin, norm, scope};
use palpate_hil::cli::threshold;
use palpate_hil::command::Row;
use palpate_run::{Failure, Intensities, Search, plan};
use pyo3::prelude::*;

use crate::errors::free;
use crate::table::Table;
use crate::tables;

struct State {
    finder: palpate_run::Finder,
    /// Counts per row.
    columns: usize,
    found: Vec<Row>,
    intensities: Intensities,
    /// Levels over all contacts, found at the end.
    levels: Levels,
}

/// Finds the contacts of one piece of a recording after another.
#[pyclass(frozen, module = "palpate._palpate")]
pub struct Finder {
    taxels: usize,
    axes: u8,
    reference_frames: u32,
    vectors: bool,
    state: Mutex<State>,
}

/// Settings as `hil contacts` names them.
#[derive(FromPyObject)]
pub struct Wanted {
    #[pyo3(item)]
    kc: u16,
    #[pyo3(item)]
    reference_frames: u32,
    /// `auto`, `per-taxel`, or a number.
    #[pyo3(item)]
    threshold: String,
    #[pyo3(item)]
    weight_exponent: f64,
    #[pyo3(item)]
    norm: String,
    #[pyo3(item)]
    axes: String,
    #[pyo3(item)]
    scope: String,
    #[pyo3(item)]
    vectors: bool,
    #[pyo3(item)]
    drift_s: Option<f64>,
    #[pyo3(item)]
    faulty_deviations: Option<f64>,
    #[pyo3(item)]
    skip_repeats: bool,
    #[pyo3(item)]
    seed: u64,
}

fn named<T>(what: &str, read: Result<T, String>) -> Result<T, Failure> {
    read.map_err(|text| Failure::Input(format!("{what}: {text}")))
}

impl Wanted {
    fn search(&self) -> Result<Search, Failure> {
        let threshold = threshold(&self.threshold).map_err(|_| {
            Failure::Input(format!(
                "threshold: expected \"auto\", \"per-taxel\" or raw counts from 0 to 1000000, found {}",
                self.threshold
            ))
        })?;
        Ok(Search {
            baseline: BaselineSettings {
                reference_frames: self.reference_frames,
                fault_sigmas: self.faulty_deviations.map(|k| k as f32),
                threshold: threshold.rule(),
                axes: named("axes", axes_named(&self.axes))?,
                drift: threshold.drift(self.drift_s),
            },
            compression: Settings {
                clusters: self.kc,
                exponent: self.weight_exponent as f32,
                norm: named("norm", norm(&self.norm))?,
                scope: named("scope", scope(&self.scope))?,
                seed: self.seed,
                vectors: self.vectors,
                ..Settings::default()
            },
            skips_repeats: self.skip_repeats,
        })
    }
}

/// Values of bytes: as they lie there, which Python's do, else in a copy.
fn values<T: bytemuck::Pod>(bytes: &[u8]) -> Cow<'_, [T]> {
    match bytemuck::try_cast_slice(bytes) {
        Ok(values) => Cow::Borrowed(values),
        Err(_) => Cow::Owned(bytemuck::pod_collect_to_vec(bytes)),
    }
}

#[pymethods]
impl Finder {
    /// Finder for recordings of this skin.
    #[new]
    fn new(py: Python<'_>, layout: &str, wanted: Wanted) -> PyResult<Self> {
        free(py, || {
            let file = &load_skin(layout)?.value;
            let columns = Columns::of_skin(file);
            let skin = plan::layout(file)?;
            let finder = palpate_run::Finder::new(&skin, &columns, wanted.search()?)?;
            Ok(Self {
                taxels: columns.taxels,
                axes: columns.axes,
                reference_frames: wanted.reference_frames,
                vectors: wanted.vectors,
                state: Mutex::new(State {
                    finder,
                    columns: columns.count(),
                    found: Vec::new(),
                    intensities: Intensities::default(),
                    levels: Levels::Off,
                }),
            })
        })
    }

    /// Taxels per row and their axes.
    fn shape(&self) -> (usize, u8) {
        (self.taxels, self.axes)
    }

    /// Goes through rows: bytes of their times (u64, microseconds) and of their counts (u16).
    fn rows(&self, py: Python<'_>, times: &[u8], counts: &[u8]) -> PyResult<()> {
        let (times, counts) = (values::<u64>(times), values::<u16>(counts));
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let state = &mut *state;
        free(py, || {
            for (time_us, row) in times.iter().zip(counts.chunks_exact(state.columns)) {
                let frame = u32::try_from(state.finder.rows()).unwrap_or(u32::MAX);
                for &contact in state.finder.row(*time_us, row)? {
                    state.intensities.add(&contact);
                    state.found.push(Row {
                        time_us: *time_us,
                        frame,
                        contact,
                    });
                }
            }
            Ok(())
        })
    }

    /// Ends the recording: finds `ki` levels over all contacts, and says how many there are.
    fn end(&self, py: Python<'_>, ki: usize) -> PyResult<usize> {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let state = &mut *state;
        let needed = self.reference_frames as usize + 1;
        free(py, || {
            if state.finder.rows() < needed {
                return Err(Failure::Input(format!(
                    "counts: expected at least {needed} rows ({} for the reference, one for the threshold), found {}",
                    self.reference_frames,
                    state.finder.rows()
                )));
            }
            state.levels = std::mem::take(&mut state.intensities).levels(ki, self.vectors);
            Ok(state.found.len())
        })
    }

    /// Returns `count` contacts from `begin` on. Python fetches them piece by piece, so that they are not in memory
    /// twice.
    fn contacts(&self, py: Python<'_>, begin: usize, count: usize) -> PyResult<Table> {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let state = &*state;
        free(py, || {
            let recorded = |row: &Row| row.recorded(state.levels.level(&row.contact));
            let found = state.found.iter().skip(begin).take(count);
            Ok(tables::contacts(&found.map(recorded).collect::<Vec<_>>()))
        })
    }
}
