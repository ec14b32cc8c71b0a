//! An emulated skin under a scene's touches, as the sensor end of a run.

use palpate_core::bus::CanBus;
use palpate_core::codec::uskin::{ALL_BOARDS, Command, Wiring};
use palpate_core::skin::{CanSkin, Layout, Module, Protocol};
use palpate_emulators::sensor::board::{BoardConfig, Overload};
use palpate_emulators::sensor::can::NodeConfig;
use palpate_emulators::sensor::can::faults::Faulty;
use palpate_emulators::sensor::rig::{Handle, SkinBus};
use palpate_emulators::sensor::{
    Delivery, EmulatedModule, Generation, ModuleConfig, SkinArray, Touches, Transducer,
};
use palpate_emulators::time::Nanos;

use super::scripted::Scripted;
use crate::failure::Failure;
use crate::fingers::Fingers;
use crate::hand::Hand;
use crate::plan;
use crate::skin_end::{SkinEnd, Tap};
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
    touched(
        setup,
        layout,
        seed,
        host,
        scripted(setup, seed, repeat, None),
    )
}

/// The scene's touches on each module, and those of fingers that join it.
fn scripted(
    setup: &Setup,
    seed: u64,
    repeat: Option<Nanos>,
    fingers: Option<&Fingers>,
) -> impl Fn(usize) -> Box<dyn Touches + Send> {
    let lag_s = ModuleConfig::default().mechanics.lag_s;
    move |module| Box::new(Scripted::new(setup, module, seed, lag_s, repeat, fingers))
}

fn touched(
    setup: &Setup,
    layout: &Layout,
    seed: u64,
    host: NodeConfig,
    touches: impl Fn(usize) -> Box<dyn Touches + Send>,
) -> Result<Handle, Failure> {
    let (scene, file) = (&setup.scene.value, &setup.sensor.value);
    let mut buses: Vec<SkinBus> = Vec::new();
    for (number, module) in layout.modules().iter().enumerate() {
        let refuse = || unwired(&file.name, module.name());
        let address = module.address().ok_or_else(refuse)?;
        let protocol = module.protocol();
        let wiring = match protocol {
            Protocol::Mtb => Wiring::FLAT, // of no meaning there
            Protocol::Uskin => module
                .wiring()
                .filter(|w| w.taxels() == module.points().len())
                .ok_or_else(refuse)?,
        };
        let skin = pressed(setup, (number, module), seed, touches(number));
        let bus = usize::from(address.bus);
        buses.resize_with(buses.len().max(bus + 1), || {
            SkinBus::with_host(BITRATE, host)
        });
        let config = BoardConfig {
            address: address.board,
            protocol,
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

/// An emulated module of a scene's layout under touches.
fn pressed(
    setup: &Setup,
    (number, module): (usize, &Module),
    seed: u64,
    touches: Box<dyn Touches + Send>,
) -> EmulatedModule {
    let scene = &setup.scene.value;
    let transducer = match setup.sensor.value.transducer {
        palpate_files::Transducer::Magnetic => Transducer::Magnetic(match scene.generation {
            palpate_files::Generation::Y2019 => Generation::Y2019,
            palpate_files::Generation::Y2021 => Generation::Y2021,
            palpate_files::Generation::Current => Generation::Now,
        }),
        palpate_files::Transducer::Capacitive => Transducer::Capacitive,
        palpate_files::Transducer::Camera => Transducer::Camera,
        palpate_files::Transducer::Cells => Transducer::Cells,
    };
    let mut skin = EmulatedModule::new(ModuleConfig {
        number,
        taxels: module.points().to_vec(),
        unread: (0..module.points().len())
            .filter(|&t| !module.active()[t])
            .collect(),
        pitch_mm: f64::from(module.spacing()),
        transducer,
        mechanics: transducer.silicone(),
        noise_lsb: scene.noise_lsb.into(),
        seed,
        ..ModuleConfig::default()
    });
    skin.touch(touches);
    skin
}

/// An emulated skin of any kind: boards on sensor buses, or whole scans of a skin that no bus carries.
pub type EmulatedSkin = Box<dyn SkinEnd + Send>;

/// Tells whether a scene's readings come without an emulated bus: over a network, or from a skin that no board sends.
pub fn is_array(setup: &Setup) -> bool {
    let modules = &setup.sensor.value.modules;
    setup.scene.value.stream.is_some() || modules.iter().all(|m| m.bus.is_none())
}

/// A scene's skin with its touches and those of fingers on it, sending from the start.
///
/// # Errors
/// The errors of [`boards`]; [`Failure::File`] for a fault that needs a sensor bus where there is none.
pub fn scene(setup: &Setup, seed: u64, fingers: Option<&Fingers>) -> Result<EmulatedSkin, Failure> {
    let layout = plan::layout(&setup.sensor.value)?;
    let mut faults = setup.scene.value.faults.iter();
    if is_array(setup)
        && let Some(index) = faults.position(|f| f.kind.is_of_sensors())
    {
        let key = format!("faults[{index}].kind");
        let expected = "a fault of the display: the readings of this scene come over no sensor bus";
        return Err(Failure::File(setup.scene.source.bad(&key, expected)));
    }
    under(setup, &layout, seed, scripted(setup, seed, None, fingers))
}

/// A scene's skin, sending from the start, each module under the touches that `touches` gives for it.
///
/// # Errors
/// The errors of [`boards`].
fn under(
    setup: &Setup,
    layout: &Layout,
    seed: u64,
    touches: impl Fn(usize) -> Box<dyn Touches + Send>,
) -> Result<EmulatedSkin, Failure> {
    if is_array(setup) {
        return Ok(Box::new(array(setup, layout, seed, touches)));
    }
    let mut handle = touched(setup, layout, seed, NodeConfig::default(), touches)?;
    start(&mut handle)?;
    let bus = Tap::new(Faulty::new(handle, seed, "sensor bus"), false);
    Ok(Box::new(source(setup, layout, bus)))
}

/// A scene's skin, sending from the start, under one hand on each module in place of the scene's touches.
///
/// # Errors
/// The errors of [`boards`].
pub fn under_hands(
    setup: &Setup,
    layout: &Layout,
    seed: u64,
    hands: &[Hand],
) -> Result<EmulatedSkin, Failure> {
    let hand = |module: usize| -> Box<dyn Touches + Send> {
        Box::new(hands.get(module).cloned().unwrap_or_default())
    };
    under(setup, layout, seed, hand)
}

/// A skin that no bus carries.
fn array(
    setup: &Setup,
    layout: &Layout,
    seed: u64,
    touches: impl Fn(usize) -> Box<dyn Touches + Send>,
) -> SkinArray {
    let scene = &setup.scene.value;
    let module = |(number, module): (usize, &Module)| {
        pressed(setup, (number, module), seed, touches(number))
    };
    let modules = layout.modules().iter().enumerate().map(module).collect();
    let delivery = scene.stream.map_or(Delivery::DIRECT, |way| Delivery {
        delay_s: way.delay_ms * 1e-3,
        jitter_s: way.jitter_ms * 1e-3,
        late: (way.late, way.late_ms * 1e-3),
        loss: way.loss,
    });
    SkinArray::new(modules, scene.rate_hz, delivery, seed)
}

/// The boards of a scene's layout, over any bus, as the loop reads them.
pub fn source<B: CanBus>(setup: &Setup, layout: &Layout, bus: B) -> CanSkin<B> {
    CanSkin::new(layout, bus).with_gap(plan::scan_gap(layout, &setup.scene.value))
}

/// Emulated boards with the scene's touches on them, sending from the start.
///
/// # Errors
/// The errors of [`boards`].
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
