//! Recorded taxels as the sensor end of a run: rows of counts, or a recording of CAN buses.

use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;
use std::path::{Path, PathBuf};

use embedded_can::ErrorKind;
use palpate_core::bus::{Received, SensorBus};
use palpate_core::skin::{Layout, Module};
use palpate_core::units::Instant;
use palpate_core::wire::can::CanFrame;
use palpate_core::wire::uskin::{IdProfile, Reading, data_frame};

use crate::failure::Failure;
use crate::recording::{
    CanRecording, Columns, TaxelTable, is_can_recording, read_can_recording, read_taxel_csv,
};
use palpate_files::SensorLayout;

use super::skin::unwired;

/// Recorded rows as the frames their boards would have sent, in the codec's own bytes.
#[derive(Clone, Debug)]
pub struct Replay {
    frames: VecDeque<Received>,
    now: Instant,
    end: Instant,
    rows: usize,
    notes: Vec<String>,
}

impl Replay {
    /// Reads one recording a module and lays its rows out as CAN frames, or a recording of all buses.
    ///
    /// # Errors
    /// [`Failure::Input`] with file, line and column.
    pub fn open(
        paths: &[PathBuf],
        file: &SensorLayout,
        layout: &Layout,
        rate_hz: Option<f64>,
    ) -> Result<Self, Failure> {
        if let Some(log) = paths.iter().find(|path| is_can_recording(path)) {
            return match paths {
                [log] => Self::of_log(log, layout),
                _ => Err(Failure::Input(format!(
                    "--replay {}: expected one recording of all buses and nothing beside it, found {} files",
                    log.display(),
                    paths.len()
                ))),
            };
        }
        if paths.len() != layout.modules().len() {
            return Err(Failure::Input(format!(
                "--replay: expected {} files, one a module of layout `{}`, found {}",
                layout.modules().len(),
                file.name,
                paths.len()
            )));
        }
        let (mut frames, mut rows) = (Vec::new(), 0);
        for (number, path) in paths.iter().enumerate() {
            let columns = Columns::of_module(file, number).ok_or_else(|| {
                Failure::Input(format!("layout `{}` has no module {number}", file.name))
            })?;
            let table = read_taxel_csv(path, &columns, rate_hz)?;
            rows = rows.max(table.frames());
            lay_out(&table, &layout.modules()[number], file, &mut frames)?;
        }
        Ok(Self::new(frames, rows))
    }

    fn of_log(path: &Path, layout: &Layout) -> Result<Self, Failure> {
        let addresses = layout.modules().iter().filter_map(Module::address);
        let buses = addresses.map(|a| usize::from(a.bus) + 1).max();
        let CanRecording { frames, notes, .. } = read_can_recording(path, buses.unwrap_or(0))?;
        let mut rows = BTreeMap::new();
        for received in &frames {
            *rows.entry((received.bus, received.frame.id())).or_insert(0) += 1;
        }
        let rows = rows.into_values().max().unwrap_or(0);
        let mut replay = Self::new(frames, rows);
        replay.notes = notes;
        Ok(replay)
    }

    fn new(mut frames: Vec<Received>, rows: usize) -> Self {
        // Stable: what one board sent keeps its order.
        frames.sort_by_key(|r| r.at);
        let end = frames.last().map_or(Instant::ZERO, |r| r.at);
        Self {
            frames: frames.into(),
            now: Instant::ZERO,
            end,
            rows,
            notes: Vec::new(),
        }
    }

    /// What is to be said of the files.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// Lets frames up to `now` be received.
    pub fn advance(&mut self, now: Instant) {
        self.now = self.now.max(now);
    }

    /// When the last frame comes.
    pub const fn end(&self) -> Instant {
        self.end
    }

    /// Rows of the longest file; of a log, frames of the identifier that came most often.
    pub const fn rows(&self) -> usize {
        self.rows
    }
}

/// Appends the frames of one table; a row's frames end at its time, a frame's length apart.
fn lay_out(
    table: &TaxelTable,
    module: &Module,
    file: &SensorLayout,
    frames: &mut Vec<Received>,
) -> Result<(), Failure> {
    const FRAME_US: u64 = 116;
    let refuse = || unwired(&file.name, module.name());
    let address = module.address().ok_or_else(refuse)?;
    let wiring = module.wiring().ok_or_else(refuse)?;
    // Columns run over the active taxels by index, frames over them in wire order.
    let active: Vec<usize> = (0..module.points().len())
        .filter(|&i| module.active()[i])
        .collect();
    let mut order = Vec::with_capacity(active.len());
    for (column, &taxel) in active.iter().enumerate() {
        let place = wiring.place(0, taxel).ok_or_else(refuse)?;
        let id = IdProfile::Current
            .id(address.board, place)
            .ok_or_else(refuse)?;
        order.push((wiring.order(place), column, id));
    }
    order.sort_unstable();
    let axes = usize::from(file.axes);
    let first = table.time_us.first().copied().unwrap_or(0);
    let mut previous = None;
    for (row, &time) in table.time_us.iter().enumerate() {
        // Time starts a scan's length in, so that no frame of the first row lies before zero.
        let end = time - first + FRAME_US * order.len() as u64;
        let room = previous.map_or(end, |p| end - p);
        let step = FRAME_US.min(room / (order.len() as u64 + 1));
        previous = Some(end);
        let Some(counts) = table.frame(row) else {
            break;
        };
        for (k, &(_, column, id)) in order.iter().enumerate() {
            let c = &counts[column * axes..][..axes];
            let reading = match *c {
                [x, y, z] => Reading { x, y, z },
                _ => Reading {
                    x: 0,
                    y: 0,
                    z: c[0],
                },
            };
            let Some(frame) = data_frame(id, reading) else {
                return Err(refuse());
            };
            let at = Instant::from_micros(end - step * (order.len() - 1 - k) as u64);
            frames.push(Received {
                at,
                bus: address.bus,
                frame,
            });
        }
    }
    Ok(())
}

/// A recording has no bus that could fail.
#[derive(Debug)]
pub struct NoError(Infallible);

impl embedded_can::Error for NoError {
    fn kind(&self) -> ErrorKind {
        match self.0 {}
    }
}

impl SensorBus for Replay {
    type Error = NoError;

    fn receive(&mut self) -> Result<Option<Received>, NoError> {
        Ok(self.frames.pop_front_if(|r| r.at <= self.now))
    }

    /// A recording takes no commands.
    fn transmit(&mut self, _bus: u8, _frame: &CanFrame) -> Result<(), NoError> {
        Ok(())
    }
}
