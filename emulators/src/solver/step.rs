//! One stretch of constant drive, from event to event.

use super::Drive;
use super::exact::{Exact, Heat};
use super::modal::{PROBES, Propagator, dot};
use super::sum::{LEVEL_TOLERANCE, changes};
use crate::finger::NODES;
use crate::time::Nanos;
use crate::wire::phase::{Heading, Segment};
use crate::wire::record::Peaks;

/// Events in one stretch after which the rest is taken in the regime reached. A bound on the work,
/// far beyond what a wire can do: each event needs a threshold passed or a turn of the temperature.
const EVENTS: usize = 100_000;

/// Growths (e-foldings) computed at once in electrical runaway.
const RUNAWAY: f64 = 20.0;
/// In so short a step the skin turns at most once, s: its fastest change takes milliseconds.
const SHORT_S: f64 = 250e-6;

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
            let mut propagator = if whole {
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
                self.accept(&mut propagator, &end, &heat, power, stretch);
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
            let mut propagator = Propagator::new(&self.modes[self.mode], after);
            let end = propagator.step(&self.modes[self.mode], &self.z, power);
            self.accept(&mut propagator, &end, &heat, power, after);
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
        let rate = mode.rate(&self.z, power);
        let monotone = changes(&product(&mode.gain, &rate)) == 0;
        if monotone && last >= low && last <= high && !(segment.one_way && backward(first, last)) {
            return None;
        }
        let sum = mode.sum(&mode.gain, &self.z, power, base);
        let (mut from, mut before) = (0.0, first);
        loop {
            let turn = sum.next_turn(from, span);
            let to = turn.unwrap_or(span);
            let value = if turn.is_some() { sum.value(to) } else { last };
            if segment.one_way && backward(before, value) {
                return Some((from, Event::Turn));
            }
            if value > high {
                let at = sum.crossing(segment.high, from, to);
                return Some((at, Event::Threshold(segment.high, Heading::Up)));
            }
            if value < low {
                let at = sum.crossing(segment.low, from, to);
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
        propagator: &mut Propagator,
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
        let seen = Peaks {
            wire_c: self.wire_peak_within(&rate, end, power, span),
            shallow_c: self.skin_peak_within(&mode.shallow, &rate, end, power, propagator),
            deep_c: self.skin_peak_within(&mode.deep, &rate, end, power, propagator),
        };
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
        power: f64,
        span: f64,
    ) -> f64 {
        let mode = &self.modes[self.mode];
        let base = self.network.body_c;
        let mut top = base + dot(&mode.gain, &self.z).max(dot(&mode.gain, end));
        let slopes = product(&mode.gain, &rate.0);
        let turns = changes(&slopes);
        if turns > 1
            || (turns == 1 && slopes.iter().sum::<f64>() > 0.0 && dot(&mode.gain, &rate.1) < 0.0)
        {
            let sum = mode.sum(&mode.gain, &self.z, power, base);
            let mut from = 0.0;
            while let Some(turn) = sum.next_turn(from, span) {
                top = top.max(sum.value(turn));
                from = turn;
            }
        }
        top
    }

    /// The maximum at a depth over a step. Heat of a pulse arrives after the pulse, so that the slope may
    /// be negative at both ends with a peak between; it is probed at times spaced as diffusion is slow.
    fn skin_peak_within(
        &self,
        row: &[f64; NODES],
        rate: &([f64; NODES], [f64; NODES]),
        end: &[f64; NODES],
        power: f64,
        propagator: &mut Propagator,
    ) -> f64 {
        let mode = &self.modes[self.mode];
        let base = self.network.body_c;
        let mut top = base + dot(row, &self.z).max(dot(row, end));
        let slopes = product(row, &rate.0);
        let last = dot(row, &rate.1);
        let first = slopes.iter().sum::<f64>();
        if changes(&slopes) == 0 {
            return top;
        }
        let span = propagator.span();
        let mut seen = [(span, last); PROBES + 2];
        let mut count = 1;
        seen[0] = (0.0, first);
        if span > SHORT_S {
            let probes = propagator.probes(mode);
            for (at, slope) in probes.times.into_iter().zip(probes.of(&slopes)) {
                seen[count] = (at, slope);
                count += 1;
            }
        }
        let sum = mode.sum(row, &self.z, power, base);
        for i in 0..=count {
            let (here, next) = (seen[i], seen[(i + 1).min(count)]);
            if here.1 > 0.0 && next.1 < 0.0 {
                top = top.max(sum.value(sum.turn_between(here.0, next.0)));
                continue;
            }
            // Nearly turned: between the neighbours the slope may have changed sign and back.
            let before = seen[i.saturating_sub(1)];
            let side = if here.1 > 0.0 { -1.0 } else { 1.0 };
            let falls = if i < count {
                side * next.1 < side * here.1
            } else {
                side * sum.bend(span) < 0.0
            };
            // Probes lie close: the extreme is nearer to `here` than its further neighbour is.
            let reach = (here.1 - before.1).abs().max((here.1 - next.1).abs());
            let far = here.1.abs() > reach;
            if i == 0 || side * before.1 >= side * here.1 || !falls || far {
                continue;
            }
            let extreme = sum.steepest_between(before.0, next.0, side);
            let slope = sum.slope(extreme);
            if side > 0.0 && slope > 0.0 {
                top = top.max(sum.value(sum.turn_between(extreme, next.0)));
            } else if side < 0.0 && slope < 0.0 {
                top = top.max(sum.value(sum.turn_between(before.0, extreme)));
            }
        }
        top
    }
}

fn product(a: &[f64; NODES], b: &[f64; NODES]) -> [f64; NODES] {
    core::array::from_fn(|k| a[k] * b[k])
}
