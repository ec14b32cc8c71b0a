//! A hand that presses a module on a surface and strokes: force, travel and friction as functions of time.
//!
//! The stroke is what touches the module: its face is cut into patches of one taxel's field, and each presses with
//! its share of the force, more where the pad is tilted or the relief is high. Pad and surface act as springs in
//! series, so a hard surface answers impact, tilt, tremor and relief with more force than a soft one.

use core::f64::consts::TAU;

use palpate_core::random::RandomStream;
use palpate_core::units::Point;

use super::SurfaceTexture;
use super::relief::{PATCH_MM, Relief};
use super::vibration::Riding;
use crate::sensor::{Press, Touches, grid};
use crate::time::Nanos;

/// Habits of a person's strokes; every stroke draws around these. All are assumed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Habits {
    /// Normal force, N.
    pub force_n: f64,
    /// Speed, mm/s.
    pub speed_mm_s: f64,
    /// Spread of force and speed from stroke to stroke, relative.
    pub spread: f64,
    /// Slow variation of force and speed within a stroke, relative.
    pub variation: f64,
    /// Tremor of the hand towards the surface, mm, root mean square.
    pub tremor_mm: f64,
    /// Standard deviation of the pad's tilt about each axis, radians.
    pub tilt_rad: f64,
    /// Standard deviation of the stroke's direction around the pad's long side, radians.
    pub heading_rad: f64,
    /// Speed of approach at impact, mm/s.
    pub approach_mm_s: f64,
}

impl Default for Habits {
    fn default() -> Self {
        Self {
            force_n: 3.0,
            speed_mm_s: 80.0,
            spread: 0.2,
            variation: 0.12,
            tremor_mm: 0.03,
            tilt_rad: 0.008,
            heading_rad: 0.1,
            approach_mm_s: 40.0,
        }
    }
}

impl Habits {
    /// Strokes of which force, speed, tilt and direction say nothing of the surface: nine in ten of them have 1.3 to 6.8 N
    /// and 36 to 180 mm/s, each drawn by itself, in any direction.
    pub fn varied() -> Self {
        Self {
            spread: 0.5,
            tilt_rad: 0.016,
            heading_rad: TAU,
            ..Self::default()
        }
    }
}

/// Step of the travel's table, s.
const STEP_S: f64 = 1e-3;
/// Time over which sliding starts, s.
const START_S: f64 = 0.12;
/// Sliding that loads the pad's shear up to friction, mm.
const SHEAR_MM: f64 = 1.5;
/// Sliding from one slip to the next, mm, and the share of a friction above 0.5 that each lets go.
pub(super) const SLIP_MM: f64 = 9.0;
const SLIP: f64 = 0.35;

/// Coefficient of friction after `travel` mm: built up with the first of it, and where it is high let go and gripped
/// again every few millimetres.
pub(super) fn held(friction: f64, slip_at: f64, travel: f64) -> f64 {
    let held = friction + let_go(friction) * (gripped(slip_at, travel) - 0.5);
    (1.0 - libm::exp(-travel / SHEAR_MM)) * held
}

/// The part of the way from the last slip to the next one, 0 to 1.
fn gripped(slip_at: f64, travel: f64) -> f64 {
    let cycle = (travel + slip_at) / SLIP_MM;
    cycle - libm::floor(cycle)
}

/// Part of a coefficient of friction that a slip lets go.
fn let_go(friction: f64) -> f64 {
    SLIP * (friction - 0.5).max(0.0)
}

/// A sum of three slow sines: root mean square 1 before scaling.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sway([(f64, f64); 3]);

impl Sway {
    fn new(stream: &mut RandomStream, low_hz: f64, high_hz: f64) -> Self {
        Self(core::array::from_fn(|_| {
            let rate = TAU * (low_hz + (high_hz - low_hz) * stream.uniform());
            (rate, TAU * stream.uniform())
        }))
    }

