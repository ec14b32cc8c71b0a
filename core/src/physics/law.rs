//! Phases that exclude one another: martensite, R phase and austenite of one wire, moved by temperature and stress.
//!
//! The martensite is [`SHARES`] equal shares m, each with an eighth of the alloy's bands, so that one after the other turns.
//! The R phase has one play rho. With theta = T - stress / slope, a slope for each phase:
//!
//! ```text
//! m_k = min(max(m_k, cooling(theta_M)), heating(theta_M))      rho = min(max(rho, cooling(theta_R)), heating(theta_R))
//! R_k = min(rho, 1 - m_k)      M = mean m_k      R = mean R_k      austenite = 1 - M - R
//! strain = (alpha_A + (alpha_M - alpha_A) M) (T - T0) + eps_M M + eps_R R      heat = c T - L_M M - L_R R
//! ```
//!
//! The product M (T - T0) is straightened: a share that turns loses what its martensite has expanded by in proportion, and
//! gains it so. That is exact at both ends of its band; between them it is off by at most a quarter of the band's width times
//! the share's part of (alpha_M - alpha_A): 2e-7 for an eighth, and as much for two hundredths without hysteresis.

use alloc::vec::Vec;

use super::{
    Alloy, Bow, Curve, History, ParameterError, Phases, TissueParameters, WireParameters, check,
    finite,
};

/// Number of shares that the martensite turns in.
pub const SHARES: usize = 8;
/// Number of all shares, with the one without hysteresis.
pub(super) const ALL: usize = SHARES + 1;

/// The bands of one play at no stress, degrees C and kelvins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Band {
    /// Heating: theta from which on the play is gone, and the width of its band.
    hot: f64,
    warm: f64,
    /// Cooling: theta at which the play begins to form, and the width of its band.
    cool: f64,
    cold: f64,
}

/// Distance at which two temperatures, or two fractions, are the same.
pub(super) const SAME: f64 = 2e-11;

impl Band {
    /// Theta at which heating begins to turn a play that stands at `p`.
    pub(super) fn up(&self, p: f64) -> f64 {
        self.hot - p * self.warm
    }

    /// Theta at which cooling begins to turn a play that stands at `p`.
    pub(super) fn down(&self, p: f64) -> f64 {
        self.cool - p * self.cold
    }

    /// Change of a play with a theta that rises or falls (`way` 1 or -1), 1/K: 0 at rest, else negative.
    pub(super) fn rate(&self, p: f64, theta: f64, way: f64) -> f64 {
        if way > 0.0 {
            let turns = p > 0.0 && theta >= self.up(p) - SAME;
            if turns { -1.0 / self.warm } else { 0.0 }
        } else {
            let turns = p < 1.0 && theta <= self.down(p) + SAME;
            if turns { -1.0 / self.cold } else { 0.0 }
        }
    }
}

/// A share of the martensite.
#[derive(Clone, Copy, Debug)]
pub(super) struct Share {
    pub(super) band: Band,
    /// Part of the wire.
    pub(super) weight: f64,
    /// False of the share without hysteresis, which has no R phase.
    pub(super) has_r: bool,
}

/// Constants of a wire that its phases follow from.
#[derive(Clone, Debug)]
pub struct Law {
    pub(super) shares: Vec<Share>,
    pub(super) r: Band,
    /// Rise of the bands with stress: martensite, R phase, Pa/K.
    pub(super) slope_m: f64,
    pub(super) slope_r: f64,
    /// Strains of the whole phases, 1.
    pub(super) strain_m: f64,
    pub(super) strain_r: f64,
    /// Expansion of austenite, and the martensite's minus the austenite's, 1/K.
    pub(super) expansion: f64,
    pub(super) expansion_m: f64,
    /// Temperature of no thermal strain, degrees C.
    pub(super) rest_c: f64,
    /// Latent heats of the whole phases, J.
    pub(super) latent_m: f64,
    pub(super) latent_r: f64,
    /// Bias stress, and the modulus of the bow, Pa.
    pub(super) bias_pa: f64,
    pub(super) modulus_pa: f64,
    /// Strain at which the sag was measured, 1.
    pub(super) rest_strain: f64,
    pub(super) curve: Curve,
    pub(super) history: History,
    /// Temperature at which the wire rests, degrees C.
    pub(super) start_c: f64,
}

impl Law {
    /// Makes the law of a wire on a finger; it rests, and its sag was measured, at `start_c` degrees C.
    ///
    /// # Errors
    /// A parameter that cannot be computed with.
    pub fn new(
        wire: &WireParameters,
        tissue: &TissueParameters,
        start_c: f64,
    ) -> Result<Self, ParameterError> {
        let bow = Bow::new(wire, tissue)?;
        Self::with_shares(wire, Curve::new(&bow, wire), start_c, SHARES)
    }

