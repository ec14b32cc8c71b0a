//! Many equal periods in closed form.
//!
//! While the phase is at rest a period is the same affine map for every coordinate, z -> d z + c, and n of
//! them are d^n z + c (1 - d^n) / (1 - d). Whether the phase stays at rest is bounded first: between first and
//! last period, and between two edges, each coordinate is monotone, and its gain is not negative.

use super::WireDrive;
use super::exact::Exact;
use super::lanes::dot;
use crate::display::finger::NODES;
use crate::time::Nanos;
use palpate_core::vector::Scalar;

/// Fewer periods than this are run one by one.
const WORTH: u64 = 4;

impl Exact {
    /// Repeats `pattern` (times within the period, rising, and the drive from each on) `count` times from
    /// the time computed up to, in closed form wherever no phase event can come. Exact but for the
    /// maxima: of periods that are jumped over only the last is looked at.
    pub fn repeat(&mut self, pattern: &[(Nanos, WireDrive)], period: Nanos, count: u64) {
        let mut left = count;
        // After a period that could not be jumped from, wait longer before trying again.
        let (mut wait, mut since) = (1, 0);
        while left > 0 {
            let start = self.now();
            for &(offset, drive) in pattern {
                self.drive(start + offset, drive);
            }
            self.advance(start + period);
            left -= 1;
            since += 1;
            if left <= WORTH || since < wait {
                continue;
            }
            since = 0;
            let mut jump = left - 1;
            while jump >= WORTH && !self.jump(pattern, period, jump) {
                jump /= 8;
            }
            if jump >= WORTH {
                (left, wait) = (left - jump, 1);
            } else {
                wait = (wait * 2).min(64);
            }
        }
    }

    /// Jumps over `count` periods if that can be proved to pass no event.
    fn jump(&mut self, pattern: &[(Nanos, WireDrive)], period: Nanos, count: u64) -> bool {
        let t = self.wire_c();
        let branch = self.phase.branch(t, self.heading);
        if branch.one_way || branch.slope < 0.0 || self.wire.resistance_per_kelvin != 0.0 {
            return false;
        }
        let (seconds, n) = (period.as_secs_f64(), count as f64);
        let zero = self.walk(pattern, period, &[0.0; NODES]);
        let mode = &self.modes[self.mode];
        let last: [f64; NODES] = core::array::from_fn(|k| {
            let x = mode.lambda[k] * seconds;
            let periods = libm::expm1(-x * n) / libm::expm1(-x);
            libm::exp(-x * n) * self.z[k] + zero.end[k] * periods
        });
        let first = self.walk(pattern, period, &self.z);
        let then = self.walk(pattern, period, &last);
        let (mut top, mut bottom) = ([0.0; NODES], [0.0; NODES]);
        for k in 0..NODES {
            top[k] = first.top[k].max(then.top[k]);
            bottom[k] = first.bottom[k].min(then.bottom[k]);
        }
        let base = self.network.body_c;
        let highest = base + dot(Scalar, &mode.gain, &top);
        let lowest = base + dot(Scalar, &mode.gain, &bottom);
        if highest > branch.high || lowest < branch.low {
            return false;
        }

        // From z' = -lambda z + g p: the integral of z follows from its ends and the heat put in.
        let rest = self.network.rest_inflow() * seconds;
        let mut integral = [0.0; NODES];
        for k in 0..NODES {
            let given = mode.gain[k] * (first.wire_j + rest) * n;
            integral[k] = (given + self.z[k] - last[k]) / mode.lambda[k];
        }
        let wire = dot(Scalar, &mode.gain, &integral);
        let outer = dot(Scalar, mode.last(), &integral);
        let network = &*self.network;
        let e = &mut self.energy;
        e.wire_j += first.wire_j * n;
        e.electrical_j += first.electrical_j * n;
        e.air_j += network.air * (wire + (network.body_c - network.air_c) * seconds * n);
        e.ends_j += network.ends * (wire + (network.body_c - network.ends_c) * seconds * n);
        e.body_j += network.chain[NODES - 1] * outer;
        self.z = last;
        self.watch();
        self.now = Nanos(self.now.0.saturating_add(period.0.saturating_mul(count)));
        self.face();
        true
    }

    /// One period from `z` with the phase at rest.
    fn walk(&self, pattern: &[(Nanos, WireDrive)], period: Nanos, z: &[f64; NODES]) -> Walk {
        let mode = &self.modes[self.mode];
        let t = self.wire_c();
        let mut walk = Walk {
            end: *z,
            top: *z,
            bottom: *z,
            wire_j: 0.0,
            electrical_j: 0.0,
        };
        let (mut now, mut drive) = (Nanos::ZERO, self.drive);
        for &(until, next) in pattern.iter().chain([&(period, WireDrive::Off)]) {
            let span = until.since(now).as_secs_f64();
            let (wire_w, electrical_w) = self.resting_watts(drive, t);
            let power = wire_w + self.network.rest_inflow();
            for k in 0..NODES {
                let x = mode.lambda[k] * span;
                let rise = -libm::expm1(-x) / mode.lambda[k];
                walk.end[k] = libm::exp(-x) * walk.end[k] + rise * mode.gain[k] * power;
                walk.top[k] = walk.top[k].max(walk.end[k]);
                walk.bottom[k] = walk.bottom[k].min(walk.end[k]);
            }
            walk.wire_j += wire_w * span;
            walk.electrical_j += electrical_w * span;
            (now, drive) = (now.max(until), next);
        }
        walk
    }

    /// Watts into the wire and between the terminals with the phase at rest.
    fn resting_watts(&self, drive: WireDrive, t: f64) -> (f64, f64) {
        let w = &*self.wire;
        match drive {
            WireDrive::Off => (0.0, 0.0),
            WireDrive::Power(watts) => (watts * w.wire_share, watts),
            WireDrive::Current(amps) => {
                let austenite = 1.0 - self.phase.fraction(t);
                let wire =
                    w.resistance_ohm * w.wire_share * (1.0 + (w.austenite_ratio - 1.0) * austenite);
                let series = w.resistance_ohm * (1.0 - w.wire_share);
                (amps * amps * wire, amps * amps * (wire + series))
            }
        }
    }
}

/// What one period does.
struct Walk {
    end: [f64; NODES],
    top: [f64; NODES],
    bottom: [f64; NODES],
    wire_j: f64,
    electrical_j: f64,
}
