//! Tests of `pulse.rs`: the level of a texture, and that the guard has nothing left to change.

use super::*;
use crate::guard::{HARD, Plant, WornWire};
use crate::illusion::{Calibration, Display, DisplayWire, ModelSettings, Sharing, inverse};
use crate::render::{Pattern, RenderSettings, Response, Style};
use crate::schedule::{Entry, Stimulus};
use crate::units::{Board, Channel, Duration, Milliamps, Point, Prescale};
use alloc::vec::Vec;

/// PRE_SCALE of textures: periods of 5.079 ms.
const CARRIER: Prescale = Prescale::new(30);
/// Time for which a pulse is on.
const ON: Duration = Duration::from_micros(2_600);
/// A marked width.
const PULSES: Ticks = Ticks::new(1);
const WIRES: usize = 8;

/// The thimble's number of thin wires whose answer goes with the width, and one twice as strong to lone pulses.
fn rig() -> (Guard, Renderer) {
    let wire = |n: u8| DisplayWire {
        place: Point::new(9.0 * f32::from(n % 2), 9.0 * f32::from(n / 2)),
        board: Board(0),
        channel: Channel(n),
    };
    let display = Display::new(&core::array::from_fn::<_, WIRES, _>(|n| wire(n as u8))).unwrap();
    let plant = Plant {
        prescale: CARRIER,
        peak: Milliamps(1200),
        wire_milliohm: 4871,
        ..Plant::default()
    };
    let guard = Guard::new(HARD, plant, display.wires(), WornWire::default()).unwrap();
    let linear = Response::linear(guard.widest());
    let lone = (0..=guard.widest().get()).map(|w| 2.0 * f32::from(w));
    let settings = RenderSettings {
        law: inverse(&display, &ModelSettings::default()).unwrap(),
        style: Style::Smooth,
        pattern: Pattern::on(CARRIER, crate::render::CADENCE).unwrap(),
        full: linear.full(),
        texture: 40.0,
        woven: [(2, Response::new(lone.collect())), (9, linear.clone())].into(),
        response: linear,
        sharing: Sharing::default(),
        calibration: Calibration::even(WIRES),
    };
    let renderer = Renderer::new(settings, &guard, WIRES);
    (guard, renderer)
}

fn density(all_hz: f32, pass: f32) -> Density {
    Density { pass, all_hz }
}

/// A pulse on the first two wires, `ms` after the start.
fn two(renderer: &mut Renderer, guard: &Guard, ms: u64, density: Density) -> [Ticks; WIRES] {
    let at = Instant::from_micros(1000 * ms);
    let mut widths = [Ticks::ZERO; WIRES];
    widths[..2].fill(PULSES);
    renderer.texture((at, at + ON), density, &mut widths, guard);
    widths
}

#[test]
fn fewer_pulses_are_stronger_so_that_all_together_are_as_strong() {
    let (guard, mut renderer) = rig();
    // Seven pulses every 117 ms on one wire are what the level counts from.
    let bursts_hz = 7.0 / 0.117;
    for (all_hz, wanted) in [
        (bursts_hz, 40),
        (4.0 * bursts_hz, 20),
        (bursts_hz / 4.0, 80),
    ] {
        let widths = two(&mut renderer, &guard, 0, density(all_hz, 7.0));
        assert_eq!(widths[..2], [Ticks::new(wanted); 2], "{all_hz}");
        assert_eq!(widths[2..], [Ticks::ZERO; WIRES - 2]);
    }
}

#[test]
fn a_pass_of_few_pulses_has_the_response_of_few() {
    let (guard, mut renderer) = rig();
    let bursts_hz = 7.0 / 0.117;
    for (pass, wanted) in [
        (0.0, 20),
        (1.4, 20),
        (2.4, 20),
        (2.6, 40),
        (9.0, 40),
        (300.0, 40),
    ] {
        let widths = two(&mut renderer, &guard, 0, density(bursts_hz, pass));
        assert_eq!(widths[0], Ticks::new(wanted), "{pass}");
    }
    let mut widths = [PULSES; WIRES];
    let span = (Instant::ZERO, Instant::ZERO + ON);
    renderer.tap(span, 0.25, &mut widths, &guard);
    let quarter = guard.widest().get() / 4;
    assert!(
        widths.iter().all(|w| w.get().abs_diff(quarter) <= 1),
        "{widths:?}"
    );
}

/// Ten minutes of a texture far denser and stronger than the limits bear: it fades, and the guard changes no pulse.
#[test]
fn a_texture_fades_before_the_guard_has_to_narrow_it() {
    let (mut guard, mut renderer) = rig();
    let period = Duration::from_micros(CARRIER.period_ns() / 1000);
    let (mut at, mut limited, mut last) = (Instant::ZERO, Vec::<Entry>::new(), 0);
    let dense = density(60.0, 14.0);
    for n in 0..118_000_u64 {
        guard.hear(at);
        let mut widths = [PULSES; WIRES];
        for (wire, width) in widths.iter_mut().enumerate() {
            // All wires at once, in every third period, with rests.
            let rests = n % 30 > 20 || n % 3 > 0;
            if rests || !guard.has_time(wire, at, at + ON) {
                *width = Ticks::ZERO;
            }
        }
        renderer.texture((at, at + ON), dense, &mut widths, &guard);
        let pulses = widths.iter().zip(0..).filter(|(w, _)| **w > Ticks::ZERO);
        let stimuli: Vec<Stimulus> = pulses
            .map(|(width, wire)| Stimulus {
                wire,
                width: *width,
                peak: Milliamps(1200),
                at,
                until: at + ON,
            })
            .collect();
        if let Some(first) = stimuli.first() {
            last = first.width.get();
        }
        let update = guard.admit(at, Board(0), &stimuli, |entry| {
            if entry.reason.is_some() {
                limited.push(entry);
            }
        });
        guard.confirm(&update, at);
        let update = guard.expire(at + ON, Board(0));
        guard.confirm(&update, at + ON);
        at += period;
    }
    assert_eq!(limited, []);
    assert!(last > 0 && last < 40, "{last}");
}
