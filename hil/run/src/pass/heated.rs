//! A cold wire as a hot pass heats it: the emulators' own model, and the corner that takes the most heat.

use palpate_core::physics::{ParameterError, TissueParameters, WireParameters, WireState};
use palpate_core::projector::HotPass;
use palpate_core::units::Prescale;
use palpate_emulators::display::wire::Wire;
use palpate_emulators::time::Nanos;
use palpate_files::Setup;

use crate::plan;

/// Share of martensite below which a wire counts as passed.
pub const PASSED: f64 = 0.01;
/// Time after the last pulse at which a pass must hold: what stress brings back, it has by then.
const AFTER: Nanos = Nanos::from_micros(1_000_000);
/// How much colder than stated a finger may be, K.
const COLDER_K: f64 = 4.0;
/// The guard's corner of the least heat in a wire: share of the heat, specific heat J/(kg K), latent heat J/kg, contact
/// W/(m2 K), contact fraction. The guard's own predictor has the same range.
const LEAST: (f64, f64, f64, f64, f64) = (0.6, 837.0, 24e3, 1e4, 0.5);

/// Cold wires and their drive.
pub(super) struct Heated {
    nominal: (WireParameters, TissueParameters),
    worst: (WireParameters, TissueParameters),
    amps: f64,
    prescale: Prescale,
}

impl Heated {
    /// Wires of a setup, on boards of this PRE_SCALE.
    pub fn of(setup: &Setup, prescale: Prescale) -> Self {
        let bench = &setup.bench.value;
        let nominal = (plan::wire(setup), bench.tissue.parameters());
        let (share, specific_heat, latent_heat, contact_h, contact_fraction) = LEAST;
        let (mut wire, mut tissue) = nominal;
        wire.wire_share = wire.wire_share.min(share);
        wire.specific_heat = wire.specific_heat.max(specific_heat);
        let part = latent_heat / wire.latent_heat.max(1.0);
        if part > 1.0 {
            wire.latent_heat = latent_heat;
            let beside = wire.beside.iter_mut().flatten();
            beside.for_each(|play| play.latent_heat *= part);
        }
        tissue.contact_h = contact_h;
        tissue.contact_fraction = contact_fraction;
        Self {
            nominal,
            worst: (wire, tissue),
            amps: bench.drive.current_ma * 1e-3,
            prescale,
        }
    }

    /// Martensite that a pass leaves in the wire as it is stated: on a finger as stated a second later, on one that is 4 K
    /// colder when the last pulse ends. There some of it comes back, whatever the pass was.
    ///
    /// # Errors
    /// A wire that the model has no rest for.
    pub fn left(&self, pass: &HotPass) -> Result<f64, ParameterError> {
        let (mut wire, mut tissue) = self.nominal;
        wire.ends_c -= COLDER_K;
        tissue.body_c -= COLDER_K;
        let [colder, _] = self.after(&(wire, tissue), pass)?;
        let [_, left] = self.after(&self.nominal, pass)?;
        Ok(left.max(colder))
    }

    /// Martensite that a pass leaves in the corner of the least heat, when the last pulse ends.
    ///
    /// # Errors
    /// A wire that the model has no rest for.
    pub fn left_at_worst(&self, pass: &HotPass) -> Result<f64, ParameterError> {
        self.after(&self.worst, pass).map(|[end, _]| end)
    }

    /// Tells whether the wire can be at rest once it is passed: its bow may not pull tight.
    pub fn rests_passed(&self) -> bool {
        let (mut wire, tissue) = self.nominal;
        if let Some(history) = &mut wire.history {
            history.state = WireState::Passed;
        }
        Wire::new(&wire, &tissue, tissue.body_c).is_ok()
    }

    /// Martensite at the end of the last pulse and a second later.
    fn after(
        &self,
        (wire, tissue): &(WireParameters, TissueParameters),
        pass: &HotPass,
    ) -> Result<[f64; 2], ParameterError> {
        let mut heated = Wire::new(wire, tissue, tissue.body_c)?;
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
        Ok([end, end + AFTER].map(|at| heated.fraction(at)))
    }
}

/// Pulses of each burst of a pass.
pub(super) fn pulses(pass: &HotPass, prescale: Prescale) -> u64 {
    (pass.burst.as_micros() * 1000).div_ceil(prescale.period_ns())
}
