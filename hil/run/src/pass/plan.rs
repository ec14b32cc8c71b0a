//! Pulses of a hot pass, found from wire and guard, and the scene that plays them.

use palpate_core::contact::Levels;
use palpate_core::guard::{Booked, Guard};
use palpate_core::illusion::{Display, IllusionModel};
use palpate_core::projector::{HotPass, Projector};
use palpate_core::schedule::Stimulus;
use palpate_core::units::{Duration, Prescale};
use palpate_files::{Illusion, LevelsFrom, Pass, Setup};

use super::heated::{Heated, PASSED, lasting};
use crate::failure::Failure;
use crate::loops::{PASS_AT, build};
use crate::place::fingers;
use crate::plan;

/// Time between onsets of the pass's scene, ms: bursts of a wire and of the next one lie on this grid.
const SOA_MS: u64 = 125;
/// Time from burst to burst of a wire: it has given off its heat by then.
const AGAIN: Duration = Duration::from_millis(2 * SOA_MS);
/// Time from wire to wire.
const APART: Duration = Duration::from_millis(8 * SOA_MS);
/// Most bursts of a wire, and most pulses of each.
const MOST: (u8, u64) = (8, 10);
/// Lateness of a bus or a machine that a pass must bear: a guard counts a burst whose off comes late as a longer one.
const LATE: Duration = Duration::from_millis(5);
/// Time after the last wire's, s: bursts that had to wait, and the cooling of the last wire.
const AFTER_S: f64 = 1.0;
/// Reference frames, too many for the pass's length: a touch meanwhile makes no contact.
const NO_REFERENCE: u32 = 100_000;

/// A pass and the run that makes it.
#[derive(Debug)]
pub(super) struct Planned {
    /// Setup of the run.
    pub setup: Setup,
    pub pass: HotPass,
    /// Martensite that it leaves in the corner of the least heat; `None` where the model has no such wire.
    pub left_at_worst: Option<f64>,
    pub prescale: Prescale,
    /// Energy that the guard books for a burst, nJ.
    pub burst_nj: u64,
    /// Wires of the display.
    wires: u16,
}

impl Planned {
    /// Every burst of the pass: wire, and what the guard books, from the beginning of its run on.
    pub fn bookings(&self) -> Vec<(u16, Booked)> {
        let HotPass {
            burst,
            bursts,
            again,
            apart,
            ..
        } = self.pass;
        let each = |wire: u16| {
            (0..u64::from(bursts)).map(move |index| {
                let after_us = u64::from(wire) * apart.as_micros() + index * again.as_micros();
                let on = PASS_AT + Duration::from_micros(after_us);
                let off = on + burst;
                (
                    wire,
                    Booked {
                        on,
                        off,
                        energy_nj: self.burst_nj,
                    },
                )
            })
        };
        (0..self.wires).flat_map(each).collect()
    }
}

/// Plans the pass of a setup whose wires are cold, or says why a pass would not last.
///
/// # Errors
/// [`Failure::Input`] for a setup that fits no loop.
pub(super) fn plan(setup: &Setup) -> Result<Result<Planned, &'static str>, Failure> {
    let mut own = silent(setup);
    // A unit's boards keep the clock that they were started with: the scene's.
    let hz = match setup.bench.value.unit {
        None => plan::PWM_HZ,
        Some(_) => {
            let prescale = build(&first(setup), 1, Levels::Off)?.guard().prescale();
            1e9 / prescale.period_ns() as f64
        }
    };
    own.bench.value.drive.pwm_hz = Some(hz);
    let alone = first(&own);
    let projector = build(&alone, 1, Levels::Off)?;
    let (guard, display) = (projector.guard(), projector.display());
    let heated = Heated::new(&alone, guard.prescale());
    if let Err(why) = lasts(&alone) {
        return Ok(Err(why));
    }
    let pass = choose(&heated, guard, display, &alone);
    let wires = display.wires().len() as u16; // a display has at most 256 wires
    own.scene.value.length_s =
        PASS_AT.as_micros() as f64 * 1e-6 + f64::from(wires) * pass.apart.as_secs_f64() + AFTER_S;
    own.pass = Pass::Itself(pass);
    Ok(Ok(Planned {
        setup: own,
        pass,
        left_at_worst: heated.left_at_worst(&pass).ok(),
        prescale: guard.prescale(),
        burst_nj: guard.energy_nj(pass.width, pass.burst),
        wires,
    }))
}

