//! Wires that the guard can guard: its rows of heat are made for a range of sizes and materials, and for no other.

use std::ops::RangeInclusive;

use palpate_core::guard::WornWire;
use palpate_core::physics::AIR_POWER;

use super::WireFile;
use crate::error::FileError;
use crate::source::Source;

/// End of each sentence.
const WHY: &str = "the guard has rows of heat for no other";
/// Heat capacities of the rows' corners, J/(m3 K): 322 to 837 J/(kg K) at 6450 kg/m3.
const CAPACITY: [f64; 2] = [322.0 * 6450.0, 837.0 * 6450.0];
/// Most latent heat in those corners, J/kg.
const LATENT_J_KG: f64 = 24_000.0;
/// Least conductivity: the rows' own, W/(m K). A wire that conducts better loses more at its ends.
const CONDUCTIVITY_W_MK: f64 = 18.0;
/// Heat transfer to still air of a wire of 75 um, W/(m2 K), rounded to a whole number. Air takes heat away.
const AIR_W_M2K: f64 = 172.0;

/// Checks that the guard has rows of heat for a wire of such a size.
///
/// # Errors
/// Names the line and key of a figure outside them, and their range.
pub(super) fn size(wire: &WireFile, source: &Source) -> Result<(), FileError> {
    let range = |range: RangeInclusive<u32>| {
        let (low, high) = range.into_inner();
        f64::from(low) / 1e3..=f64::from(high) / 1e3
    };
    let within = |key: &str, value: f64, of: RangeInclusive<u32>, unit: &str| {
        source.range(key, &value, range(of), &format!("{unit}: {WHY}"))
    };
    within("diameter_um", wire.diameter_um, WornWire::DIAMETER_NM, "um")?;
    within("length_mm", wire.length_mm, WornWire::LENGTH_UM, "mm")
}

/// Checks that the guard has rows of heat for a wire of such a material, in such air.
///
/// # Errors
/// Names the line and key of a figure outside them, and their range.
pub(super) fn heat(wire: &WireFile, source: &Source) -> Result<(), FileError> {
    let heat = &wire.thermal;
    let [least, most] = CAPACITY.map(|each| each / heat.density_kg_m3);
    let air = AIR_W_M2K * (wire.diameter_um / 75.0).powf(AIR_POWER);
    let within = |key: &str, value: f64, range: RangeInclusive<f64>, unit: &str| {
        let key = format!("thermal.{key}");
        source.range(&key, &value, range, &format!("{unit}: {WHY}"))
    };
    within(
        "specific_heat_j_kgk",
        heat.specific_heat_j_kgk,
        least..=most,
        "J/kgK",
    )?;
    within(
        "conductivity_w_mk",
        heat.conductivity_w_mk,
        CONDUCTIVITY_W_MK..=500.0,
        "W/mK",
    )?;
    within("air_w_m2k", heat.air_w_m2k, air.floor()..=2000.0, "W/m2K")?;
    within(
        "latent_heat_j_kg",
        heat.latent_heat_j_kg,
        0.0..=LATENT_J_KG,
        "J/kg",
    )
}

#[cfg(test)]
#[path = "guarded_tests.rs"]
mod tests;
