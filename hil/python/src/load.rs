//! Files that recordings and records come in, as arrays and tables.

use std::path::PathBuf;

use palpate_files::{Format, Timing, USUAL_BITRATE, format_of, load_skin, read_text};
use palpate_hil::command::rate_of;
use palpate_live::recording::{Reading, read_can_recording, recorded};
use palpate_records::schedule::read_schedule;
use palpate_run::{Failure, Input, damaged};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::errors::free;
use crate::table::Table;
use crate::tables::{self, About};

/// Most bytes of a schedule.
const MOST: u64 = 256 << 20;
/// Most buses of a recording.
const BUSES: usize = 256;

/// Tells the content of a file by its first bytes: `taxels`, `buses`, `schedule`, `contacts`, or none that is read
/// here.
#[pyfunction]
pub fn kind(path: PathBuf) -> Option<&'static str> {
    match format_of(&path)? {
        Format::Csv | Format::Numpy => Some("taxels"),
        Format::Candump | Format::Mcap => Some("buses"),
        Format::Schedule => Some("schedule"),
        Format::Contacts => Some("contacts"),
        _ => None,
    }
}

/// The rows of a module: times (u64) and counts (u16), each as bytes.
type Rows<'py> = (Bound<'py, PyBytes>, Bound<'py, PyBytes>);

/// Recorded rows of a skin, one file per module: of each its times and counts, and the axes of a taxel; and what is to be
/// said of the files.
#[pyfunction]
pub fn load_taxels<'py>(
    py: Python<'py>,
    files: Vec<PathBuf>,
    layout: &str,
    rate_hz: Option<f64>,
) -> PyResult<(Vec<Rows<'py>>, u8, Vec<String>)> {
    let (tables, axes, notes) = free(py, || {
        let sensor = load_skin(layout)?.value;
        let reading = Reading {
            timing: Timing {
                rate_hz: rate_of(rate_hz, &files)?.hz,
                ..Timing::default()
            },
            ..Reading::default()
        };
        let (input, notes) = recorded(&files, &sensor, &reading)?;
        let Input::Rows(sources) = input else {
            return Err(Failure::Input(
                "expected rows of taxels, found frames of buses".into(),
            ));
        };
        let mut tables = Vec::new();
        for source in &sources {
            let mut rows = source.rows()?;
            let (mut times, mut counts, mut row) = (Vec::new(), Vec::new(), Vec::new());
            while let Some(time_us) = rows.next_row(&mut row)? {
                times.push(time_us);
                counts.extend_from_slice(&row);
            }
            tables.push((times, counts));
        }
        Ok((tables, sensor.axes, notes))
    })?;
    let bytes = |(times, counts): (Vec<u64>, Vec<u16>)| {
        (
            PyBytes::new(py, bytemuck::cast_slice(&times)),
            PyBytes::new(py, bytemuck::cast_slice(&counts)),
        )
    };
    Ok((tables.into_iter().map(bytes).collect(), axes, notes))
}

/// Frames of recorded buses, as fast as the buses of `layout` carry them, or else at 1 Mbit/s; and remarks on the file.
#[pyfunction]
pub fn load_buses(
    py: Python<'_>,
    path: PathBuf,
    layout: Option<&str>,
) -> PyResult<(Table, Vec<String>)> {
    free(py, || {
        let skin = layout.map(load_skin).transpose()?;
        let bitrate = skin.map_or(USUAL_BITRATE, |skin| skin.value.bitrate);
        let recording = read_can_recording(&path, (BUSES, bitrate), false)?;
        let frames: Result<Vec<_>, Failure> = recording.frames.frames()?.collect();
        let frames = frames?;
        let hex = |bytes: &[u8]| bytes.iter().map(|b| format!("{b:02x}")).collect::<String>();
        let table = Table::default()
            .with("time_us", &frames, |f| f.at.as_micros())
            .with("bus", &frames, |f| f.bus)
            .with("id", &frames, |f| u32::from(f.frame.id()))
            .with("data", &frames, |f| hex(f.frame.data()));
        Ok((table, recording.notes))
    })
}

/// The stimuli of a schedule, and the bench that it is for.
#[pyfunction]
pub fn load_schedule(py: Python<'_>, path: PathBuf) -> PyResult<(Table, String)> {
    free(py, || {
        let text = read_text(&path, "a schedule", MOST)?;
        let trace = read_schedule(&text, |_| Vec::new())
            .map_err(|damage| damaged(path.display().to_string(), damage))?;
        let about = About::new(&trace.header);
        Ok((tables::stimuli(&trace.events, &about), trace.header.bench))
    })
}
