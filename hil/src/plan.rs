//! From checked files to the core's own types.

mod illusion;
mod person;
mod texture;

pub use illusion::{drive, model};
pub use person::perceiver;
pub use texture::projection;

use palpate_core::contact::{Levels, Norm, Scope, Settings};
use palpate_core::guard::{Guard, Limits, Plant};
use palpate_core::illusion::{Display, Map, Rect, Surface, Wire};
use palpate_core::physics::WireParameters;
use palpate_core::projector::{Plan, SensingPlan};
use palpate_core::skin::{
    Address, Axes, HealthSettings, InitialiserSettings, Layout, LayoutError, Module, ScanAssembler,
    ThresholdRule,
};
use palpate_core::units::{Board, Channel, Duration, Milliamps, Point, Prescale};
use palpate_core::wire::uskin::IdProfile;

use crate::failure::Failure;
use palpate_files::Setup;

/// Millimetres of a file as the core counts them.
fn point([x, y]: [f64; 2]) -> Point {
    Point::new(x as f32, y as f32)
}

/// One module of a sensor layout file. A module that several boards read is one here, under the first
/// board's address.
fn module(file: &palpate_files::Module, axes: u8) -> Result<Module, LayoutError> {
    let limited = |n: usize| u16::try_from(n).unwrap_or(u16::MAX);
    let built = match (&file.grid, file.scattered()) {
        (Some(grid), _) => Module::grid(
            &file.name,
            limited(grid.rows),
            limited(grid.columns),
            grid.pitch_mm as f32,
        )?,
        (None, points) => {
            let points = points.into_iter().flatten().map(point);
            let points = points.collect::<Vec<_>>();
            Module::scattered(&file.name, &points)?
        }
    };
    let active: Vec<bool> = (0..built.points().len())
        .map(|i| !file.inactive.contains(&i))
        .collect();
    let built = built
        .with_active(&active)?
        .with_axes(axes)?
        .with_origin(point(file.place_mm))?;
    match (file.bus, file.boards.first()) {
        (Some(bus), Some(&board)) => built.with_address(Address { bus, board }),
        _ => Ok(built),
    }
}

/// The core's layout of a sensor layout file.
///
/// # Errors
/// [`Failure::Input`] with the file's name and what no layout can be.
pub fn layout(file: &palpate_files::SensorLayout) -> Result<Layout, Failure> {
    let modules = file
        .modules
        .iter()
        .map(|m| module(m, file.axes))
        .collect::<Result<_, _>>();
    let built = modules.and_then(Layout::new);
    built.map_err(|e| Failure::Input(format!("layout `{}`: {e}", file.name)))
}

/// The I2C addresses on each of a bench's buses, ascending. Boards are numbered through in this order.
pub fn buses(bench: &palpate_files::Bench) -> Vec<Vec<u8>> {
    let count = bench.outputs.iter().map(|o| usize::from(o.bus) + 1).max();
    let mut buses = vec![Vec::new(); count.unwrap_or(0)];
    for output in &bench.outputs {
        buses[usize::from(output.bus)].push(output.board);
    }
    for addresses in &mut buses {
        addresses.sort_unstable();
        addresses.dedup();
    }
    buses
}

/// The I2C addresses of all boards: a board's number is its place here.
pub fn boards(bench: &palpate_files::Bench) -> Vec<u8> {
    buses(bench).concat()
}

/// The number of the board that carries an output.
fn board(buses: &[Vec<u8>], output: &palpate_files::Output) -> Board {
    let bus = usize::from(output.bus);
    let before: usize = buses.iter().take(bus).map(Vec::len).sum();
    let place = buses
        .get(bus)
        .and_then(|b| b.iter().position(|&a| a == output.board));
    Board((before + place.unwrap_or(0)) as u8) // at most 16
}

/// The display's wires with the outputs that drive them.
///
/// # Errors
/// [`Failure::Input`] with what no display can be.
pub fn display(setup: &Setup) -> Result<Display, Failure> {
    let buses = buses(&setup.bench.value);
    let outputs = &setup.bench.value.outputs;
    display_of(&setup.display.value, |wire| {
        outputs.get(wire).map_or((Board(0), Channel(0)), |output| {
            (board(&buses, output), Channel(output.channel))
        })
    })
}

