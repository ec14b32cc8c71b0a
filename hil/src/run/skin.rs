//! The sensor ends of a run: an emulated skin under a scene's touches, or recorded rows.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::path::PathBuf;

use embedded_can::ErrorKind;
use palpate_core::bus::{Received, SensorBus};
use palpate_core::skin::Layout;
use palpate_core::units::{Instant, Point};
use palpate_core::wire::can::CanFrame;
use palpate_core::wire::uskin::{ALL_BOARDS, Command, IdProfile, Reading, data_frame};
use palpate_emulators::board::{BoardConfig, Overload};
use palpate_emulators::can::NodeConfig;
use palpate_emulators::rig::{Handle, SkinBus};
use palpate_emulators::skin::{Generation, Module, ModuleConfig, Touch as Press};
use palpate_emulators::time::Nanos;

use crate::failure::Failure;
use crate::files::{self, Columns, Scene, SensorLayout, TaxelTable, read_taxel_csv};

/// CAN bit rate of the sensor boards.
const BITRATE: u32 = 1_000_000;

fn unwired(layout: &str, module: &str) -> Failure {
    Failure::Input(format!(
        "layout `{layout}`: module `{module}`: expected a bus, a board, and at most 8 rows of 8 taxels; \
         a larger skin has no emulated board"
    ))
}

/// Emulated boards with the scene's touches on them, which wait for their commands. With `repeat` the
/// touches begin anew after each such span; `host` is the host's controller on every bus.
///
/// # Errors
/// [`Failure::Input`] for a layout whose modules no board can carry.
pub fn boards(
    scene: &Scene,
    file: &SensorLayout,
    layout: &Layout,
    seed: u64,
    repeat: Option<Nanos>,
    host: NodeConfig,
) -> Result<Handle, Failure> {
    let mut buses: Vec<SkinBus> = Vec::new();
    for (number, module) in layout.modules().iter().enumerate() {
        let refuse = || unwired(&file.name, module.name());
        let address = module.address().ok_or_else(refuse)?;
        let wiring = module
            .wiring()
            .filter(|w| w.taxels() == module.points().len());
        let wiring = wiring.ok_or_else(refuse)?;
        let mut skin = Module::new(ModuleConfig {
            number,
            taxels: module.points().to_vec(),
            unread: (0..module.points().len())
                .filter(|&t| !module.active()[t])
                .collect(),
            pitch_mm: f64::from(module.spacing()),
            generation: match scene.generation {
                files::Generation::Y2019 => Generation::Y2019,
                files::Generation::Y2021 => Generation::Y2021,
                files::Generation::Current => Generation::Now,
            },
            noise_lsb: scene.noise_lsb.into(),
            seed,
            ..ModuleConfig::default()
        });
        let touches: Vec<_> = scene
            .touches
            .iter()
            .filter(|t| t.module == number)
            .cloned()
            .collect();
        skin.touch(Box::new(move |now: Nanos, out: &mut Vec<Press>| {
            let now = repeat.map_or(now, |span| Nanos(now.0 % span.0.max(1)));
            out.extend(
                touches
                    .iter()
                    .filter_map(|t| t.at(now.as_secs_f64()))
                    .map(|t| Press {
                        at: Point::new(t.x_mm as f32, t.y_mm as f32),
                        force_n: t.force_n,
                        diameter_mm: t.diameter_mm,
                    }),
            );
        }));
        let bus = usize::from(address.bus);
        buses.resize_with(buses.len().max(bus + 1), || {
            SkinBus::with_host(BITRATE, host)
        });
        let config = BoardConfig {
            address: address.board,
            wiring,
            scan_hz: scene.rate_hz,
            overload: match scene.boards.overload {
                Some(files::Overload::Overwrite) => Overload::Overwrite,
                Some(files::Overload::Wait) | None => Overload::Wait,
            },
            ..BoardConfig::default()
        };
        buses[bus].add_board(config, vec![skin]).map_err(|e| {
            Failure::Input(format!(
                "layout `{}`: module `{}`: {e}",
                file.name,
                module.name()
            ))
        })?;
    }
    Ok(Handle::new(buses))
}

/// Emulated boards with the scene's touches on them, sending from the start.
///
/// # Errors
/// As [`boards`].
pub fn emulated(
    scene: &Scene,
    file: &SensorLayout,
    layout: &Layout,
    seed: u64,
) -> Result<Handle, Failure> {
    let mut handle = boards(scene, file, layout, seed, None, NodeConfig::default())?;
    start(&mut handle)?;
    Ok(handle)
}

/// Sends the start command on every bus.
///
/// # Errors
/// [`Failure::Device`] for a bus whose host takes no command.
pub fn start(handle: &mut Handle) -> Result<(), Failure> {
    let count = handle.with(|buses| buses.len());
    let start = Command {
        board: ALL_BOARDS,
        start: true,
    }
    .encode();
    for bus in 0..count {
        let sent = start
            .as_ref()
            .map(|frame| handle.transmit(bus as u8, frame));
        if !matches!(sent, Some(Ok(()))) {
            return Err(Failure::Device(format!(
                "sensor bus {bus}: the start command was not taken"
            )));
        }
    }
    Ok(())
}

/// Recorded rows as the frames their boards would have sent, in the codec's own bytes.
#[derive(Debug)]
pub struct Replay {
    frames: VecDeque<Received>,
    now: Instant,
    end: Instant,
    rows: usize,
}

impl Replay {
    /// Reads one recording a module and lays its rows out as CAN frames.
    ///
    /// # Errors
    /// [`Failure::Input`] with file, line and column.
    pub fn open(
        paths: &[PathBuf],
        file: &SensorLayout,
        layout: &Layout,
        rate_hz: Option<f64>,
    ) -> Result<Self, Failure> {
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
        // Stable: what one board sent keeps its order.
        frames.sort_by_key(|r| r.at);
        let end = frames.last().map_or(Instant::ZERO, |r| r.at);
        Ok(Self {
            frames: frames.into(),
            now: Instant::ZERO,
            end,
            rows,
        })
    }

    /// Lets frames up to `now` be received.
    pub fn advance(&mut self, now: Instant) {
        self.now = self.now.max(now);
    }

    /// When the last frame comes.
    pub const fn end(&self) -> Instant {
        self.end
    }

    /// Rows of the longest file.
    pub const fn rows(&self) -> usize {
        self.rows
    }
}

/// Appends the frames of one table; a row's frames end at its time, a frame's length apart.
fn lay_out(
    table: &TaxelTable,
    module: &palpate_core::skin::Module,
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