    fn at(&self, t: f64) -> f64 {
        let sum: f64 = self
            .0
            .iter()
            .map(|(rate, phase)| libm::sin(rate * t + phase))
            .sum();
        sum * libm::sqrt(2.0 / 3.0)
    }
}

/// One stroke over one piece of a texture, from before the impact to its end. After that the module is in the air.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceStroke {
    begins: Nanos,
    seconds: f64,
    relief: Relief,
    friction: f64,
    stiffness: f64,
    force_n: f64,
    impact_s: f64,
    approach_mm_s: f64,
    tremor_mm: f64,
    variation: f64,
    tilt: [f64; 2],
    heading: [f64; 2],
    slow: Sway,
    tremor: Sway,
    slip_at: f64,
    /// Travel, mm, at every step since `begins`.
    travel: Vec<f64>,
    patches: Vec<Point>,
}

impl SurfaceStroke {
    /// Stroke `number` over `texture` by a person with these `habits`, beginning at `begins` and `seconds` long
    /// (0.1 to 3600), on a module whose silicone has a time constant of `lag_s`. Each number is another draw.
    pub fn new(
        texture: &SurfaceTexture,
        habits: &Habits,
        (seed, number): (u64, u32),
        (begins, seconds): (Nanos, f64),
        lag_s: f64,
    ) -> Self {
        let mut stream = RandomStream::new(seed, &format!("stroke {number} over {}", texture.name));
        let relief = Relief::new(texture, lag_s, &mut stream);
        let mut around = |middle: f64| middle * libm::exp(habits.spread * stream.normal());
        let (force_n, speed) = (around(habits.force_n), around(habits.speed_mm_s));
        let approach_mm_s = around(habits.approach_mm_s);
        let tilt = [
            habits.tilt_rad * stream.normal(),
            habits.tilt_rad * stream.normal(),
        ];
        let angle = habits.heading_rad * stream.normal();
        let impact_s = 0.04 + 0.08 * stream.uniform();
        let moves_s = impact_s + 0.08 + 0.12 * stream.uniform();
        let slow = Sway::new(&mut stream, 0.4, 2.0);
        let swing = Sway::new(&mut stream, 0.4, 2.0);
        let tremor = Sway::new(&mut stream, 7.0, 11.0);
        let seconds = seconds.clamp(0.1, 3600.0);
        let mut travel = vec![0.0];
        let mut gone = 0.0;
        for step in 0..(seconds / STEP_S) as usize {
            let t = (step as f64 + 0.5) * STEP_S;
            let ramp = ((t - moves_s) / START_S).clamp(0.0, 1.0);
            let smooth = ramp * ramp * (3.0 - 2.0 * ramp);
            let pace = (1.0 + habits.variation * swing.at(t)).max(0.05);
            gone += speed * smooth * pace * STEP_S;
            travel.push(gone);
        }
        Self {
            begins,
            seconds,
            relief,
            friction: texture.friction,
            stiffness: texture.contact_stiffness(),
            force_n,
            impact_s,
            approach_mm_s,
            tremor_mm: habits.tremor_mm,
            variation: habits.variation,
            tilt,
            heading: [libm::cos(angle), libm::sin(angle)],
            slow,
            tremor,
            slip_at: SLIP_MM * stream.uniform(),
            travel,
            // the module's face, 24 x 28 mm
            patches: grid(6, 5, PATCH_MM),
        }
    }

    /// Length of the stroke, s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Time since it began, s, while it lasts.
    fn time(&self, now: Nanos) -> Option<f64> {
        if now < self.begins {
            return None;
        }
        let t = now.since(self.begins).as_secs_f64();
        (t < self.seconds).then_some(t)
    }

    /// Travel since the beginning, mm, and speed, mm/s.
    pub fn progress(&self, now: Nanos) -> (f64, f64) {
        let steps = self.time(now).unwrap_or(0.0) / STEP_S;
        let last = self.travel.len().saturating_sub(2);
        let index = (steps as usize).min(last);
        let (from, to) = (self.travel[index], self.travel[index + 1]);
        let share = (steps - index as f64).min(1.0);
        (from + share * (to - from), (to - from) / STEP_S)
    }

