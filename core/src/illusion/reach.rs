//! Laws over true distances: the metric itself, the Gaussian, the nearest wire and the three nearest.

use alloc::boxed::Box;

use crate::units::Point;

use super::cells::Cells;
use super::display::Display;
use super::geometry::foot;
use super::law::Illusion;
use super::surface::{Surface, distance2};

/// Distances from a contact to the wires: in the unrolled plane, or straight through space.
#[derive(Clone, Debug)]
pub(super) struct Metric {
    surface: Surface,
    wires: Box<[[f32; 3]]>,
}

impl Metric {
    /// Metric of a display's wires on `surface`.
    pub fn new(display: &Display, surface: Surface) -> Self {
        let wires = display.wires().iter().map(|w| surface.lift(w.place));
        Self {
            surface,
            wires: wires.collect(),
        }
    }

    pub fn lift(&self, at: Point) -> [f32; 3] {
        self.surface.lift(at)
    }

    /// Squared distance from a lifted place to a wire, mm2.
    pub fn distance2(&self, at: [f32; 3], wire: usize) -> f32 {
        distance2(at, self.wires[wire])
    }

    /// Each wire's distance to its nearest neighbour, mm; infinite for a single wire.
    pub fn gaps(&self) -> Box<[f32]> {
        let nearest = |i: usize| {
            let others = (0..self.wires.len()).filter(|&j| j != i);
            others
                .map(|j| self.distance2(self.wires[i], j))
                .fold(f32::INFINITY, f32::min)
        };
        (0..self.wires.len())
            .map(|i| libm::sqrtf(nearest(i)))
            .collect()
    }
}

/// A bell around every wire: `exp(-d^2 / 2 sigma^2)` with sigma a share of the wire's gap to its nearest
/// neighbour, lowered and stretched so that it is 1 on the wire and ends at 0 where it would be 1 %.
#[derive(Clone, Debug)]
pub(super) struct Gaussian {
    metric: Metric,
    /// Per wire: -1 / 2 sigma^2 and the square of its reach.
    bells: Box<[(f32, f32)]>,
}

/// Height of the bell where it is cut.
const TAIL: f32 = 0.01;

impl Gaussian {
    pub(super) fn new(metric: Metric, width: f32) -> Self {
        let bell = |&gap: &f32| {
            let sigma = width * gap;
            let rate = -0.5 / (sigma * sigma);
            (rate, libm::logf(TAIL) / rate)
        };
        let bells = metric.gaps().iter().map(bell).collect();
        Self { metric, bells }
    }
}

impl Illusion for Gaussian {
    fn activate(&self, at: Point, out: &mut [f32]) {
        let at = self.metric.lift(at);
        for (i, (a, &(rate, reach2))) in out.iter_mut().zip(&self.bells).enumerate() {
            let d2 = self.metric.distance2(at, i);
            let within = d2 < reach2;
            *a = if within {
                ((libm::expf(rate * d2) - TAIL) / (1.0 - TAIL)).max(0.0)
            } else {
                0.0
            };
        }
    }
}

/// Law that puts all of a contact on the nearest wire. Wires equally near share the energy: no order of wires decides.
#[derive(Clone, Debug)]
pub(super) struct Nearest {
    metric: Metric,
}

/// Distances that differ by less than this part are equal.
const TIE: f32 = 1e-5;

impl Nearest {
    pub(super) const fn new(metric: Metric) -> Self {
        Self { metric }
    }
}

impl Illusion for Nearest {
    fn activate(&self, at: Point, out: &mut [f32]) {
        let at = self.metric.lift(at);
        let mut least = f32::INFINITY;
        for (i, a) in out.iter_mut().enumerate() {
            *a = self.metric.distance2(at, i);
            least = least.min(*a);
        }
        let near = |d2: f32| d2 <= least * (1.0 + 2.0 * TIE) && d2 < f32::INFINITY;
        let ties = out.iter().filter(|d2| near(**d2)).count();
        let each = 1.0 / libm::sqrtf(ties as f32);
        for a in out.iter_mut() {
            *a = if near(*a) { each } else { 0.0 };
        }
    }
}

/// Park 2016: the three nearest wires of the cell around the contact, `A_i = ((1/d_i) / sum(1/d_j))^1/2`;
/// on an edge the two at its ends. As published, a third wire drops out at the edge from a share that is
/// not zero: the law jumps there.
#[derive(Clone, Debug)]
pub(super) struct ThreeNearest {
    metric: Metric,
    cells: Cells,
    places: Box<[Point]>,
}

/// A contact this close to an edge is on it, mm.
const ON_EDGE: f32 = 1e-3;

impl ThreeNearest {
    pub(super) fn new(display: &Display, metric: Metric, cells: Cells) -> Self {
        Self {
            metric,
            cells,
            places: display.wires().iter().map(|w| w.place).collect(),
        }
    }
}

impl Illusion for ThreeNearest {
    fn activate(&self, at: Point, out: &mut [f32]) {
        out.fill(0.0);
        if !(at.x.is_finite() && at.y.is_finite()) {
            return;
        }
        let (at, _) = self.cells.nearest(at);
        let lifted = self.metric.lift(at);
        // Distance and wire of the three nearest so far; ties stay in the order of the places.
        let mut near = [(f32::INFINITY, usize::MAX); 3];
        let (mut first, mut last, mut edge) = (None, None, None);
        let on = |a: usize, b: usize| {
            at.distance2(foot(self.places[a], self.places[b], at)) < ON_EDGE * ON_EDGE
        };
        self.cells.corners(at, &mut |wire| {
            let mut mine = (self.metric.distance2(lifted, wire), wire);
            for slot in &mut near {
                if mine.0 < slot.0 {
                    core::mem::swap(slot, &mut mine);
                }
            }
            first.get_or_insert(wire);
            if let Some(before) = last
                && on(before, wire)
            {
                edge = Some((before, wire));
            }
            last = Some(wire);
        });
        if let (Some(a), Some(b)) = (last, first)
            && a != b
            && on(a, b)
        {
            edge = Some((a, b));
        }
        if let Some((a, b)) = edge {
            let end = |w: usize| (self.metric.distance2(lifted, w), w);
            near = [end(a), end(b), (f32::INFINITY, usize::MAX)];
        }
        if let Some(&(_, wire)) = near.iter().find(|n| n.0 < ON_EDGE * ON_EDGE) {
            out[wire] = 1.0;
            return;
        }
        let nearness = near.map(|(d2, _)| 1.0 / libm::sqrtf(d2));
        let sum: f32 = nearness.iter().sum();
        for (part, (_, wire)) in nearness.into_iter().zip(near) {
            if let Some(a) = out.get_mut(wire) {
                *a = libm::sqrtf(part / sum);
            }
        }
    }
}

#[cfg(test)]
#[path = "reach_tests.rs"]
mod tests;
