//! One stretch of constant drive, from event to event.

use super::Drive;
use super::exact::{Exact, Heat};
use super::highest::{Point, highest};
use super::modal::{Propagator, dot};
use super::sum::{LEVEL_TOLERANCE, Sum, changes};
use crate::finger::NODES;
use crate::time::Nanos;
use crate::wire::phase::{Heading, Segment};
use crate::wire::record::Peaks;

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
            let end = propagator.step(&self.modes[self.mode], &self.z, power);
            let event = if round < EVENTS {
                self.first_event(&segment, power, &end, stretch)
            } else {
                None
            };
            if event.is_none() {
                self.accept(&propagator, &end, &heat, power, stretch);
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
            self.accept(&propagator, &end, &heat, power, after);
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
        power: f64,
        end: &[f64; NODES],
        span: f64,
    ) -> Option<(f64, Event)> {
        let mode = &self.modes[self.mode];
        let base = self.network.body_c;
        let (first, last) = (self.wire_c(), base + dot(&mode.gain, end));
        let (low, high) = (
            segment.low - LEVEL_TOLERANCE,
            segment.high + LEVEL_TOLERANCE,
        );
        let backward = |from: f64, to: f64| match self.heading {
            Heading::Up => to < from - LEVEL_TOLERANCE,
            Heading::Down => to > from + LEVEL_TOLERANCE,
        };
        let slopes = product(&mode.gain, &mode.rate(&self.z, power));
        let monotone = changes(&slopes) == 0;
        if monotone && last >= low && last <= high && !(segment.one_way && backward(first, last)) {
            return None;
        }
        let sum = mode.sum(slopes, first);
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
    fn accept(
        &mut self,
        propagator: &Propagator,
        end: &[f64; NODES],
        heat: &Heat,
        power: f64,
        span: f64,
    ) {
        let mode = &self.modes[self.mode];
        let integral = propagator.integral(mode, &self.z, power);
        let wire = dot(&mode.gain, &integral);
        let outer = dot(mode.last(), &integral);
        let rate = (mode.rate(&self.z, power), mode.rate(end, power));
        let shallow = self.course(&mode.shallow, &rate, end, span);
        let deep = self.course(&mode.deep, &rate, end, span);
        let known = (
            self.peaks.shallow_c.min(self.window.shallow_c),
            self.peaks.deep_c.min(self.window.deep_c),
        );
        let seen = Peaks {
            wire_c: self.wire_peak_within(&rate, end, span),
            shallow_c: shallow.highest(known.0),
            deep_c: deep.highest(known.1),
        };
        let mut dose = self.dose;
        if let Some(dose) = &mut dose {
            let (first, last) = (shallow.from.value, shallow.to.value);
            dose.add(span, first, last, |t| shallow.sum.value(t));
            dose.celsius_s += dot(&mode.shallow, &integral) + self.network.body_c * span;
        }
        self.dose = dose;
        self.peaks.raise(&seen);
        self.window.raise(&seen);

        let n = &*self.network;
        let into_wire = heat.power * span + heat.feedback * wire;
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
        e.air_j += n.air * (wire + (n.body_c - n.air_c) * span);
        e.ends_j += n.ends * (wire + (n.body_c - n.ends_c) * span);
        e.body_j += n.chain[NODES - 1] * outer;
        self.z = *end;
    }

    /// The wire's maximum over a step, both ends and all turns between.
    fn wire_peak_within(
        &self,
        rate: &([f64; NODES], [f64; NODES]),
        end: &[f64; NODES],
        span: f64,
    ) -> f64 {
        let mode = &self.modes[self.mode];
        let base = self.network.body_c;
        let start = base + dot(&mode.gain, &self.z);
        let mut top = start.max(base + dot(&mode.gain, end));
        let slopes = product(&mode.gain, &rate.0);
        let turns = changes(&slopes);
        if turns > 1
            || (turns == 1 && slopes.iter().sum::<f64>() > 0.0 && dot(&mode.gain, &rate.1) < 0.0)
        {
            let sum = mode.sum(slopes, start);
            let mut from = 0.0;
            while let Some(turn) = sum.next_turn(from, span) {
                top = top.max(sum.value(turn));
                from = turn;
            }
        }
        top
    }

    /// The course of the temperature at a depth over a step.
    fn course<'a>(
        &'a self,
        row: &[f64; NODES],
        rate: &([f64; NODES], [f64; NODES]),
        end: &[f64; NODES],
        span: f64,
    ) -> Course<'a> {
        let at = |t: f64, z: &[f64; NODES], rate: &[f64; NODES]| Point {
            t,
            value: self.network.body_c + dot(row, z),
            slope: dot(row, rate),
            terms: product(row, rate),
        };
        let (from, to) = (at(0.0, &self.z, &rate.0), at(span, end, &rate.1));
        let sum = self.modes[self.mode].sum(from.terms, from.value);
        Course { sum, from, to }
    }
}

/// A temperature over a step: the whole of it, and its ends.
struct Course<'a> {
    sum: Sum<'a>,
    from: Point,
    to: Point,
}

impl Course<'_> {
    /// Its maximum, or `known` if that is higher.
    fn highest(&self, known: f64) -> f64 {
        highest(&self.sum, &self.from, &self.to, known)
    }
}

fn product(a: &[f64; NODES], b: &[f64; NODES]) -> [f64; NODES] {
    core::array::from_fn(|k| a[k] * b[k])
}
