//! An emulated skin under a scene's touches, as the sensor end of a run.

use palpate_core::bus::SensorBus;
use palpate_core::skin::Layout;
use palpate_core::wire::uskin::{ALL_BOARDS, Command};
use palpate_emulators::board::{BoardConfig, Overload};
use palpate_emulators::can::NodeConfig;
use palpate_emulators::rig::{Handle, SkinBus};
use palpate_emulators::skin::{Generation, Module, ModuleConfig};
use palpate_emulators::time::Nanos;

use super::scripted::Scripted;
use crate::failure::Failure;
use palpate_files::Setup;

/// CAN bit rate of the sensor boards.
const BITRATE: u32 = 1_000_000;

/// The refusal of a module that no board can carry.
pub fn unwired(layout: &str, module: &str) -> Failure {
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
    setup: &Setup,
    layout: &Layout,
    seed: u64,
    repeat: Option<Nanos>,
    host: NodeConfig,
) -> Result<Handle, Failure> {
    let (scene, file) = (&setup.scene.value, &setup.sensor.value);
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
                palpate_files::Generation::Y2019 => Generation::Y2019,
                palpate_files::Generation::Y2021 => Generation::Y2021,
                palpate_files::Generation::Current => Generation::Now,
            },
            noise_lsb: scene.noise_lsb.into(),
            seed,
            ..ModuleConfig::default()
        });
        let lag_s = skin.config().mechanics.lag_s;
        skin.touch(Box::new(Scripted::new(setup, number, seed, lag_s, repeat)));
        let bus = usize::from(address.bus);
        buses.resize_with(buses.len().max(bus + 1), || {
            SkinBus::with_host(BITRATE, host)
        });
        let config = BoardConfig {
            address: address.board,
            wiring,
            scan_hz: scene.rate_hz,
            overload: match scene.boards.overload {
                Some(palpate_files::Overload::Overwrite) => Overload::Overwrite,
                Some(palpate_files::Overload::Wait) | None => Overload::Wait,
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
pub fn emulated(setup: &Setup, layout: &Layout, seed: u64) -> Result<Handle, Failure> {
    let mut handle = boards(setup, layout, seed, None, NodeConfig::default())?;
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
