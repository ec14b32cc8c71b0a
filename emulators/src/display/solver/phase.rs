//! The martensite fraction xi: plays, whose hysteresis is piecewise linear in temperature.
//!
//! Between two thresholds d xi/dT is constant, so the heat balance stays linear and the solver exact. The
//! memory changes only at events (a turn of the temperature, a threshold passed), which makes it
//! independent of how time is cut.

use palpate_core::physics::{Hysteresis, ParameterError, WireParameters};

/// Which way the wire's temperature is going.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heading {
    /// Heating.
    Up,
    /// Cooling.
    Down,
}

/// A range of temperature in which the law is one straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// d xi/dT, 1/K; never positive.
    pub slope: f64,
    /// Holds down to here, degrees C.
    pub low: f64,
    /// Holds up to here, degrees C.
    pub high: f64,
    /// Whether it ends when the temperature turns.
    pub one_way: bool,
}

/// Temperatures this close count as the same threshold, K.
const SAME: f64 = 2e-11;

/// One generalised play.
#[derive(Clone, Copy, Debug)]
struct Play {
    austenite: (f64, f64),
    martensite: (f64, f64),
    weight: f64,
    memory: f64,
}

impl Play {
    /// Upper bound of xi: all martensite until heated past austenite start.
    fn heating(&self, t: f64) -> f64 {
        ((self.austenite.1 - t) / (self.austenite.1 - self.austenite.0)).clamp(0.0, 1.0)
    }

    /// Lower bound of xi: no martensite until cooled past martensite start.
    fn cooling(&self, t: f64) -> f64 {
        ((self.martensite.0 - t) / (self.martensite.0 - self.martensite.1)).clamp(0.0, 1.0)
    }

    fn fraction(&self, t: f64) -> f64 {
        self.memory.max(self.cooling(t)).min(self.heating(t))
    }

    /// Where heating from this memory begins to transform.
    fn upper(&self) -> f64 {
        let (start, finish) = self.austenite;
        if self.memory > 0.0 {
            finish - self.memory * (finish - start)
        } else {
            f64::INFINITY
        }
    }

    /// Where cooling from this memory begins to transform.
    fn lower(&self) -> f64 {
        let (start, finish) = self.martensite;
        if self.memory < 1.0 {
            start - self.memory * (start - finish)
        } else {
            f64::NEG_INFINITY
        }
    }
}

/// The phase of one wire.
#[derive(Clone, Debug)]
pub struct Phase {
    plays: Vec<Play>,
}

impl Phase {
    /// As after cooling from far below, then heating to `start_c`: martensite unless hot.
    ///
    /// # Errors
    /// Branches of the hysteresis that touch or cross.
    pub fn new(wire: &WireParameters, start_c: f64) -> Result<Self, ParameterError> {
        let a = &wire.alloy;
        let shift = (wire.bias_stress_pa - a.reference_stress_pa) / a.stress_per_kelvin;
        let one = Play {
            austenite: (a.austenite_start_c + shift, a.austenite_finish_c + shift),
            martensite: (a.martensite_start_c + shift, a.martensite_finish_c + shift),
            weight: 1.0,
            memory: 1.0,
        };
        let plays = match wire.hysteresis {
            Hysteresis::Play => vec![one],
            Hysteresis::Plays { count, narrowest } => spread(&one, count, narrowest)?,
        };
        let mut phase = Self { plays };
        phase.commit(start_c);
        Ok(phase)
    }

    /// Martensite fraction at `t` degrees C, reached without a turn since the last event; in [0, 1].
    pub fn fraction(&self, t: f64) -> f64 {
        let mut xi = 0.0;
        for p in &self.plays {
            xi += p.weight * p.fraction(t);
        }
        xi.clamp(0.0, 1.0)
    }

    /// The straight piece that leads on from `t`.
    pub fn branch(&self, t: f64, heading: Heading) -> Branch {
        let mut s = Branch {
            slope: 0.0,
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
            one_way: false,
        };
        for p in &self.plays {
            let (upper, lower) = (p.upper(), p.lower());
            if heading == Heading::Up && t >= upper - SAME {
                if t < p.austenite.1 - SAME {
                    s.slope -= p.weight / (p.austenite.1 - p.austenite.0);
                    s.high = s.high.min(p.austenite.1);
                }
            } else {
                s.high = s.high.min(upper);
            }
            if heading == Heading::Down && t <= lower + SAME {
                if t > p.martensite.1 + SAME {
                    s.slope -= p.weight / (p.martensite.0 - p.martensite.1);
                    s.low = s.low.max(p.martensite.1);
                }
            } else {
                s.low = s.low.max(lower);
            }
        }
        s.one_way = s.slope < 0.0;
        s
    }

    /// The temperature turned or passed a threshold at `t`: what has transformed is remembered.
    pub fn commit(&mut self, t: f64) {
        for p in &mut self.plays {
            p.memory = p.fraction(t);
        }
    }
}

/// Equal plays with hystereses evenly between `narrowest` and 1 of the alloy's own, about the same middle.
fn spread(one: &Play, count: u8, narrowest: f64) -> Result<Vec<Play>, ParameterError> {
    let n = f64::from(count);
    let up = (one.austenite.0 + one.austenite.1) / 2.0;
    let down = (one.martensite.0 + one.martensite.1) / 2.0;
    let mut plays = Vec::with_capacity(usize::from(count));
    for k in 0..count {
        let place = if count > 1 {
            f64::from(k) / (n - 1.0)
        } else {
            1.0
        };
        let scale = narrowest + (1.0 - narrowest) * place;
        let inward = (up - down) / 2.0 * (1.0 - scale);
        let play = Play {
            austenite: (one.austenite.0 - inward, one.austenite.1 - inward),
            martensite: (one.martensite.0 + inward, one.martensite.1 + inward),
            weight: 1.0 / n,
            memory: 1.0,
        };
        if play.austenite.0 <= play.martensite.1 || play.austenite.1 <= play.martensite.0 {
            return Err(ParameterError { name: "hysteresis" });
        }
        plays.push(play);
    }
    Ok(plays)
}
