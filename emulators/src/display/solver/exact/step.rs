//! One stretch of constant drive, from event to event.

use super::{Exact, Heat, Watched};
use crate::display::finger::NODES;
use crate::display::solver::WireDrive;
use crate::display::solver::branch::Heading;
use crate::display::solver::lanes::dot;
use crate::display::solver::modal::{Mode, ModeKey, Propagator};
use crate::display::solver::stretch::Stretch;
use crate::display::solver::sum::{LEVEL_TOLERANCE, SumPoint, changes};
use crate::time::Nanos;
use palpate_core::physics::Line;
use palpate_core::vector::{Simd, WithSimd};

/// Events in one stretch after which the rest is taken in the regime reached. A bound on the work,
/// far beyond what a wire can do: each event needs a threshold passed or a turn of the temperature.
const EVENTS: usize = 100_000;

/// Growths (e-foldings) computed at once in electrical runaway.
const RUNAWAY: f64 = 20.0;

/// Events that end a step early.
enum Event {
    /// The wire passed this temperature on this heading.
    Threshold(f64, Heading),
    /// The wire's temperature turned.
    Turn,
}

/// A stretch of time to compute with the drive as it is.
pub(super) struct Advance<'a>(pub(super) &'a mut Exact, pub(super) Nanos);

impl WithSimd for Advance<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.0.run(simd, self.1);
    }
}

/// A look at the end of such a stretch, where no event lies in it: wire and tissue at 0.1 mm, K above the body.
pub(super) struct Glance<'a>(pub(super) &'a Exact, pub(super) Nanos);

impl WithSimd for Glance<'_> {
    type Output = Option<[f64; 2]>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<[f64; 2]> {
        self.0.glance_within(simd, self.1)
    }
}

impl Exact {
    /// Result of [`Self::run`], where it takes one round in the regime that the wire is in.
    #[inline(always)]
    fn glance_within<S: Simd>(&self, simd: S, span: Nanos) -> Option<[f64; 2]> {
        let (span, t) = (span.as_secs_f64(), self.wire_c());
        let branch = self.phase.branch();
        let heat = self.heat(t, &branch);
        let mode = &self.modes[self.mode];
        let key = ModeKey {
            latent: branch.latent,
            feedback: heat.feedback,
        };
        if mode.key != key || mode.lambda[0] < 0.0 {
            return None;
        }
        let power = heat.power + self.network.rest_inflow();
        let start = Start::new(mode, &self.z, t, heat, power);
        let end = Propagator::new(mode, span).step(mode, &self.z, power);
        let wire = dot(simd, &mode.gain, &end);
        let event = self.first_event(&branch, &start, self.network.body_c + wire, span);
        event
            .is_none()
            .then(|| [wire, dot(simd, &mode.shallow, &end)])
    }

    /// Computes `span` with the drive as it is.
    #[inline(always)]
    fn run<S: Simd>(&mut self, simd: S, span: Nanos) {
        let mut left = span.as_secs_f64();
        let mut whole = true;
        // After an event the threshold itself is the temperature, whatever rounding made of it.
        let mut at = None;
        for round in 0.. {
            let t = self.wire_c();
            let place = at.take().unwrap_or(t);
            let branch = self.phase.branch();
            self.touch(place);
            let heat = self.heat(t, &branch);
            self.enter(ModeKey {
                latent: branch.latent,
                feedback: heat.feedback,
            });
            let power = heat.power + self.network.rest_inflow();
            // A regime of electrical runaway grows without bound: look for its end in steps that cannot overflow.
            let growth = -self.modes[self.mode].lambda[0];
            let stretch = if growth > 0.0 {
                left.min(RUNAWAY / growth)
            } else {
                left
            };
            whole &= stretch >= left;
            if whole {
                self.propagators
                    .prepare(self.mode, &self.modes[self.mode], span.0);
            }
            let mode = &self.modes[self.mode];
            let kept = whole.then(|| self.propagators.first());
            let mut part;
            let mut propagator = if let Some(kept) = kept {
                &kept.propagator
            } else {
                part = Propagator::new(mode, stretch);
                &part
            };
            let start = Start::new(mode, &self.z, t, heat, power);
            let mut end = propagator.step(mode, &self.z, power);
            let mut wire = dot(simd, &mode.gain, &end);
            let event = if round < EVENTS {
                self.first_event(&branch, &start, self.network.body_c + wire, stretch)
            } else {
                None
            };
            let mut passed = stretch;
            if let Some((after, _)) = event {
                part = Propagator::new(mode, after);
                propagator = &part;
                end = propagator.step(mode, &self.z, power);
                wire = dot(simd, &mode.gain, &end);
                passed = after;
            }
            let ramp = match (kept, &event) {
                (Some(kept), None) => kept.ramp,
                _ => propagator.ramp(mode),
            };
            let integral = propagator.integral(mode, &ramp, &self.z, power);
            let course = self.course(simd, &integral, &start, (&end, wire), passed);
            self.accept(simd, &start, &course, passed);
            self.z = end;
            left -= passed;
            if let Some((_, event)) = event {
                if let Event::Threshold(threshold, _) = event {
                    at = Some(threshold);
                }
                self.take(&event);
                whole = false;
            }
            if left <= 0.0 {
                return;
            }
        }
    }

