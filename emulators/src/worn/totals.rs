//! Totals of a run: peaks over all wires, energy and dose.

use palpate_core::units::Milliamps;

use crate::display::solver::record::Peaks;
use crate::display::wire::Wire;
use crate::time::Nanos;

/// Totals of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DisplayTotals {
    /// Electrical energy into all wires and their leads, J.
    pub electrical_j: f64,
    /// Largest supply current.
    pub peak_supply: Milliamps,
    /// Hottest wire: temperature in degrees C and index.
    pub hottest_wire: (f64, usize),
    /// Hottest tissue 0.1 mm deep under any wire, degrees C.
    pub hottest_tissue_c: f64,
    /// Hottest tissue 0.4 mm deep under any wire, degrees C.
    pub hottest_deep_c: f64,
    /// True if a bow has been past nine tenths of its sag.
    pub tight: bool,
    /// Largest burn integrals under any wire: Henriques' Omega and minutes at 43 C.
    pub dose: (f64, f64),
}

impl DisplayTotals {
    /// No tissue is searched that cannot have passed `floor`: what one of the wires is known to have reached, or none.
    pub(super) fn new(
        wires: &mut [Wire],
        floor: &Peaks,
        peak_supply: Milliamps,
        now: Nanos,
    ) -> Self {
        let mut totals = Self {
            peak_supply,
            hottest_wire: (f64::NEG_INFINITY, 0),
            hottest_tissue_c: f64::NEG_INFINITY,
            hottest_deep_c: f64::NEG_INFINITY,
            ..Self::default()
        };
        for (index, wire) in wires.iter_mut().enumerate() {
            let peaks = wire.peaks_above(now, floor);
            totals.electrical_j += wire.energy(now).electrical_j;
            if peaks.wire_c > totals.hottest_wire.0 {
                totals.hottest_wire = (peaks.wire_c, index);
            }
            totals.hottest_tissue_c = totals.hottest_tissue_c.max(peaks.shallow_c);
            totals.hottest_deep_c = totals.hottest_deep_c.max(peaks.deep_c);
            totals.tight |= wire.was_tight(now);
            let dose = wire.dose(now).unwrap_or_default();
            totals.dose.0 = totals.dose.0.max(dose.omega);
            totals.dose.1 = totals.dose.1.max(dose.cem43_min);
        }
        totals
    }
}
