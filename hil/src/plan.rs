//! From checked files to the core's own types.

use palpate_core::contact::{Norm, Settings};
use palpate_core::guard::{Guard, Limits, Plant};
use palpate_core::illusion::{Display, Drive, LogPhantom, Map, Rect, Shape, Wire, timing};
use palpate_core::physics::{Alloy, WireParameters};
use palpate_core::projector::{OutputSettings, Plan};
use palpate_core::skin::{Axes, Grid, InitialiserSettings, Layout, Module, Threshold};
use palpate_core::units::{Board, Channel, Duration, Milliamps, Point, Prescale};
use palpate_core::wire::uskin::IdProfile;

use crate::failure::Failure;
use crate::files::{self, Setup, Transition};

/// Millimetres of a file as the core counts them.
fn point([x, y]: [f64; 2]) -> Point {
    Point::new(x as f32, y as f32)
}

/// One module of a sensor layout file.
fn module(file: &files::Module, index: usize) -> Result<Module, palpate_core::skin::LayoutError> {
    let built = match (&file.grid, &file.points_mm) {
        (Some(grid), _) => Module::grid(Grid {
            rows: u16::try_from(grid.rows).unwrap_or(u16::MAX),
            columns: u16::try_from(grid.columns).unwrap_or(u16::MAX),
            pitch: grid.pitch_mm as f32,
            centre: Point::default(),
        })?,
        (None, Some(points)) => {
            Module::scattered(&points.iter().copied().map(point).collect::<Vec<_>>())?
        }
        (None, None) => Module::scattered(&[])?,
    };
    let board = file.boards.first().copied().unwrap_or(u8::try_from(index).unwrap_or(u8::MAX));
    Ok(built.without(&file.inactive)?.at(file.bus.unwrap_or(0), board))
}

/// The core's layout of a sensor layout file. Contacts are in each module's own millimetres.
///
/// # Errors
/// [`Failure::Input`] with the file's name and what no layout can be.
pub fn layout(file: &files::SensorLayout) -> Result<Layout, Failure> {
    let modules = file.modules.iter().enumerate().map(|(i, m)| module(m, i)).collect::<Result<_, _>>();
    let built = modules.and_then(Layout::new);
    built.map_err(|e| Failure::Input(format!("layout `{}`: {e}", file.name)))
}

/// The I2C addresses of a bench's boards, ascending: a board's index is its place here.
pub fn boards(bench: &files::Bench) -> Vec<u8> {
    let mut addresses: Vec<u8> = bench.outputs.iter().map(|o| o.board).collect();
    addresses.sort_unstable();
    addresses.dedup();
    addresses
}

/// The display's wires with the outputs that drive them.
///
/// # Errors
/// [`Failure::Input`] with what no display can be.
pub fn display(setup: &Setup) -> Result<Display, Failure> {
    let boards = boards(&setup.bench.value);
    let wires = setup.display.value.wires_mm.iter().zip(&setup.bench.value.outputs);
    let wire = |(place, output): (&[f64; 2], &files::Output)| Wire {
        place: point(*place),
        board: Board(boards.iter().position(|&b| b == output.board).unwrap_or(0) as u8),
        channel: Channel(output.channel),
    };
    Display::new(&wires.map(wire).collect::<Vec<_>>())
        .map_err(|e| Failure::Input(format!("display `{}`: {e}", setup.display.value.name)))
}

/// PRE_SCALE for the frequency a bench asks for.
///
/// # Errors
/// [`Failure::Input`] for no frequency at all.
pub fn prescale(bench: &files::Bench) -> Result<Prescale, Failure> {
    Prescale::from_hz(bench.drive.pwm_hz)
        .ok_or_else(|| Failure::Input(format!("bench `{}`: expected a PWM frequency above 0", bench.name)))
}

/// Parameters of a bench's wires.
pub fn wire(bench: &files::Bench) -> WireParameters {
    let base = if bench.wire.diameter_um == 100 { WireParameters::FIRST } else { WireParameters::FINAL };
    let alloy = match bench.wire.transition {
        Transition::Low => Alloy::LOW,
        Transition::High => Alloy::HIGH,
    };
    WireParameters { alloy, ..base }
}