    /// Changes heading and memory as an event asks.
    fn take(&mut self, event: &Event) {
        match *event {
            Event::Turn => self.turn(match self.heading {
                Heading::Up => Heading::Down,
                Heading::Down => Heading::Up,
            }),
            Event::Threshold(at, heading) => {
                self.heading = heading;
                self.phase.commit(at, heading);
            }
        }
    }

    /// The first event within `span` seconds, if any; `last` is the wire's temperature then if there is none.
    #[inline(always)]
    fn first_event(
        &self,
        branch: &Line,
        start: &Start,
        last: f64,
        span: f64,
    ) -> Option<(f64, Event)> {
        let first = start.wire_c;
        let (low, high) = (branch.low - LEVEL_TOLERANCE, branch.high + LEVEL_TOLERANCE);
        let backward = |from: f64, to: f64| match self.heading {
            Heading::Up => to < from - LEVEL_TOLERANCE,
            Heading::Down => to > from + LEVEL_TOLERANCE,
        };
        if start.turns == 0
            && last >= low
            && last <= high
            && !(branch.one_way && backward(first, last))
        {
            return None;
        }
        let sum = self.modes[self.mode].sum(start.slopes, first);
        let (mut from, mut before) = (0.0, first);
        loop {
            let turn = match start.turns {
                0 => None,
                _ => sum.next_turn(from, span),
            };
            let to = turn.unwrap_or(span);
            let value = if turn.is_some() { sum.value(to) } else { last };
            if branch.one_way && backward(before, value) {
                return Some((from, Event::Turn));
            }
            if value > high {
                let at = sum.crossing(branch.high, from, to, true);
                return Some((at, Event::Threshold(branch.high, Heading::Up)));
            }
            if value < low {
                let at = sum.crossing(branch.low, from, to, false);
                return Some((at, Event::Threshold(branch.low, Heading::Down)));
            }
            turn?;
            if branch.one_way {
                return Some((to, Event::Turn));
            }
            (from, before) = (to, value);
        }
    }

    /// The course of a step that has this time integral of its coordinates and ends at the coordinates `end`, with
    /// the wire `wire` K above the body.
    #[inline(always)]
    fn course<S: Simd>(
        &self,
        simd: S,
        integral: &[f64; NODES],
        start: &Start,
        (end, wire): (&[f64; NODES], f64),
        span: f64,
    ) -> Course {
        let (mode, base) = (&self.modes[self.mode], self.network.body_c);
        let rate = mode.rate(end, start.power);
        let before = &self.watched;
        let after = Watched {
            wire,
            shallow: dot(simd, &mode.shallow, end),
            deep: dot(simd, &mode.deep, end),
        };
        Course {
            wire: dot(simd, &mode.gain, integral),
            outer: dot(simd, mode.last(), integral),
            tissue: dot(simd, &mode.shallow, integral),
            shallow: [
                point(
                    simd,
                    (0.0, base + before.shallow),
                    &mode.shallow,
                    &start.rate,
                ),
                point(simd, (span, base + after.shallow), &mode.shallow, &rate),
            ],
            deep: [
                point(simd, (0.0, base + before.deep), &mode.deep, &start.rate),
                point(simd, (span, base + after.deep), &mode.deep, &rate),
            ],
            hottest: self.hottest_within(simd, start, base + wire, &rate, span),
            after,
        }
    }

