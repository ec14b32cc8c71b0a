//! Setup of a run: a scene on a bench, with the values that the caller puts in place of the files' own.

use std::path::PathBuf;

use palpate_files::{Loaded, Scene, Source, load_scene};
use palpate_hil::cli::{Buses, RunArgs};
use palpate_hil::command::setup_of;
use palpate_run::{Failure, plan};
use pyo3::prelude::*;

use crate::errors::free;

/// Name in errors of a scene that came as text.
const TEXT: &str = "<scene>";

/// A checked setup.
#[pyclass(frozen, module = "palpate._palpate")]
#[derive(Debug)]
pub struct Setup {
    pub inner: palpate_files::Setup,
}

/// Values that the caller states.
struct Stated {
    scene: Option<String>,
    text: Option<String>,
    args: RunArgs,
}

impl Stated {
    fn read(self) -> Result<Setup, Failure> {
        let scene: Loaded<Scene> = match (self.text, &self.scene, self.args.replay.is_empty()) {
            (Some(text), ..) => Loaded::read(Source::new(TEXT, text))?,
            (None, Some(name), _) => load_scene(name)?,
            (None, None, _) => load_scene("sphere-along")?,
        };
        let inner = setup_of(scene, &self.args)?;
        let inner = match self.args.observe {
            true => inner.observed()?,
            false => inner,
        };
        Ok(Setup { inner })
    }
}

#[pymethods]
impl Setup {
    /// Reads a scene by name, path or text on a bench; `set` are pairs of a key and a value in TOML.
    #[new]
    #[expect(
        clippy::too_many_arguments,
        reason = "keyword arguments of Python, one each"
    )]
    fn new(
        py: Python<'_>,
        scene: Option<String>,
        text: Option<String>,
        bench: Option<String>,
        set: Vec<(String, String)>,
        layout: Option<String>,
        replay: Vec<PathBuf>,
        observe: bool,
    ) -> PyResult<Self> {
        let args = RunArgs {
            scene: scene.clone().or_else(|| text.as_ref().map(|_| TEXT.into())),
            on: Buses {
                bench,
                seed: 1,
                ..Buses::default()
            },
            set: set.iter().map(|(k, v)| format!("{k}={v}")).collect(),
            layout,
            replay,
            observe,
            ..RunArgs::default()
        };
        free(py, || Stated { scene, text, args }.read())
    }

    /// Taxels of each module, and the axes that each is read on.
    fn shape(&self) -> PyResult<(Vec<usize>, usize)> {
        let sensor = &self.inner.sensor.value;
        let layout = plan::layout(sensor).map_err(|failure| crate::errors::exception(&failure))?;
        let taxels = layout.modules().iter().map(|m| m.points().len()).collect();
        Ok((taxels, usize::from(sensor.axes)))
    }

    /// The skin's name.
    fn layout(&self) -> &str {
        &self.inner.sensor.value.name
    }
}
