//! A cold wire as a hot pass heats it: the emulators' own model, and the corner that takes the most heat.

use palpate_core::physics::{ParameterError, TissueParameters, WireParameters, WireState};
use palpate_core::projector::HotPass;
use palpate_core::units::Prescale;
use palpate_emulators::display::wire::Wire;
use palpate_emulators::time::Nanos;
use palpate_files::Setup;

use crate::plan;

/// Share of martensite below which a pass has turned a wire, when its last pulse ends.
pub(super) const PASSED: f64 = 0.01;
/// Share of martensite that may come back at rest on the finger: a wire with more is a cold one again.
pub(super) const KEPT: f64 = 0.5;
/// How much colder than stated a finger may be, K.
const COLDER_K: f64 = 4.0;
/// The guard's corner of the least heat in a wire: share of the heat, specific heat J/(kg K), latent heat J/kg, contact
/// W/(m2 K), contact fraction. The guard's own predictor has the same range.
const LEAST: (f64, f64, f64, f64, f64) = (0.6, 837.0, 24e3, 1e4, 0.5);

/// Note of a run whose bow has no room for a passed wire.
const TIGHT: &str =
    "a passed wire would pull its bow tight at rest, so the wires stay cold; expected a deeper bow";
/// Note of a run whose wires turn back at rest.
const RETURNS: &str = "at rest the wires' stress would bring most of their martensite back, so they stay cold; expected less stress or a warmer finger";

/// Cold wires at rest and their drive. A wire that the model has no rest for is an error of every question about it.
pub(super) struct Heated {
    /// The wire as it is stated.
    nominal: Result<Wire, ParameterError>,
    /// Wire of the bench on a finger that is 4 K colder than stated.
    colder: Result<Wire, ParameterError>,
    /// The wire in the guard's corner of the least heat.
    worst: Result<Wire, ParameterError>,
    amps: f64,
    prescale: Prescale,
}

impl Heated {
    /// Wires of a setup, on boards of this PRE_SCALE.
    pub fn new(setup: &Setup, prescale: Prescale) -> Self {
        let bench = &setup.bench.value;
        let (mut wire, tissue) = (plan::wire(setup), bench.tissue.parameters());
        wire.history.state = WireState::Cold;
        let mut colder = (wire, tissue);
        colder.0.ends_c -= COLDER_K;
        colder.1.body_c -= COLDER_K;
        let (least, pressed) = least_heated((wire, tissue));
        let rest = |wire: &WireParameters, tissue: &TissueParameters| {
            Wire::new(wire, tissue, tissue.body_c)
        };
        Self {
            nominal: rest(&wire, &tissue),
            colder: rest(&colder.0, &colder.1),
            worst: rest(&least, &pressed),
            amps: bench.drive.current_ma * 1e-3,
            prescale,
        }
    }

    /// Martensite that a pass leaves in the wire as it is stated when the last pulse ends, on a finger as stated or 4 K colder.
    /// Some of it may come back at rest, whatever the pass was.
    ///
    /// # Errors
    /// A wire that the model has no rest for.
    pub fn left(&self, pass: &HotPass) -> Result<f64, ParameterError> {
        let colder = self.after(&self.colder, pass)?;
        Ok(self.after(&self.nominal, pass)?.max(colder))
    }

    /// Martensite that a pass leaves in the corner of the least heat, when the last pulse ends.
    ///
    /// # Errors
    /// A wire that the model has no rest for.
    pub fn left_at_worst(&self, pass: &HotPass) -> Result<f64, ParameterError> {
        self.after(&self.worst, pass)
    }

    /// Martensite at the end of the last pulse.
    fn after(
        &self,
        cold: &Result<Wire, ParameterError>,
        pass: &HotPass,
    ) -> Result<f64, ParameterError> {
        let mut heated = cold.clone()?;
        let width = u64::from(pass.width.get()) * self.prescale.tick_ns();
        let pulses = pulses(pass, self.prescale);
        let mut end = Nanos::ZERO;
        for burst in 0..u64::from(pass.bursts) {
            for pulse in 0..pulses {
                let again = pass.again.as_micros() * 1000;
                let at = burst * again + pulse * self.prescale.period_ns();
                end = Nanos(at + width);
                heated.set_current(Nanos(at), self.amps);
                heated.set_current(end, 0.0);
            }
        }
        Ok(heated.fraction(end))
    }
}

/// Pulses of each burst of a pass.
pub(super) fn pulses(pass: &HotPass, prescale: Prescale) -> u64 {
    (pass.burst.as_micros() * 1000).div_ceil(prescale.period_ns())
}

/// The wire as a pass leaves it on a finger: it can be at rest so, and stress brings less than half of the martensite back.
///
/// # Errors
/// The reason why a pass would not last, for a note.
pub fn lasting(
    wire: &WireParameters,
    tissue: &TissueParameters,
) -> Result<WireParameters, &'static str> {
    let mut passed = *wire;
    passed.history.state = WireState::Passed;
    let at_rest = Wire::new(&passed, tissue, tissue.body_c).map_err(|_| TIGHT);
    match at_rest?.fraction(Nanos::ZERO) < KEPT {
        true => Ok(passed),
        false => Err(RETURNS),
    }
}

/// A wire and a finger in the guard's corner of the least heat.
fn least_heated(
    (mut wire, mut tissue): (WireParameters, TissueParameters),
) -> (WireParameters, TissueParameters) {
    let (share, specific_heat, latent_heat, contact_h, contact_fraction) = LEAST;
    wire.wire_share = wire.wire_share.min(share);
    wire.specific_heat = wire.specific_heat.max(specific_heat);
    let part = latent_heat / wire.latent_heat.max(1.0);
    if part > 1.0 {
        wire.latent_heat = latent_heat;
        if let Some(r) = &mut wire.r_phase {
            r.latent_heat *= part;
        }
    }
    tissue.contact_h = contact_h;
    tissue.contact_fraction = contact_fraction;
    (wire, tissue)
}