    /// Makes the law of a wire in a bow of any curve.
    ///
    /// # Errors
    /// A parameter that cannot be computed with.
    pub fn in_bow(
        wire: &WireParameters,
        curve: Curve,
        start_c: f64,
    ) -> Result<Self, ParameterError> {
        Self::with_shares(wire, curve, start_c, SHARES)
    }

    pub(super) fn with_shares(
        wire: &WireParameters,
        curve: Curve,
        start_c: f64,
        count: usize,
    ) -> Result<Self, ParameterError> {
        wire.check()?;
        finite("start_c", start_c)?;
        let free = wire.alloy.under(0.0);
        let shares = shares(&free, wire.reversible, count);
        let m = &wire.mechanics;
        // A wire without an R phase has a play that never begins.
        let mut law = Self {
            shares,
            r: Band {
                hot: f64::NEG_INFINITY,
                warm: 1.0,
                cool: f64::NEG_INFINITY,
                cold: 1.0,
            },
            slope_m: free.stress_per_kelvin,
            slope_r: free.stress_per_kelvin,
            strain_m: m.transformation_strain,
            strain_r: 0.0,
            expansion: m.expansion_austenite,
            expansion_m: m.expansion_martensite - m.expansion_austenite,
            rest_c: m.rest_c,
            latent_m: wire.mass() * wire.latent_heat,
            latent_r: 0.0,
            bias_pa: wire.bias_stress_pa,
            modulus_pa: m.modulus_martensite_pa,
            rest_strain: 0.0,
            curve,
            history: wire.history,
            start_c,
        };
        if let Some(play) = &wire.r_phase {
            let bands = play.bands.under(0.0);
            law.r = Band {
                hot: bands.austenite_finish_c,
                warm: bands.austenite_finish_c - bands.austenite_start_c,
                cool: bands.martensite_start_c,
                cold: bands.martensite_start_c - bands.martensite_finish_c,
            };
            law.slope_r = bands.stress_per_kelvin;
            law.strain_r = play.strain;
            law.latent_r = wire.mass() * play.latent_heat;
        }
        check("r_phase.strain", law.takes_heat(wire.heat_capacity()))?;
        law.rest_strain = Phases::of_sag(&law).strain();
        Ok(law)
    }

    /// True if heating takes up heat everywhere. A phase that shrinks may pull the other one back faster than the wire gets
    /// warmer; if that released more heat than the wire takes up, its temperature would jump.
    fn takes_heat(&self, plain_j_k: f64) -> bool {
        let of = |band: &Band, count: f64| 1.0 / (band.warm.min(band.cold) * count);
        let whole = self.shares.iter().filter(|share| share.has_r).count() as f64;
        let m = of(&self.shares[0].band, whole);
        let r = of(&self.r, 1.0);
        let m = (m, m * self.strain_m, self.latent_m, self.slope_m);
        let r = (r, r * self.strain_r, self.latent_r, self.slope_r);
        let pieces = self.curve.pieces.iter().filter(|piece| !piece.tight);
        pieces.map(|piece| piece.stiffness_pa).all(|kappa| {
            [(m, r), (r, m)].into_iter().all(|(shrinks, grows)| {
                let gives = 1.0 + kappa * (shrinks.1 / shrinks.3 + grows.1 / grows.3);
                let ahead = 1.0 / grows.3 - 1.0 / shrinks.3;
                let forward = (1.0 + kappa * grows.1 * ahead) / gives;
                let back = (kappa * shrinks.1 * ahead - 1.0) / gives;
                plain_j_k + shrinks.2 * shrinks.0 * forward > grows.2 * grows.0 * back.max(0.0)
            })
        })
    }

    /// Elastic strain under a stress, 1: by the martensite's modulus, as the bow has it.
    pub fn elastic(&self, stress_pa: f64) -> f64 {
        stress_pa / self.modulus_pa
    }

    /// Strain of phases and expansion at which the sag was measured, 1.
    pub const fn rest_strain(&self) -> f64 {
        self.rest_strain
    }
}

/// Makes `count` shares of the alloy's martensite, and the one without hysteresis if there is any.
fn shares(free: &Alloy, reversible: f64, count: usize) -> Vec<Share> {
    let n = count as f64;
    let warm = (free.austenite_finish_c - free.austenite_start_c) / n;
    let cold = (free.martensite_start_c - free.martensite_finish_c) / n;
    let mut shares = Vec::with_capacity(count + 1);
    for k in 1..=count {
        let place = k as f64;
        shares.push(Share {
            band: Band {
                hot: free.austenite_start_c + place * warm,
                warm,
                cool: free.martensite_finish_c + place * cold,
                cold,
            },
            weight: (1.0 - reversible) / n,
            has_r: true,
        });
    }
    if reversible > 0.0 {
        let both = free.reversible();
        let width = both.austenite_finish_c - both.austenite_start_c;
        shares.push(Share {
            band: Band {
                hot: both.austenite_finish_c,
                warm: width,
                cool: both.austenite_finish_c,
                cold: width,
            },
            weight: reversible,
            has_r: false,
        });
    }
    shares
}