/// A display file's wires on the outputs that `output` names for each.
///
/// # Errors
/// [`Failure::Input`] with what no display can be.
pub fn display_of(
    file: &palpate_files::DisplayLayout,
    output: impl Fn(usize) -> (Board, Channel),
) -> Result<Display, Failure> {
    let wire = |(index, place): (usize, &[f64; 2])| {
        let (board, channel) = output(index);
        Wire {
            place: point(*place),
            board,
            channel,
        }
    };
    let wires = file.wires_mm.iter().enumerate();
    let surface = file.surface.map_or(Surface::Flat, |s| Surface::Finger {
        radius_mm: (s.diameter_mm / 2.0) as f32,
        tip_mm: s.tip_mm as f32,
    });
    let [dx, dy] = file.spacing_mm;
    Display::new(&wires.map(wire).collect::<Vec<_>>())
        .map(|d| d.with_spacing((dx as f32, dy as f32)).with_surface(surface))
        .map_err(|e| Failure::Input(format!("display `{}`: {e}", file.name)))
}

/// PRE_SCALE for the frequency a bench asks for.
///
/// # Errors
/// [`Failure::Input`] for no frequency at all.
pub fn prescale(bench: &palpate_files::Bench) -> Result<Prescale, Failure> {
    Prescale::from_hz(bench.drive.pwm_hz).ok_or_else(|| {
        Failure::Input(format!(
            "bench `{}`: expected a PWM frequency above 0",
            bench.name
        ))
    })
}

/// Parameters of a bench's wires.
pub fn wire(setup: &Setup) -> WireParameters {
    setup.wire.value.parameters(&setup.alloy.value)
}

