//! Conversion of checked files to the core's own types.

mod current;
mod illusion;
mod level;
pub mod motors;
mod person;
mod reaction;
mod response;
mod texture;
mod unit;

pub(crate) use current::current_wait;
pub use current::{banks, converters, with_converters};
pub(crate) use illusion::MOVING_W;
pub use illusion::drive;
pub(crate) use level::{decibels, strongest};
pub use person::{emulated_person, person};
pub use reaction::{Reaction, reaction};
pub use response::Responses;
pub(crate) use response::felt_wire;
pub use texture::{projection, surface};
pub use unit::differences;

use palpate_core::contact::{Levels, Settings};
use palpate_core::guard::{Guard, Limits, Plant, PlantError, WornWire};
use palpate_core::illusion::{Display, DisplayWire, Map, MapError, Rect, Surface};
use palpate_core::physics::{TissueParameters, WireParameters};
use palpate_core::projector::{OutputSettings, Plan, SensingPlan, View, Window, sensor_area};
use palpate_core::skin::uskin::SCAN_GAP;
use palpate_core::skin::{
    Address, BaselineSettings, HealthSettings, Layout, LayoutError, Module, Protocol, Seam,
};
use palpate_core::units::{Board, Channel, Clock, Duration, Instant, Milliamps, Point, Prescale};

use crate::failure::Failure;
use palpate_files::{LayoutSeam, Setup, Transducer};

/// Millimetres of a file as the core counts them.
fn point([x, y]: [f64; 2]) -> Point {
    Point::new(x as f32, y as f32)
}

