//! The phases of a wire without a history: plays in parallel, whose hysteresis is piecewise linear in temperature.
//!
//! Between two thresholds every share changes evenly with temperature, so the heat balance stays linear and the solver
//! exact. The memory changes only at events (a turn of the temperature, a threshold passed), which makes it
//! independent of how time is cut.
//!
//! The strain changes evenly too, so the skin's motion is linear in the wire's temperature as well. The expansion of
//! a play that transforms would bend it: its last part turns at a higher temperature than its first, and changes its
//! length by another difference of expansions. Here every part of a play changes its length alike. Over a band that
//! is at most a quarter of (alpha_M - alpha_A) times its width, 1.1e-5, from the bent line, and exact at its ends.

use palpate_core::physics::{ParameterError, WireParameters};

use super::branch::{Branch, Heading};
use super::strain::Strain;

/// Distance of temperatures that count as one threshold, K.
const SAME: f64 = 2e-11;

/// One play with its memory.
#[derive(Clone, Copy, Debug)]
struct Share {
    austenite: (f64, f64),
    martensite: (f64, f64),
    /// Share of the martensite fraction.
    weight: f64,
    /// Latent heat, J.
    latent: f64,
    /// Differences of cold against hot: of the strains by stress and by phase, and of the expansions (1/K).
    elastic: f64,
    strain: f64,
    expansion: f64,
    memory: f64,
}

impl Share {
    /// Upper bound of p: all martensite until heated past austenite start.
    fn heating(&self, t: f64) -> f64 {
        ((self.austenite.1 - t) / (self.austenite.1 - self.austenite.0)).clamp(0.0, 1.0)
    }

    /// Lower bound of p: no martensite until cooled past martensite start.
    fn cooling(&self, t: f64) -> f64 {
        ((self.martensite.0 - t) / (self.martensite.0 - self.martensite.1)).clamp(0.0, 1.0)
    }

    fn fraction(&self, t: f64) -> f64 {
        self.memory.max(self.cooling(t)).min(self.heating(t))
    }

    /// Temperature at which heating from this memory begins to transform, degrees C.
    fn upper(&self) -> f64 {
        let (start, finish) = self.austenite;
        if self.memory > 0.0 {
            finish - self.memory * (finish - start)
        } else {
            f64::INFINITY
        }
    }

    /// Temperature at which cooling from this memory begins to transform, degrees C.
    fn lower(&self) -> f64 {
        let (start, finish) = self.martensite;
        if self.memory < 1.0 {
            start - self.memory * (start - finish)
        } else {
            f64::NEG_INFINITY
        }
    }
    /// Width of the band, K, that a part of the play would pass next; between both bands, by the way to each.
    fn width(&self, t: f64, p: f64) -> (f64, f64) {
        let warm = self.austenite.1 - self.austenite.0;
        let cold = self.martensite.0 - self.martensite.1;
        let (up, down) = (self.austenite.1 - p * warm, self.martensite.0 - p * cold);
        let gap = up - down;
        if warm.to_bits() == cold.to_bits() || gap <= SAME {
            return (warm, 0.0);
        }
        let slope = (warm - cold) / gap;
        (cold + (t - down).clamp(0.0, gap) * slope, slope)
    }

    /// Strain by expansion beyond the austenite's at `t`, `away` from the temperature of none, in p (T - T0).
    fn expansion(&self, t: f64, away: f64) -> f64 {
        let p = self.fraction(t);
        self.expansion * (p * away + p * (p - 1.0) * self.width(t, p).0)
    }