/// The guard's limits: a limit table with the bench's supply.
pub fn limits(table: &palpate_files::Limits, supply: Milliamps) -> Limits {
    let scaled = |value: f64, scale: f64| (value * scale).round() as u64;
    Limits {
        pulse_width_ns: scaled(table.pulse.width_us, 1e3),
        burst: Duration::from_micros(scaled(table.burst.length_ms, 1e3)),
        burst_energy_nj: scaled(table.burst.energy_mj, 1e6),
        wire_1s_uw: scaled(table.wire_power.over_1s_mw, 1e3),
        wire_10s_uw: scaled(table.wire_power.over_10s_mw, 1e3),
        fingertip_1s_uw: scaled(table.fingertip_power.over_1s_mw, 1e3),
        fingertip_60s_uw: scaled(table.fingertip_power.over_60s_mw, 1e3),
        skin_mean_mc: scaled(table.skin.mean_10s_c, 1e3),
        skin_peak_mc: scaled(table.skin.peak_c, 1e3),
        skin_deep_mc: scaled(table.skin.deep_c, 1e3),
        dose_omega_ppm: scaled(table.dose.henriques_omega, 1e6),
        dose_cem43_ms: scaled(table.dose.cem43_min, 60e3),
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
pub const fn axes(axes: palpate_files::Axes) -> Axes {
    match axes {
        palpate_files::Axes::Xyz => Axes::XYZ,
        palpate_files::Axes::Z => Axes::Z,
    }
}

/// Norm of a scene file.
pub const fn norm(norm: palpate_files::Norm) -> Norm {
    match norm {
        palpate_files::Norm::L1 => Norm::L1,
        palpate_files::Norm::L2 => Norm::L2,
        palpate_files::Norm::Linf => Norm::LInf,
    }
}

/// Where K_C counts, of a scene file.
pub const fn scope(scope: palpate_files::Scope) -> Scope {
    match scope {
        palpate_files::Scope::Module => Scope::Module,
        palpate_files::Scope::Skin => Scope::Skin,
    }
}

/// The contact threshold of a scene.
fn threshold(scene: &palpate_files::Scene) -> ThresholdRule {
    let margin = scene.threshold_margin as f32;
    match scene.threshold {
        palpate_files::ThresholdRule::Maximum => ThresholdRule::Auto { margin },
        palpate_files::ThresholdRule::PerTaxel => ThresholdRule::PerTaxel {
            sigmas: palpate_files::THRESHOLD_SIGMAS as f32,
            floor: margin,
        },
    }
}

/// The silence that ends a scan. On a bus with room the frames of a scan come within milliseconds; on one
/// that waiting boards overload they spread over the whole scan, and the next scan's follow a scan later.
fn scan_gap(layout: &Layout, scene: &palpate_files::Scene) -> Duration {
    const FRAME_S: f64 = 117e-6;
    let period = 1.0 / scene.rate_hz;
    let taxels_on = |bus: u8| {
        let on_bus = |m: &&Module| m.address().is_some_and(|a| a.bus == bus);
        let active = |m: &Module| m.active().iter().filter(|a| **a).count();
        let of_bus = layout.modules().iter().filter(on_bus);
        of_bus.map(active).sum::<usize>()
    };
    let fullest = (0..=u8::MAX).map(taxels_on).max().unwrap_or(0);
    let busy = fullest as f64 * FRAME_S;
    let waits = scene.boards.overload != Some(palpate_files::Overload::Overwrite);
    if busy > period && waits {
        Duration::from_micros((0.75e6 * busy) as u64)
    } else {
        let short = Duration::from_micros((0.4e6 * period) as u64);
        short.min(ScanAssembler::DEFAULT_GAP)
    }
}

/// The rectangle around what drives the display: the driving module's taxels, or the whole skin's.
pub fn sensor_area(layout: &Layout, drives: usize, scope: Scope) -> Rect {
    let places = |m: &Module, origin: Point| {
        let shifted = |p: &Point| Point::new(p.x + origin.x, p.y + origin.y);
        m.points().iter().map(shifted).collect::<Vec<_>>()
    };
    let taxels: Vec<Point> = match scope {
        Scope::Skin => layout
            .modules()
            .iter()
            .flat_map(|m| places(m, m.origin()))
            .collect(),
        Scope::Module => layout
            .modules()
            .get(drives)
            .map(|m| places(m, Point::default()))
            .unwrap_or_default(),
    };
    Rect::around(taxels.into_iter())
}

/// The loop of a scene on a bench, with intensity levels found beforehand (or none).
///
/// # Errors
/// [`Failure::Input`] with file and key of what does not fit together.
pub fn plan(setup: &Setup, seed: u64, levels: Levels) -> Result<Plan, Failure> {
    let mut plan = untextured(setup, seed, levels)?;
    let prescale = prescale(&setup.bench.value)?;
    let (layout, display) = (&plan.sensing.layout, &plan.display);
    plan.texture = texture::texture(setup, layout, display, prescale, seed)?;
    Ok(plan)
}

/// The same without the scene's texture: for a pass that looks at contacts only.
///
/// # Errors
/// As [`plan`].
pub fn untextured(setup: &Setup, seed: u64, levels: Levels) -> Result<Plan, Failure> {
    let (scene, bench) = (&setup.scene.value, &setup.bench.value);
    let bad = |key: &str, e: &dyn std::fmt::Display| {
        Failure::Input(setup.scene.source.bad(key, e.to_string()).to_string())
    };
    let layout = layout(&setup.sensor.value)?;
    let display = display(setup)?;
    let sensor = sensor_area(&layout, scene.drives, scope(scene.compression.scope));
    let stated = scene.map.sensor_mm.map(|[x0, y0, x1, y1]| Rect {
        min: point([x0.min(x1), y0.min(y1)]),
        max: point([x0.max(x1), y0.max(y1)]),
    });
    let map = Map::new(sensor, stated, display.bounds()).map_err(|e| bad("map.sensor_mm", &e))?;

    let (prescale, peak) = (prescale(bench)?, milliamps(bench.drive.current_ma));
    let wire_milliohm = (wire(setup).resistance_ohm * 1e3).round() as u32;
    let limits = limits(&setup.limits.value, milliamps(bench.drive.supply_limit_ma));
    let guard = Guard::new(
        limits,
        Plant {
            prescale,
            wire_milliohm,
            peak,
        },
        display.wires(),
    )
    .map_err(|e| Failure::Input(format!("bench `{}`: {e}", bench.name)))?;

    let output = illusion::output(setup, &display, peak)?;
    Ok(Plan {
        sensing: SensingPlan {
            gap: scan_gap(&layout, scene),
            layout,
            profile: IdProfile::Current,
            initialiser: InitialiserSettings {
                reference_frames: scene.reference_frames,
                fault_sigmas: scene.faulty_deviations.map(|k| k as f32),
                threshold: threshold(scene),
                axes: axes(scene.compression.axes),
                drift: scene
                    .drift_s
                    .map(|s| Duration::from_micros((s * 1e6).round() as u64)),
            },
            compression: Settings {
                clusters: u16::try_from(scene.compression.kc).unwrap_or(u16::MAX),
                scope: scope(scene.compression.scope),
                norm: norm(scene.compression.norm),
                exponent: scene.compression.weight_exponent as f32,
                levels,
                seed,
                max_iterations: scene
                    .compression
                    .iterations
                    .unwrap_or(Settings::default().max_iterations),
                ..Settings::default()
            },
            health: HealthSettings::default(),
        },
        drives: u16::try_from(scene.drives).unwrap_or(u16::MAX),
        map,
        display,
        output,
        texture: None,
        guard,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_core::guard::HARD;

    /// A limit file is checked against its own copy of the hard limits; the guard enforces core's.
    #[test]
    fn the_hard_limits_of_files_are_those_of_the_guard() {
        assert_eq!(
            limits(&palpate_files::HARD_LIMITS, Milliamps(u32::MAX)),
            HARD
        );
    }
}
