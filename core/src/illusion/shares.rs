//! Laws over shares: each wire's share of a contact's place, raised to a power.
//!
//! With the exponent 1/2 the energy centroid of the wires is the contact (Israr and Poupyrev's energy law,
//! in two dimensions), with 1 their amplitude centroid is (the linear law). Between the two lies the
//! balanced law: no exponent satisfies both centroids, so it is wrong by about as little for either.

use crate::units::Point;

use super::cells::Cells;
use super::law::Illusion;

/// Power of a law, and whether it levels the energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Power {
    /// Exponent of the share.
    pub exponent: f32,
    /// `true` where activations are scaled so that their squares sum to 1.
    pub level: bool,
}

impl Power {
    fn raise(self, share: f32) -> f32 {
        // The named laws need no power function.
        match self.exponent {
            e if (e - 0.5).abs() < f32::EPSILON => libm::sqrtf(share),
            e if (e - 1.0).abs() < f32::EPSILON => share,
            e if (e - 2.0).abs() < f32::EPSILON => share * share,
            _ if share >= 1.0 => 1.0,
            e => libm::expf(e * libm::logf(share)),
        }
    }

    /// Shares in place to activations.
    fn apply(self, shares: &mut [f32]) {
        let mut energy = 0.0;
        for a in shares.iter_mut().filter(|s| **s > 0.0) {
            *a = self.raise(*a);
            energy += *a * *a;
        }
        if self.level && energy > 0.0 {
            let scale = 1.0 / libm::sqrtf(energy);
            for a in shares.iter_mut().filter(|s| **s > 0.0) {
                *a = (*a * scale).min(1.0);
            }
        }
    }
}

/// Shares by the cells between wires: any array.
#[derive(Clone, Debug)]
pub(super) struct CellShares {
    cells: Cells,
    power: Power,
    /// Distance beyond the hull from which on a contact is not rendered, mm. Nearer to the hull it is rendered on the
    /// edge, weaker with distance.
    margin: f32,
}

impl CellShares {
    pub(super) const fn new(cells: Cells, power: Power, margin: f32) -> Self {
        Self {
            cells,
            power,
            margin,
        }
    }
}

impl Illusion for CellShares {
    fn activate(&self, at: Point, out: &mut [f32]) {
        let (near, beyond) = self.cells.nearest(at);
        // What is no number compares false.
        let within = beyond < self.margin;
        if !within {
            out.fill(0.0);
            return;
        }
        self.cells.shares(near, out);
        self.power.apply(out);
        if beyond > 0.0 {
            let part = 1.0 - beyond / self.margin;
            for a in out.iter_mut() {
                *a *= part;
            }
        }
    }
}

/// Shares axis by axis, `max(1 - |dx| / D_x, 0)` times the same in y: regular grids. Where a grid has a
/// hole, what that wire should have given is missing.
#[derive(Clone, Debug)]
pub(super) struct AxisShares {
    spacing: (f32, f32),
    wires: alloc::boxed::Box<[Point]>,
    power: Power,
}

impl AxisShares {
    pub(super) fn new(display: &super::Display, power: Power) -> Self {
        Self {
            spacing: display.spacing(),
            wires: display.wires().iter().map(|w| w.place).collect(),
            power,
        }
    }
}

impl Illusion for AxisShares {
    fn activate(&self, at: Point, out: &mut [f32]) {
        let axis = |d: f32, spacing: f32| {
            let d = libm::fabsf(d);
            let within = d < spacing;
            if within { 1.0 - d / spacing } else { 0.0 }
        };
        for (a, wire) in out.iter_mut().zip(&self.wires) {
            *a = axis(at.x - wire.x, self.spacing.0) * axis(at.y - wire.y, self.spacing.1);
        }
        self.power.apply(out);
    }
}

#[cfg(test)]
#[path = "shares_tests.rs"]
mod tests;