    /// Adds the changes of this play to a branch.
    fn join(&self, branch: &mut Branch, t: f64, heading: Heading, rest_c: f64) {
        let (upper, lower) = (self.upper(), self.lower());
        let mut band = None;
        if heading == Heading::Up && t >= upper - SAME {
            if t < self.austenite.1 - SAME {
                band = Some((self.austenite.1, self.austenite.1 - self.austenite.0));
                branch.high = branch.high.min(self.austenite.1);
            }
        } else {
            branch.high = branch.high.min(upper);
        }
        if heading == Heading::Down && t <= lower + SAME {
            if t > self.martensite.1 + SAME {
                band = Some((self.martensite.0, self.martensite.0 - self.martensite.1));
                branch.low = branch.low.max(self.martensite.1);
            }
        } else {
            branch.low = branch.low.max(lower);
        }
        if let Some((hot, width)) = band {
            let per_kelvin = 1.0 / width;
            branch.slope -= self.weight / width;
            branch.latent += self.latent * per_kelvin;
            branch.strain -= (self.elastic + self.strain) * per_kelvin;
            branch.strain += self.expansion * (1.0 - (hot - rest_c) * per_kelvin);
            branch.one_way = true;
        } else {
            let p = self.fraction(t);
            branch.strain += self.expansion * (p + p * (p - 1.0) * self.width(t, p).1);
        }
    }
}

/// The plays of one wire.
#[derive(Clone, Debug)]
pub struct Plays {
    plays: Vec<Share>,
    /// Mechanics as austenite: strain by stress in `elastic`, and expansion, 1/K.
    elastic: f64,
    expansion: f64,
    /// Temperature of no thermal strain, degrees C.
    rest_c: f64,
}

impl Plays {
    /// The plays after cooling from far below, then heating to `start_c`: martensite unless hot.
    ///
    /// # Errors
    /// Branches of the hysteresis that touch or cross.
    pub fn new(wire: &WireParameters, start_c: f64) -> Result<Self, ParameterError> {
        let m = &wire.mechanics;
        let compliance = 1.0 / m.modulus_martensite_pa - 1.0 / m.modulus_austenite_pa;
        let shares = wire.plays()?.into_iter().map(|play| Share {
            austenite: (play.bands.austenite_start_c, play.bands.austenite_finish_c),
            martensite: (
                play.bands.martensite_start_c,
                play.bands.martensite_finish_c,
            ),
            weight: play.martensite,
            latent: wire.mass() * play.latent_heat,
            elastic: wire.bias_stress_pa * compliance * play.martensite,
            strain: play.strain,
            expansion: (m.expansion_martensite - m.expansion_austenite) * play.martensite,
            memory: 1.0,
        });
        let mut plays = Self {
            plays: shares.collect(),
            elastic: wire.bias_stress_pa / m.modulus_austenite_pa,
            expansion: m.expansion_austenite,
            rest_c: m.rest_c,
        };
        plays.commit(start_c);
        Ok(plays)
    }

    /// Martensite fraction at `t` degrees C, reached without a turn since the last event; in [0, 1].
    pub fn fraction(&self, t: f64) -> f64 {
        let mut xi = 0.0;
        for p in &self.plays {
            xi += p.weight * p.fraction(t);
        }
        xi.clamp(0.0, 1.0)
    }

    /// Latent heat that the wire holds at `t`, reached without a turn since the last event, J: none where all of it
    /// is cold.
    pub fn latent_j(&self, t: f64) -> f64 {
        self.plays
            .iter()
            .map(|p| p.latent * (1.0 - p.fraction(t)))
            .sum()
    }

    /// Strain at `t`, reached without a turn since the last event.
    pub fn strain(&self, t: f64) -> Strain {
        let away = t - self.rest_c;
        let mut strain = Strain {
            elastic: self.elastic,
            phase: 0.0,
            thermal: self.expansion * away,
        };
        for p in &self.plays {
            strain.elastic += p.elastic * p.fraction(t);
            strain.phase += p.strain * p.fraction(t);
            strain.thermal += p.expansion(t, away);
        }
        strain
    }

    /// The straight piece that leads on from `t`.
    pub fn branch(&self, t: f64, heading: Heading) -> Branch {
        let mut branch = Branch {
            slope: 0.0,
            latent: 0.0,
            strain: self.expansion,
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
            one_way: false,
        };
        for p in &self.plays {
            p.join(&mut branch, t, heading, self.rest_c);
        }
        branch
    }

    /// Takes a turn of the temperature or a threshold passed at `t`: the memory keeps what has transformed.
    pub fn commit(&mut self, t: f64) {
        for p in &mut self.plays {
            p.memory = p.fraction(t);
        }
    }
}
