//! From length to skin: the bow's gain beside a finite-difference beam, where `ci/peers/run physics` names a Python.

use palpate_core::physics::{Bow, Ends, Mount, TissueParameters, WireParameters};
use palpate_run::Failure;
use serde::Serialize;

use crate::findings::Findings;
use crate::python::ask;

/// The script that solves the beam.
const SCRIPT: &str = include_str!("../../../../ci/peers/bow.py");
/// Farthest that the gain may be from the beam's, as a part of it.
const AGREES: f64 = 0.03;
/// Sags, um: the plausible range.
const SAGS_UM: [f64; 7] = [20.0, 43.0, 75.0, 100.0, 170.0, 200.0, 400.0];

#[derive(Serialize)]
struct Beam {
    diameter_m: f64,
    length_m: f64,
    modulus_pa: f64,
    sag_m: f64,
    ends: &'static str,
    tissue_pa: f64,
    contact_m: f64,
}

/// A wire as the script takes it, and its gain as we compute it.
fn beam(
    base: WireParameters,
    ends: (Ends, &'static str),
    sag_um: f64,
) -> Result<(Beam, f64), Failure> {
    let tissue = TissueParameters::DEFAULT;
    let mount = Mount {
        sag_m: sag_um * 1e-6,
        ends: ends.0,
        ..Mount::DEFAULT
    };
    let wire = WireParameters { mount, ..base };
    let bow = Bow::new(&wire, &tissue).map_err(|e| Failure::Input(e.to_string()))?;
    let beam = Beam {
        diameter_m: wire.diameter_m,
        length_m: wire.length_m,
        modulus_pa: wire.mechanics.modulus_martensite_pa,
        sag_m: mount.sag_m,
        ends: ends.1,
        tissue_pa: tissue.modulus_pa,
        contact_m: tissue.contact_width_m,
    };
    Ok((beam, bow.gain))
}

/// Both wires over the plausible range of sags, by every kind of end.
///
/// # Errors
/// A peer that fails, or a gain that is too far from the beam's.
pub fn measure(findings: &mut Findings) -> Result<(), Failure> {
    let kinds = [
        (Ends::Clamped, "clamped"),
        (Ends::Pinned, "pinned"),
        (Ends::Buckled, "buckled"),
    ];
    let (mut beams, mut gains) = (Vec::new(), Vec::new());
    for base in [WireParameters::FINAL, WireParameters::FIRST] {
        for ends in kinds {
            for sag_um in SAGS_UM {
                let (beam, gain) = beam(base, ends, sag_um)?;
                beams.push(beam);
                gains.push(gain);
            }
        }
    }
    let Some(found) = ask::<Vec<f64>>(SCRIPT, &beams)? else {
        return Ok(());
    };
    if found.len() != gains.len() {
        return Err(Failure::Check("bow: the beams are not all there".into()));
    }
    for (_, name) in kinds {
        let offs = gains.iter().zip(&found).zip(&beams);
        let of_kind = offs.filter(|(_, beam)| beam.ends == name);
        let off = of_kind.map(|((gain, truth), _)| (gain / truth - 1.0).abs());
        // A NaN must not vanish in a maximum.
        let off = off.fold(0.0, |worst: f64, off| {
            if off > worst || off.is_nan() {
                off
            } else {
                worst
            }
        });
        let case = format!("bow, both wires, {name}");
        findings.row(
            &case,
            "default",
            (off, "of a finite-difference beam's gain"),
            f64::NAN,
        );
        if off.is_nan() || off > AGREES {
            let what = format!(
                "{case}: {off:.4} off a finite-difference beam's gain, expected at most {AGREES}"
            );
            return Err(Failure::Check(what));
        }
    }
    Ok(())
}