/// One module of a sensor layout file. A module that several boards read is one here, under the first
/// board's address.
fn module(
    file: &palpate_files::SkinModule,
    axes: u8,
    protocol: Protocol,
) -> Result<Module, LayoutError> {
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
        .with_origin(point(file.place_mm))?
        .with_protocol(protocol);
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
    let protocol = match file.transducer {
        Transducer::Capacitive => Protocol::Mtb,
        Transducer::Magnetic | Transducer::Camera | Transducer::Cells => Protocol::Uskin,
    };
    let modules = file
        .modules
        .iter()
        .map(|m| module(m, file.axes, protocol))
        .collect::<Result<_, _>>();
    let seam = |seam: &LayoutSeam| {
        Some(Seam {
            modules: seam.indices(&file.modules)?,
            edges: seam.edges_mm.map(|edge| edge.map(point)),
        })
    };
    let seams: Vec<Seam> = file.seams.iter().filter_map(seam).collect();
    let built = modules
        .and_then(Layout::new)
        .and_then(|layout| layout.with_seams(&seams));
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

/// Refuses a bench of several displays.
///
/// # Errors
/// [`Failure::File`] with the line of its displays.
pub fn one_display(bench: &palpate_files::Loaded<palpate_files::Bench>) -> Result<(), Failure> {
    let displays = &bench.value.displays;
    if displays.is_empty() {
        return Ok(());
    }
    let expected = "one display: only `hil run` and `hil test` drive several";
    let found = format!("{} displays", displays.len());
    Err(Failure::File(
        bench.source.bad_found("displays", expected, found),
    ))
}

/// Words for people with motors, where only wires are emulated.
pub(crate) const NO_WIRES: &str = "`hil run`, `hil emulate` and loops of Python emulate motors";

/// Refuses a bench of motors. `instead` tells people who have one what serves them.
///
/// # Errors
/// [`Failure::File`] with the line of its motors.
pub fn wires_only(
    bench: &palpate_files::Loaded<palpate_files::Bench>,
    instead: &str,
) -> Result<(), Failure> {
    if bench.value.haptics.is_none() {
        return Ok(());
    }
    let expected = format!("a bench of wires: {instead}");
    Err(Failure::File(bench.source.bad("haptics", expected)))
}

/// The display's wires with the outputs that drive them.
///
/// # Errors
/// [`Failure::Input`] with what no display can be.
pub fn display(setup: &Setup) -> Result<Display, Failure> {
    one_display(&setup.bench)?;
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
        DisplayWire {
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

/// Frequency of boards where neither bench nor illusion states one.
pub(crate) const PWM_HZ: f64 = 200.0;

/// The clock that a bench's boards count by.
fn clock(bench: &palpate_files::Bench) -> Option<Clock> {
    match &bench.drive.clock {
        None => Some(Clock::INTERNAL),
        Some(clock) => Clock::external(clock.hz, clock.tolerance_ppm),
    }
}

/// PRE_SCALE of the bench's clock for the frequency it asks for.
///
/// # Errors
/// [`Failure::Input`] for no frequency at all, or a clock that no chip takes.
pub fn prescale(bench: &palpate_files::Bench) -> Result<Prescale, Failure> {
    let hz = bench.drive.pwm_hz.unwrap_or(PWM_HZ);
    let prescale = clock(bench).and_then(|clock| Prescale::from_hz(clock, hz));
    prescale.ok_or_else(|| {
        Failure::Input(format!(
            "bench `{}`: expected a PWM frequency above 0 and a clock that a chip takes",
            bench.name
        ))
    })
}

/// Parameters of a bench's wires.
pub fn wire(setup: &Setup) -> WireParameters {
    WireParameters {
        mount: setup.bench.value.mount.parameters(),
        ends_c: setup.bench.value.tissue.rest_c,
        ..setup.wire.value.parameters(&setup.alloy.value)
    }
}

/// Wires and finger that an emulated display has: those that were drawn, else the bench's.
pub(crate) fn worn(setup: &Setup) -> (WireParameters, TissueParameters) {
    let own = || (wire(setup), setup.bench.value.tissue.parameters());
    setup
        .drawn
        .map_or_else(own, |drawn| (drawn.wire, drawn.tissue))
}

/// Milliamperes of a file, which has checked their range.
pub fn milliamps(ma: f64) -> Milliamps {
    Milliamps(ma.round() as u32)
}

/// The silence that ends a scan. On a bus with room the frames of a scan come within milliseconds; on one
/// that waiting boards overload they spread over the whole scan, and the next scan's follow a scan later.
pub fn scan_gap(layout: &Layout, scene: &palpate_files::Scene) -> Duration {
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
        short.min(SCAN_GAP)
    }
}

/// The part of a skin that fills the display.
fn view(setup: &Setup, skin: Rect, display: Rect) -> Result<View, Failure> {
    let map = &setup.scene.value.map;
    let bad = |key: &str, expected: String| Failure::File(setup.scene.source.bad(key, expected));
    if let Some([width, height]) = map.window_mm {
        let window = Window {
            size: (width as f32, height as f32),
            hysteresis: map.hysteresis as f32,
        };
        return View::following(window, skin, display).map_err(|e| match e {
            MapError::NotContained => {
                let (w, h) = (skin.max.x - skin.min.x, skin.max.y - skin.min.y);
                let expected = format!("a window inside the taxels' hull, {w:.2} mm by {h:.2} mm");
                bad("map.window_mm", expected)
            }
            _ => bad("map.window_mm", e.to_string()),
        });
    }
    let stated = map.sensor_mm.map(|[x0, y0, x1, y1]| Rect {
        min: point([x0.min(x1), y0.min(y1)]),
        max: point([x0.max(x1), y0.max(y1)]),
    });
    let fixed = Map::new(skin, stated, display).map(View::fixed);
    fixed.map_err(|e| match (e, stated) {
        (MapError::NotContained, Some(stated)) => bad("map.sensor_mm", beyond(skin, stated)),
        _ => bad("map.sensor_mm", e.to_string()),
    })
}

/// Words of the rectangle inside the skin, and of the edge of `stated` that lies furthest outside.
fn beyond(skin: Rect, stated: Rect) -> String {
    let edges = [
        ("left", skin.min.x - stated.min.x),
        ("bottom", skin.min.y - stated.min.y),
        ("right", stated.max.x - skin.max.x),
        ("top", stated.max.y - skin.max.y),
    ];
    let furthest = edges.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let (edge, by) = furthest.unwrap_or(("left", 0.0));
    let Rect { min, max } = skin;
    format!(
        "a rectangle inside the taxels' hull, [{:.2}, {:.2}, {:.2}, {:.2}] mm: its {edge} edge lies {by:.2} mm outside",
        min.x, min.y, max.x, max.y
    )
}

/// The loop of a scene on a bench, with intensity levels found beforehand (or none).
///
/// # Errors
/// [`Failure::File`] with file and key of what does not fit together.
pub fn plan(setup: &Setup, seed: u64, levels: Levels) -> Result<Plan, Failure> {
    plan_with(setup, seed, levels, &Responses::default())
}

/// Plans with the responses that other loops have found already.
///
/// # Errors
/// Errors of [`plan`].
pub fn plan_with(
    setup: &Setup,
    seed: u64,
    levels: Levels,
    responses: &Responses,
) -> Result<Plan, Failure> {
    let mut plan = untextured(setup, seed, levels, responses)?;
    let prescale = prescale(&setup.bench.value)?;
    let (layout, display) = (&plan.sensing.layout, &plan.display);
    plan.texture = texture::texture(setup, layout, display, prescale, seed)?;
    Ok(plan)
}

/// Limits and plant of a bench, by its own files.
fn guarded(setup: &Setup, pattern: Option<Prescale>) -> Result<(Limits, Plant), Failure> {
    let bench = &setup.bench.value;
    let limits = Limits {
        supply: milliamps(bench.drive.supply_limit_ma),
        ..setup.limits.value.limits
    };
    let plant = Plant {
        prescale: pattern.map_or_else(|| prescale(bench), Ok)?,
        wire_milliohm: (wire(setup).resistance_ohm * 1e3).round() as u32,
        peak: milliamps(bench.drive.current_ma),
        bus: setup.bus_wait + current::wait(bench),
    };
    Ok((limits.tightened().of_hand(1), plant))
}

/// Plans without the scene's texture: for a pass that looks at contacts only.
///
/// # Errors
/// Errors of [`plan`].
pub fn untextured(
    setup: &Setup,
    seed: u64,
    levels: Levels,
    responses: &Responses,
) -> Result<Plan, Failure> {
    let (scene, bench) = (&setup.scene.value, &setup.bench.value);
    let layout = layout(&setup.sensor.value)?;
    let display = display(setup)?;
    let skin = sensor_area(&layout, scene.drives, scene.compression.scope);
    let view = view(setup, skin, display.bounds())?;

    let pattern = illusion::pattern(setup)?;
    if let Some(haptics) = &bench.haptics {
        let plant = Plant {
            prescale: prescale(bench)?,
            ..Plant::default()
        };
        let limits = setup.limits.value.limits;
        let guard = Guard::of_motors(limits, motors::limits(haptics), plant, display.wires());
        let guard = guard.map_err(no_guard(setup))?;
        // Heat of coils and time on outlive no run in an account: seconds bring them back.
        let guard = match bench.is_hardware() {
            true => guard.after_unknown_use(),
            false => guard,
        };
        let peak = milliamps(bench.drive.current_ma);
        let output = illusion::output(setup, &display, &guard, peak, (None, responses))?;
        return Ok(assembled(
            setup,
            seed,
            levels,
            (layout, view, display, output, guard),
        ));
    }
    let own = guarded(setup, pattern.map(|p| p.prescale()))?;
    let (limits, plant) = unit::agreed(setup, own, display.wires())?;
    let control = unit::agreed_current(setup, current::control(bench))?;
    // Where current is set, a unit's largest current counts for heat and is never requested.
    let peak = control.map_or(plant.peak, |control| control.full_scale);
    let prescale = plant.prescale;
    let warmest = TissueParameters {
        body_c: bench.tissue.guarded_c(),
        ..bench.tissue.parameters()
    };
    let worn = WornWire::new(&wire(setup), &warmest);
    let mut guard = Guard::new(limits, plant, display.wires(), worn)
        .and_then(|guard| match control {
            Some(control) => guard.with_current(control),
            None => Ok(guard),
        })
        .map_err(no_guard(setup))?;
    if let Some(memory) = &setup.memory {
        let remembered = guard.remember(memory, Instant::ZERO);
        remembered.map_err(|e| Failure::Input(format!("heat of earlier runs: {e}")))?;
    }

    let mut output = illusion::output(setup, &display, &guard, peak, (pattern, responses))?;
    if pattern.is_none() {
        output.timing.duration = prescale.counted(output.timing.duration);
    }
    Ok(assembled(
        setup,
        seed,
        levels,
        (layout, view, display, output, guard),
    ))
}

/// Failure of a bench whose hardware no guard protects.
fn no_guard(setup: &Setup) -> impl Fn(PlantError) -> Failure {
    move |e| Failure::Input(format!("bench `{}`: {e}", setup.bench.value.name))
}

/// The plan of a scene's loop, of its parts.
fn assembled(
    setup: &Setup,
    seed: u64,
    levels: Levels,
    (layout, view, display, output, guard): (Layout, View, Display, OutputSettings, Guard),
) -> Plan {
    let scene = &setup.scene.value;
    Plan {
        sensing: SensingPlan {
            layout,
            baseline: BaselineSettings {
                reference_frames: scene.reference_frames,
                fault_sigmas: scene.faulty_deviations.map(|k| k as f32),
                threshold: scene.threshold_rule(),
                axes: scene.compression.axes,
                drift: scene
                    .drift_s
                    .map(|s| Duration::from_micros((s * 1e6).round() as u64)),
            },
            compression: Settings {
                clusters: u16::try_from(scene.compression.kc).unwrap_or(u16::MAX),
                growth: u16::try_from(scene.compression.kc_touches).unwrap_or(u16::MAX),
                scope: scene.compression.scope,
                norm: scene.compression.norm,
                exponent: scene.compression.weight_exponent as f32,
                levels,
                vectors: scene.compression.vectors,
                seed,
                max_iterations: scene.compression.iterations,
                tolerance: scene.compression.stop_mm as f32,
            },
            health: HealthSettings::default(),
        },
        drives: u16::try_from(scene.drives).unwrap_or(u16::MAX),
        view,
        ahead: scene.illusion.ahead(),
        display,
        output,
        texture: None,
        guard,
    }
}