    /// Keeps the books of a step of `span` seconds.
    #[inline(always)]
    fn accept<S: Simd>(&mut self, simd: S, start: &Start, course: &Course, span: f64) {
        let mode = &self.modes[self.mode];
        let top = course.hottest;
        self.hottest = (self.hottest.0.max(top), self.hottest.1.max(top));
        self.deep.pass(simd, &mode.lambda, &course.deep);
        self.shallow.pass(simd, &mode.lambda, &course.shallow);
        let n = &*self.network;
        if let Some(dose) = &mut self.dose {
            let [from, to] = &course.shallow;
            let sum = mode.sum(from.terms, from.value);
            dose.add(span, from.value, to.value, |t| sum.value(t));
            dose.celsius_s += course.tissue + n.body_c * span;
        }
        if let Some(stretches) = &mut self.stretches {
            stretches.push(Stretch {
                seconds: span,
                driven: self.drive != WireDrive::Off,
                um_per_k: self.motion.m_per_k * 1e6,
                regime: mode.key,
                rates: mode.lambda,
                slopes: start.slopes,
            });
        }
        let into_wire = start.heat.power * span + start.heat.feedback * course.wire;
        let e = &mut self.energy;
        e.wire_j += into_wire;
        e.electrical_j += match self.drive {
            WireDrive::Off => 0.0,
            WireDrive::Power(watts) => watts * span,
            WireDrive::Current(amps) => {
                let series = self.wire.resistance_ohm * (1.0 - self.wire.wire_share);
                into_wire + amps * amps * series * span
            }
        };
        e.air_j += n.air * (course.wire + (n.body_c - n.air_c) * span);
        e.ends_j += n.ends * (course.wire + (n.body_c - n.ends_c) * span);
        e.body_j += n.chain[NODES - 1] * course.outer;
        self.watched = course.after;
    }

    /// The wire's maximum over a step that ends at `last` with the coordinates at `rate`: both ends and all turns
    /// between.
    #[inline(always)]
    fn hottest_within<S: Simd>(
        &self,
        simd: S,
        start: &Start,
        last: f64,
        rate: &[f64; NODES],
        span: f64,
    ) -> f64 {
        let mode = &self.modes[self.mode];
        let mut top = start.wire_c.max(last);
        let peak = || start.slopes.iter().sum::<f64>() > 0.0 && dot(simd, &mode.gain, rate) < 0.0;
        if start.turns > 1 || (start.turns == 1 && peak()) {
            let sum = mode.sum(start.slopes, start.wire_c);
            let mut from = 0.0;
            while let Some(turn) = sum.next_turn(from, span) {
                top = top.max(sum.value(turn));
                from = turn;
            }
        }
        top
    }
}

/// State at the beginning of a step.
struct Start {
    wire_c: f64,
    heat: Heat,
    /// Heat into the wire at the body's temperature, W.
    power: f64,
    /// Rate of change of the coordinates, 1/s of theirs.
    rate: [f64; NODES],
    /// Terms of the slope of the wire's temperature, K/s.
    slopes: [f64; NODES],
    /// Most often that the slope can still change its sign.
    turns: usize,
}

impl Start {
    #[inline(always)]
    fn new(mode: &Mode, z: &[f64; NODES], wire_c: f64, heat: Heat, power: f64) -> Self {
        let rate = mode.rate(z, power);
        let slopes = product(&mode.gain, &rate);
        Self {
            wire_c,
            heat,
            power,
            turns: changes(&slopes),
            rate,
            slopes,
        }
    }
}

/// Result of a step.
struct Course {
    /// Time integrals of the temperatures of wire, outermost shell and tissue at 0.1 mm above the body's, K s.
    wire: f64,
    outer: f64,
    tissue: f64,
    /// The tissue at 0.1 and at 0.4 mm, at both ends.
    shallow: [SumPoint; 2],
    deep: [SumPoint; 2],
    /// Hottest the wire was, degrees C.
    hottest: f64,
    /// Watched temperatures at the end of the step.
    after: Watched,
}

/// An instant of the temperature that `row` gives, `value` then.
#[inline(always)]
fn point<S: Simd>(
    simd: S,
    (t, value): (f64, f64),
    row: &[f64; NODES],
    rate: &[f64; NODES],
) -> SumPoint {
    SumPoint {
        t,
        value,
        slope: dot(simd, row, rate),
        terms: product(row, rate),
    }
}

/// Multiplies in a plain loop: closures of `from_fn` are compiled without the vectors.
#[inline(always)]
fn product(a: &[f64; NODES], b: &[f64; NODES]) -> [f64; NODES] {
    let mut out = [0.0; NODES];
    for k in 0..NODES {
        out[k] = a[k] * b[k];
    }
    out
}