/// The guard's limits: a limit table with the bench's supply.
pub fn limits(table: &files::Limits, supply: Milliamps) -> Limits {
    let scaled = |value: f64, scale: f64| (value * scale).round() as u64;
    Limits {
        pulse_width_ns: scaled(table.pulse.width_us, 1e3),
        burst: Duration::from_micros(scaled(table.burst.length_ms, 1e3)),
        burst_energy_nj: scaled(table.burst.energy_mj, 1e6),
        wire_1s_uw: scaled(table.wire_power.over_1s_mw, 1e3),
        wire_10s_uw: scaled(table.wire_power.over_10s_mw, 1e3),
        fingertip_1s_uw: scaled(table.fingertip_power.over_1s_mw, 1e3),
        fingertip_60s_uw: scaled(table.fingertip_power.over_60s_mw, 1e3),
        stale: Duration::from_micros(scaled(table.watchdog.off_within_ms, 1e3)),
        supply,
    }
    .tightened()
}

/// Milliamperes of a file, which has checked their range.
pub fn milliamps(ma: f64) -> Milliamps {
    Milliamps(ma.round() as u32)
}

/// Axes of a scene file.
pub const fn axes(axes: files::Axes) -> Axes {
    match axes {
        files::Axes::Xyz => Axes::Xyz,
        files::Axes::Z => Axes::Z,
    }
}

/// Norm of a scene file.
pub const fn norm(norm: files::Norm) -> Norm {
    match norm {
        files::Norm::L1 => Norm::L1,
        files::Norm::L2 => Norm::L2,
        files::Norm::Linf => Norm::Linf,
    }
}

/// The loop of a scene on a bench, with static intensity levels found beforehand (or none).
///
/// # Errors
/// [`Failure::Input`] with file and key of what does not fit together.
pub fn plan(setup: &Setup, seed: u64, levels: Vec<f32>) -> Result<Plan, Failure> {
    let (scene, bench) = (&setup.scene.value, &setup.bench.value);
    let bad = |key: &str, e: &dyn std::fmt::Display| {
        Failure::Input(format!("{}: {key}: {e}", setup.scene.source.label()))
    };
    let layout = layout(&setup.sensor.value)?;
    let display = display(setup)?;
    let taxels = layout.modules().get(scene.drives).map_or(&[][..], Module::taxels);
    let sensor = Rect::around(taxels.iter().copied());
    let stated = scene.map.sensor_mm.map(|[x0, y0, x1, y1]| Rect {
        min: point([x0.min(x1), y0.min(y1)]),
        max: point([x0.max(x1), y0.max(y1)]),
    });
    let map = Map::new(sensor, stated, display.bounds()).map_err(|e| bad("map.sensor_mm", &e))?;

    let illusion = &scene.illusion;
    let ms = |ms: f64| Duration::from_micros((ms * 1e3).round() as u64);
    let timing = timing(ms(illusion.tau_d_ms), illusion.soa_ms.map(ms))
        .map_err(|e| bad("illusion.tau_d_ms", &e))?;
    let shape = Shape { x: illusion.shape as f32, y: illusion.shape as f32 };
    let phantom = LogPhantom::new(&display, shape)
        .ok_or_else(|| bad("illusion.shape", &"expected a shape factor above 0"))?;
    let floor = if illusion.intensity { illusion.intensity_floor as f32 } else { 1.0 };
    let drive = Drive { alpha: illusion.alpha as f32, beta: illusion.beta as f32, floor };

    let (prescale, peak) = (prescale(bench)?, milliamps(bench.drive.current_ma));
    let milliohm = (wire(bench).resistance_ohm * 1e3).round() as u32;
    let limits = limits(&setup.limits.value, milliamps(bench.drive.supply_limit_ma));
    let guard = Guard::new(limits, Plant { prescale, wire_milliohm: milliohm, peak }, display.wires())
        .map_err(|e| Failure::Input(format!("bench `{}`: {e}", bench.name)))?;

    Ok(Plan {
        profile: IdProfile::Current,
        initialiser: InitialiserSettings {
            reference_frames: scene.reference_frames,
            faulty_sigma: scene.faulty_deviations.map(|k| k as f32),
            threshold: Threshold::Auto { margin: scene.threshold_margin as f32 },
            axes: axes(scene.compression.axes),
        },
        compression: Settings {
            kc: u16::try_from(scene.compression.kc).unwrap_or(u16::MAX),
            weight_exponent: scene.compression.weight_exponent as f32,
            norm: norm(scene.compression.norm),
            levels,
            seed,
            ..Settings::default()
        },
        drives: scene.drives,
        map,
        output: OutputSettings { timing, phantom, drive, peak },
        guard,
        layout,
        display,
    })
}