    /// Normal force over the whole pad, N, without the relief.
    pub fn force(&self, now: Nanos) -> f64 {
        let Some(t) = self.time(now) else { return 0.0 };
        let since = t - self.impact_s;
        if since <= 0.0 {
            return 0.0;
        }
        let wanted = self.force_n * (1.0 + self.variation * self.slow.at(t));
        // The hand comes on at its speed until the springs carry the wanted force, and overshoots by what it needs
        // to stop: 8 ms of travel, which then dies away.
        let loaded = (self.stiffness * self.approach_mm_s * since / wanted.max(1e-3)).min(1.0);
        let bounce = self.stiffness * self.approach_mm_s * 0.008 * libm::exp(-since / 0.06);
        let tremor = self.stiffness * self.tremor_mm * self.tremor.at(t);
        (loaded * (wanted + bounce * libm::cos(TAU * 12.0 * since) + tremor)).max(0.0)
    }

    /// Acceleration of the module's body along its axes, m/s2: what relief, impact and slips shake it with, not how the hand
    /// moves, which the taxels tell.
    pub fn acceleration(&self, now: Nanos) -> [f64; 3] {
        let force = self.force(now);
        let Some(t) = self.time(now).filter(|_| force > 0.0) else {
            return [0.0; 3];
        };
        let (travel, speed) = self.progress(now);
        let riding = Riding::on(self.stiffness);
        let [along, normal] =
            (self.relief).shakes(riding, (travel, speed), [force, self.stiffness]);
        let since_slip = gripped(self.slip_at, travel) * SLIP_MM / speed.max(1e-3);
        let slip = riding.let_go(force * let_go(self.friction), since_slip);
        let impact = riding.met(self.approach_mm_s, t - self.impact_s);
        let [x, y] = self.heading.map(|part| part * (along + slip));
        [x, y, normal + impact]
    }
}

/// Strokes one after another on one module.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceStrokes(pub Vec<SurfaceStroke>);

impl SurfaceStrokes {
    fn current(&self, now: Nanos) -> Option<&SurfaceStroke> {
        self.0.iter().find(|stroke| stroke.time(now).is_some())
    }
}

impl Touches for SurfaceStrokes {
    fn touches(&self, now: Nanos, out: &mut Vec<Press>) {
        if let Some(stroke) = self.current(now) {
            stroke.touches(now, out);
        }
    }

    fn drag(&self, now: Nanos) -> [f64; 2] {
        self.current(now)
            .map_or([0.0; 2], |stroke| stroke.drag(now))
    }
}

impl Touches for SurfaceStroke {
    fn touches(&self, now: Nanos, out: &mut Vec<Press>) {
        let force = self.force(now);
        if force <= 0.0 {
            return;
        }
        let (travel, speed) = self.progress(now);
        let count = self.patches.len() as f64;
        let spring = self.stiffness / count;
        for &at in &self.patches {
            let (x, y) = (f64::from(at.x), f64::from(at.y));
            let tilted = spring * (self.tilt[0] * x + self.tilt[1] * y);
            let [c, s] = self.heading;
            let (along, across) = (travel + c * x + s * y, c * y - s * x);
            let relief = spring * self.relief.height(along, across, speed);
            out.push(Press {
                at,
                // a patch under a valley or on the lifted side carries nothing
                force_n: (force / count + tilted + relief).max(0.0),
                diameter_mm: PATCH_MM,
            });
        }
    }

    /// Friction drags the skin against the stroke. It builds up with the first travel; a high one lets go and grips
    /// again every few millimetres; and the relief's slopes come on top.
    fn drag(&self, now: Nanos) -> [f64; 2] {
        let (travel, speed) = self.progress(now);
        if self.time(now).is_none() || travel <= 0.0 {
            return [0.0; 2];
        }
        let drag = -(held(self.friction, self.slip_at, travel) + self.relief.slope(travel, speed));
        self.heading.map(|part| part * drag)
    }
}