/// The setup of the first finger.
fn first(setup: &Setup) -> Setup {
    let alone = fingers(setup).into_iter().next();
    alone.map_or_else(|| setup.clone(), |(_, alone)| alone)
}

/// Checks that a pass would last on a setup's finger.
pub(super) fn lasts(setup: &Setup) -> Result<(), &'static str> {
    let tissue = setup.bench.value.tissue.parameters();
    lasting(&plan::wire(setup), &tissue).map(|_| ())
}

/// Pulses of a pass by the boards' clock of a loop on a setup's bench, or the reason why there is none.
pub(super) fn of_loop(setup: &Setup, projector: &Projector) -> Result<HotPass, &'static str> {
    let guard = projector.guard();
    let heated = Heated::new(setup, guard.prescale());
    lasts(setup)?;
    Ok(choose(&heated, guard, projector.display(), setup))
}

/// The scene's skin and the bench's display without anything that touches, moves or fails.
fn silent(setup: &Setup) -> Setup {
    let mut own = setup.clone();
    own.texture = None;
    let scene = &mut own.scene.value;
    "hot pass".clone_into(&mut scene.name);
    scene.reference_frames = NO_REFERENCE;
    scene.compression.levels = LevelsFrom::Dynamic;
    scene.illusion = Illusion {
        model: IllusionModel::Nearest,
        soa_ms: Some(SOA_MS as f64),
        person: scene.illusion.person.clone(),
        wearer: scene.illusion.wearer.clone(),
        ..Illusion::default()
    };
    scene.touches.clear();
    scene.materials.clear();
    scene.strokes.clear();
    scene.faults.clear();
    scene.joints.clear();
    scene.texture = None;
    scene.stream = None;
    for finger in &mut own.fingers {
        finger.texture = None;
        finger.strokes.clear();
        finger.when = None;
    }
    own
}

/// The fewest bursts, and of these the fewest pulses, that pass the wire in the corner of the least heat and that the guard
/// bears. Where there are none: what the guard bears and leaves the least there. Where the guard bears nothing that passes the
/// wire as it is stated: the fewest pulses that would, for the guard to refuse.
fn choose(heated: &Heated, guard: &Guard, display: &Display, setup: &Setup) -> HotPass {
    let half_ns = guard.prescale().period_ns() / 2;
    let of = |bursts: u8, pulses: u64| HotPass {
        width: guard.widest(),
        burst: Duration::from_micros((2 * pulses - 1) * half_ns / 1000),
        bursts,
        again: AGAIN,
        apart: Duration::from_micros(AGAIN.as_micros() * u64::from(bursts)).max(APART),
    };
    let (mut best, mut refused) = (None::<(f64, HotPass)>, None);
    for bursts in 1..=MOST.0 {
        for pulses in 1..=MOST.1 {
            let pass = of(bursts, pulses);
            if heated.left(&pass).is_ok_and(|left| left >= PASSED) {
                continue;
            }
            refused.get_or_insert(pass);
            if !bears(guard, display, setup, &pass) {
                break;
            }
            let left = heated.left_at_worst(&pass).unwrap_or(0.0);
            if left < PASSED {
                return pass;
            }
            if best.is_none_or(|(least, _)| left < least) {
                best = Some((left, pass));
            }
        }
    }
    best.map(|(_, pass)| pass)
        .or(refused)
        .unwrap_or_else(|| of(1, MOST.1))
}

/// Tells whether a guard would pass every burst of every wire as it is planned, with each off late and each burst early.
fn bears(guard: &Guard, display: &Display, setup: &Setup, pass: &HotPass) -> bool {
    let mut guard = guard.clone();
    let mut start = PASS_AT;
    let mut is_whole = true;
    for (index, wire) in display.wires().iter().enumerate() {
        for burst in 0..u64::from(pass.bursts) {
            let again_us = pass.again.as_micros() - LATE.as_micros();
            let at = start + Duration::from_micros(again_us * burst);
            let until = at + pass.burst;
            let stimulus = Stimulus {
                wire: index as u16, // a display has at most 256 wires
                width: pass.width,
                peak: plan::milliamps(setup.bench.value.drive.current_ma),
                at,
                until,
            };
            guard.hear(at);
            let update = guard.admit(at, wire.board, &[stimulus], |entry| {
                is_whole &= entry.reason.is_none();
            });
            guard.confirm(&update, at);
            let off = guard.release(until, wire.board);
            guard.confirm(&off, until + LATE);
            if !is_whole {
                return false;
            }
        }
        start += pass.apart;
    }
    is_whole
}
