//! Checks of a wire's history, and of its rest in its bow.

use palpate_core::physics::{
    Hysteresis, Law, ParameterError, Phases, TIGHTEST, TissueParameters, WireParameters,
};

use super::{WireFile, WireState};
use crate::error::FileError;
use crate::source::Source;

/// Skin temperature at which a wire rests, degrees C.
const REST_C: f64 = 33.0;

impl WireFile {
    /// Checks that the keys of a history go with each other and with the rest of the file.
    pub(super) fn check_history(&self, source: &Source) -> Result<(), FileError> {
        if self.sag_state.is_none() {
            let alone = match (self.state, self.coldest_c) {
                (Some(_), _) => "state",
                (None, Some(_)) => "coldest_c",
                (None, None) => return Ok(()),
            };
            let expected = "no such key without `sag_state`, the state in which the bench's sag was measured: \"cold\" or \"passed\"";
            return Err(source.bad(alone, expected.to_owned()));
        }
        if let Some(coldest_c) = self.coldest_c {
            source.range("coldest_c", &coldest_c, -200.0..=REST_C, "C")?;
            if self.state != Some(WireState::Passed) {
                let expected = "it beside state = \"passed\" alone: a cold wire has been colder";
                return Err(source.bad("coldest_c", expected.to_owned()));
            }
        }
        if self.hysteresis != Hysteresis::Play {
            let expected = "the law `play` beside `sag_state`: its shares turn one after the other";
            return Err(source.bad("hysteresis.law", expected.to_owned()));
        }
        if self.plays.len() > 1 {
            let expected = "one play beside `sag_state`, the R phase";
            let found = self.plays.len().to_string();
            return Err(source.bad_found("plays", expected.to_owned(), found));
        }
        let Some(r) = self.plays.first() else {
            return Ok(());
        };
        let most = self.mechanical.transformation_strain;
        if !(0.0..=most).contains(&r.strain) {
            let expected = format!(
                "a strain from 0 to {most}, that of the martensite which it turns to: beside `sag_state` phases exclude one another"
            );
            return Err(source.bad("plays[0].strain", expected));
        }
        if r.latent_heat_j_kg > self.thermal.latent_heat_j_kg {
            let expected = format!(
                "at most the martensite's latent heat, {} J/kg",
                self.thermal.latent_heat_j_kg
            );
            return Err(source.bad("plays[0].latent_heat_j_kg", expected));
        }
        Ok(())
    }
}

/// Checks that a wire with a history can be at rest in its bow; `source` is the wire's file, `mount` the bench's.
///
/// # Errors
/// Names the line and key of what contradicts the rest.
pub fn check_rest(
    source: &Source,
    mount: &Source,
    wire: &WireParameters,
    tissue: &TissueParameters,
) -> Result<(), FileError> {
    if wire.history.is_none() {
        return Ok(());
    }
    let rest = Law::new(wire, tissue, REST_C).and_then(|law| Phases::rest(&law));
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
        "beside.strain" => source.bad(
            "plays[0].strain",
            "less, or a larger stress_mpa_k: stress would turn phases faster than heat does, and the temperature would jump".to_owned(),
        ),
        other => source.bad("sag_state", format!("a wire that can be computed: {other} is out of range")),
    })
}
