//! Checks of a wire's history, and of its rest in its bow.

use palpate_core::guard::WornWire;
use palpate_core::physics::{
    Law, ParameterError, Phases, TIGHTEST, TissueParameters, WireParameters,
};

use super::{WireFile, WireState};
use crate::error::FileError;
use crate::source::Source;

/// Checks that a file is one of this version: it says in which state the bench's sag was measured, and its R phase has a
/// table of its own.
///
/// # Errors
/// Names the key, and the command that writes what this version reads.
pub(super) fn check_version(source: &Source) -> Result<(), FileError> {
    if source.states("plays") {
        let expected = "the R phase as [r_phase]: `hil check --migrate` writes it so";
        return Err(source.bad("plays", expected));
    }
    if source.states("hysteresis") {
        let expected = "no law, phases follow one: `hil check --migrate` leaves it out";
        return Err(source.bad("hysteresis", expected));
    }
    if !source.states("sag_state") {
        let expected = "the state in which the bench's sag was measured: \"cold\" or \"passed\"; `hil check --migrate --sag-state cold` writes it";
        return Err(source.bad_found("sag_state", expected, "nothing".to_owned()));
    }
    Ok(())
}

impl WireFile {
    /// Checks that the keys of a history go with each other.
    pub(super) fn check_history(&self, source: &Source) -> Result<(), FileError> {
        let Some(coldest_c) = self.coldest_c else {
            return Ok(());
        };
        // A wire has been as cold as the finger that it rests on.
        let warmest_c = f64::from(*WornWire::REST_MC.end()) / 1e3;
        source.range("coldest_c", &coldest_c, -200.0..=warmest_c, "C")?;
        if self.state != WireState::Passed {
            let expected = "it beside state = \"passed\" alone: a cold wire has been colder";
            return Err(source.bad("coldest_c", expected.to_owned()));
        }
        Ok(())
    }
}

/// Checks that a wire can be at rest in its bow, as warm as the finger; `source` is the wire's file, `mount` the bench's.
///
/// # Errors
/// Names the line and key of what contradicts the rest.
pub fn check_rest(
    source: &Source,
    mount: &Source,
    wire: &WireParameters,
    tissue: &TissueParameters,
) -> Result<(), FileError> {
    let rest = Law::new(wire, tissue, tissue.body_c).and_then(|law| Phases::rest(&law));
    let Err(ParameterError { name }) = rest else {
        return Ok(());
    };
    let sag_um = (wire.mount.sag_m * 1e9).round() / 1e3;
    Err(match name {
        "mount.sag_m" => mount.bad(
            "mount.sag_um",
            format!(
                "a deeper bow, or another `sag_state` or `state` in {}: from {sag_um} um the wire pulls itself past {:.0} % straight before its first pulse",
                source.label(),
                TIGHTEST * 100.0
            ),
        ),
        "bias_stress_pa" => source.bad(
            "mechanical.bias_stress_mpa",
            format!(
                "more, or another `sag_state` or `state`: in a bow of {sag_um} um the wire would be pressed at rest, and no state holds that"
            ),
        ),
        "r_phase.strain" => source.bad(
            "r_phase.strain",
            "less, or a larger stress_mpa_k: stress would turn phases faster than heat does, and the temperature would jump".to_owned(),
        ),
        other => source.bad("sag_state", format!("a wire that can be computed: {other} is out of range")),
    })
}
