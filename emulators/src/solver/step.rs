//! One stretch of constant drive, from event to event.

use super::Drive;
use super::exact::{Exact, Heat};
use super::highest::Point;
use super::modal::{Mode, Propagator, dot};
use super::sum::{LEVEL_TOLERANCE, changes};
use crate::finger::NODES;
use crate::time::Nanos;
use crate::wire::phase::{Heading, Segment};

/// Events in one stretch after which the rest is taken in the regime reached. A bound on the work,
/// far beyond what a wire can do: each event needs a threshold passed or a turn of the temperature.
const EVENTS: usize = 100_000;

/// Growths (e-foldings) computed at once in electrical runaway.
const RUNAWAY: f64 = 20.0;

/// What ends a step early.
enum Event {
    /// The wire passed this temperature on this heading.
    Threshold(f64, Heading),
    /// The wire's temperature turned.
    Turn,
}

impl Exact {
    /// Computes `span` with the drive as it is.
    pub(super) fn run(&mut self, span: Nanos) {
        let mut left = span.as_secs_f64();
        let mut whole = true;
        // After an event the threshold itself is the temperature, whatever rounding made of it.
        let mut at = None;
        for round in 0.. {
            let t = self.wire_c();
            let segment = self.phase.segment(at.take().unwrap_or(t), self.heading);
            let heat = self.heat(t, &segment);
            self.enter(super::modal::ModeKey {
                phase_slope: -segment.slope,
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
            let propagator = if whole {
                self.borrow(span.0)
            } else {
                Box::new(Propagator::new(&self.modes[self.mode], stretch))
            };
            let mode = &self.modes[self.mode];
            let start = Start::new(mode, &self.z, t, heat, power);
            let end = propagator.step(mode, &self.z, power);
            let event = if round < EVENTS {
                self.first_event(&segment, &start, &end, stretch)
            } else {
                None
            };
            if event.is_none() {
                self.accept(&propagator, &start, &end, stretch);
            }
            if whole {
                self.give_back(span.0, propagator);
            }
            let Some((after, event)) = event else {
                left -= stretch;
                if left > 0.0 {
                    continue;
                }
                return;
            };
            let propagator = Propagator::new(&self.modes[self.mode], after);
            let end = propagator.step(&self.modes[self.mode], &self.z, power);
            self.accept(&propagator, &start, &end, after);
            if let Event::Threshold(threshold, _) = event {
                at = Some(threshold);
            }
            self.take(&event);
            left -= after;
            whole = false;
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
            Event::Threshold(at, heading) if heading != self.heading => {
                self.heading = heading;
                self.phase.turn(at, heading);
            }
            Event::Threshold(at, _) => self.phase.commit(at),
        }
    }

    /// The first event within `span` seconds, if any; `end` is the state then if there is none.
    fn first_event(
        &self,
        segment: &Segment,
        start: &Start,
        end: &[f64; NODES],
        span: f64,
    ) -> Option<(f64, Event)> {
        let mode = &self.modes[self.mode];
        let base = self.network.body_c;
        let (first, last) = (start.wire_c, base + dot(&mode.gain, end));
        let (low, high) = (
            segment.low - LEVEL_TOLERANCE,
            segment.high + LEVEL_TOLERANCE,
        );
        let backward = |from: f64, to: f64| match self.heading {
            Heading::Up => to < from - LEVEL_TOLERANCE,
            Heading::Down => to > from + LEVEL_TOLERANCE,
        };
        if start.turns == 0
            && last >= low
            && last <= high
            && !(segment.one_way && backward(first, last))
        {
            return None;
        }
        let sum = mode.sum(start.slopes, first);
        let (mut from, mut before) = (0.0, first);
        loop {
            let turn = sum.next_turn(from, span);
            let to = turn.unwrap_or(span);
            let value = if turn.is_some() { sum.value(to) } else { last };
            if segment.one_way && backward(before, value) {
                return Some((from, Event::Turn));
            }
            if value > high {
                let at = sum.crossing(segment.high, from, to, true);
                return Some((at, Event::Threshold(segment.high, Heading::Up)));
            }
            if value < low {
                let at = sum.crossing(segment.low, from, to, false);
                return Some((at, Event::Threshold(segment.low, Heading::Down)));
            }
            turn?;
            if segment.one_way {
                return Some((to, Event::Turn));
            }
            (from, before) = (to, value);
        }
    }

    /// Moves the state to `end`, `span` seconds on, and keeps the books.
    fn accept(&mut self, propagator: &Propagator, start: &Start, end: &[f64; NODES], span: f64) {
        let mode = &self.modes[self.mode];
        let base = self.network.body_c;
        let course = Course::new(mode, base, propagator, start, (&self.z, end), span);
        let hottest = self.wire_peak_within(start, end, &course.rate, span);
        self.hottest = (self.hottest.0.max(hottest), self.hottest.1.max(hottest));
        self.deep.pass(&mode.lambda, &course.deep);
        self.shallow.pass(&mode.lambda, &course.shallow);
        if let Some(dose) = &mut self.dose {
            let [from, to] = &course.shallow;
            let sum = mode.sum(from.terms, from.value);
            dose.add(span, from.value, to.value, |t| sum.value(t));
            dose.celsius_s += course.skin + base * span;
        }

        let n = &*self.network;
        let into_wire = start.heat.power * span + start.heat.feedback * course.wire;
        let e = &mut self.energy;
        e.wire_j += into_wire;
        e.electrical_j += match self.drive {
            Drive::Off => 0.0,
            Drive::Power(watts) => watts * span,
            Drive::Current(amps) => {
                let series = self.wire.resistance_ohm * (1.0 - self.wire.wire_share);
                into_wire + amps * amps * series * span
            }
        };
        e.air_j += n.air * (course.wire + (n.body_c - n.air_c) * span);
        e.ends_j += n.ends * (course.wire + (n.body_c - n.ends_c) * span);
        e.body_j += n.chain[NODES - 1] * course.outer;
        self.z = *end;
    }

    /// The wire's maximum over a step that ends with the coordinates at `rate`: both ends and all turns between.
    fn wire_peak_within(
        &self,
        start: &Start,
        end: &[f64; NODES],
        rate: &[f64; NODES],
        span: f64,
    ) -> f64 {
        let mode = &self.modes[self.mode];
        let mut top = start.wire_c.max(self.network.body_c + dot(&mode.gain, end));
        let rises = start.slopes.iter().sum::<f64>() > 0.0;
        if start.turns > 1 || (start.turns == 1 && rises && dot(&mode.gain, rate) < 0.0) {
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

/// How a step begins.
struct Start {
    wire_c: f64,
    heat: Heat,
    /// Into the wire at the body's temperature, W.
    power: f64,
    /// Rate of change of the coordinates, 1/s of theirs.
    rate: [f64; NODES],
    /// Terms of the slope of the wire's temperature, K/s.
    slopes: [f64; NODES],
    /// How often that slope can change its sign from now on, at most.
    turns: usize,
}

impl Start {
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

/// What a step comes to.
struct Course {
    /// Time integrals of the temperatures of wire, outermost shell and skin at 0.1 mm above the body's, K s.
    wire: f64,
    outer: f64,
    skin: f64,
    /// Rate of change of the coordinates at the end.
    rate: [f64; NODES],
    /// The skin at 0.1 and at 0.4 mm, at both ends.
    shallow: [Point; 2],
    deep: [Point; 2],
}

impl Course {
    /// Of a step of `span` seconds between two states.
    fn new(
        mode: &Mode,
        base: f64,
        propagator: &Propagator,
        start: &Start,
        (z, end): (&[f64; NODES], &[f64; NODES]),
        span: f64,
    ) -> Self {
        let integral = propagator.integral(mode, z, start.power);
        let rate = mode.rate(end, start.power);
        Self {
            wire: dot(&mode.gain, &integral),
            outer: dot(mode.last(), &integral),
            skin: dot(&mode.shallow, &integral),
            rate,
            shallow: [
                point(base, &mode.shallow, 0.0, z, &start.rate),
                point(base, &mode.shallow, span, end, &rate),
            ],
            deep: [
                point(base, &mode.deep, 0.0, z, &start.rate),
                point(base, &mode.deep, span, end, &rate),
            ],
        }
    }
}

/// The temperature that `row` gives at `t`.
fn point(base: f64, row: &[f64; NODES], t: f64, z: &[f64; NODES], rate: &[f64; NODES]) -> Point {
    Point {
        t,
        value: base + dot(row, z),
        slope: dot(row, rate),
        terms: product(row, rate),
    }
}

fn product(a: &[f64; NODES], b: &[f64; NODES]) -> [f64; NODES] {
    core::array::from_fn(|k| a[k] * b[k])
}
