//! The martensite fraction xi: laws of hysteresis that are piecewise linear in temperature.
//!
//! Between two thresholds d xi/dT is constant, so the heat balance stays linear and the solver exact. The
//! memory changes only at events (a turn of the temperature, a threshold passed), which makes the laws
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
pub struct Segment {
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

/// Liang and Rogers' law with straight pieces: xi = X c(s) heating, 1 - X c(s) cooling, where
/// c(s) = (1 + cos pi s) / 2 and X is set so that the branch starts at the fraction where it turned. Restarting
/// inside a band transforms at once, as in the original: small ripple there creeps along the band.
#[derive(Clone, Copy, Debug)]
struct Cosine {
    austenite: (f64, f64),
    martensite: (f64, f64),
    pieces: u8,
    heading: Heading,
    amplitude: f64,
}

impl Cosine {
    /// Position in the band of the current heading, 0 at its start.
    fn place(&self, t: f64) -> f64 {
        let (start, finish) = match self.heading {
            Heading::Up => self.austenite,
            Heading::Down => self.martensite,
        };
        (t - start) / (finish - start)
    }

    /// Value at knot `j` of the half cosine.
    fn knot(&self, j: f64) -> f64 {
        let n = f64::from(self.pieces);
        if j >= n {
            0.0
        } else {
            (1.0 + libm::cos(core::f64::consts::PI * j / n)) / 2.0
        }
    }

    /// The half cosine in straight pieces.
    fn shape(&self, s: f64) -> f64 {
        let n = f64::from(self.pieces);
        let x = s.clamp(0.0, 1.0) * n;
        let j = libm::floor(x).min(n - 1.0);
        let (a, b) = (self.knot(j), self.knot(j + 1.0));
        a + (b - a) * (x - j)
    }

    fn fraction(&self, t: f64) -> f64 {
        let part = self.amplitude * self.shape(self.place(t));
        let xi = if self.heading == Heading::Up {
            part
        } else {
            1.0 - part
        };
        xi.clamp(0.0, 1.0)
    }

    fn turn(&mut self, t: f64, heading: Heading) {
        if heading == self.heading {
            return;
        }
        let xi = self.fraction(t);
        self.heading = heading;
        let left = if heading == Heading::Up { xi } else { 1.0 - xi };
        let shape = self.shape(self.place(t));
        self.amplitude = if shape > 0.0 {
            (left / shape).clamp(0.0, 1.0)
        } else {
            0.0
        };
    }

    fn segment(&self, t: f64) -> Segment {
        let n = f64::from(self.pieces);
        let (start, finish) = match self.heading {
            Heading::Up => self.austenite,
            Heading::Down => self.martensite,
        };
        let width = finish - start;
        let x = (t - start) / width * n;
        let near = SAME * n / width.abs();
        let (slope, next) = if x < -near {
            (0.0, start)
        } else if x >= n - near || self.amplitude <= 0.0 {
            (
                0.0,
                if self.heading == Heading::Up {
                    f64::INFINITY
                } else {
                    f64::NEG_INFINITY
                },
            )
        } else {
            let j = libm::floor(x + near);
            let steep = self.amplitude * (self.knot(j + 1.0) - self.knot(j)) * n / width;
            let slope = if self.heading == Heading::Up {
                steep
            } else {
                -steep
            };
            (slope, start + width * (j + 1.0) / n)
        };
        let (low, high) = match self.heading {
            Heading::Up => (f64::NEG_INFINITY, next),
            Heading::Down => (next, f64::INFINITY),
        };
        Segment {
            slope,
            low,
            high,
            one_way: true,
        }
    }
}

/// The phase of one wire.
#[derive(Clone, Debug)]
pub struct Phase {
    law: Law,
}

#[derive(Clone, Debug)]
enum Law {
    Plays(Vec<Play>),
    Cosine(Cosine),
}

impl Phase {
    /// As after cooling from far below, then heating to `start_c`: martensite unless hot.
    ///
    /// # Errors
    /// Branches of the hysteresis that touch or cross.
    pub fn new(wire: &WireParameters, start_c: f64) -> Result<Self, ParameterError> {
        let a = &wire.alloy;
        let shift = (wire.bias_stress_pa - a.reference_stress_pa) / a.stress_per_kelvin;
        let austenite = (a.austenite_start_c + shift, a.austenite_finish_c + shift);
        let martensite = (a.martensite_start_c + shift, a.martensite_finish_c + shift);
        let one = Play {
            austenite,
            martensite,
            weight: 1.0,
            memory: 1.0,
        };
        let law = match wire.hysteresis {
            Hysteresis::Play => Law::Plays(vec![one]),
            Hysteresis::Plays { count, narrowest } => Law::Plays(spread(&one, count, narrowest)?),
            Hysteresis::Cosine { pieces } => Law::Cosine(Cosine {
                austenite,
                martensite,
                pieces,
                heading: Heading::Up,
                amplitude: 1.0,
            }),
        };
        let mut phase = Self { law };
        phase.commit(start_c);
        Ok(phase)
    }

    /// Martensite fraction at `t` degrees C, reached without a turn since the last event; in [0, 1].
    pub fn fraction(&self, t: f64) -> f64 {
        match &self.law {
            Law::Plays(plays) => {
                let mut xi = 0.0;
                for p in plays {
                    xi += p.weight * p.fraction(t);
                }
                xi.clamp(0.0, 1.0)
            }
            Law::Cosine(c) => c.fraction(t),
        }
    }

    /// The straight piece that leads on from `t`.
    pub fn segment(&self, t: f64, heading: Heading) -> Segment {
        match &self.law {
            Law::Cosine(c) => c.segment(t),
            Law::Plays(plays) => {
                let mut s = Segment {
                    slope: 0.0,
                    low: f64::NEG_INFINITY,
                    high: f64::INFINITY,
                    one_way: false,
                };
                for p in plays {
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
        }
    }

    /// The temperature turned, or was made to turn, at `t`.
    pub fn turn(&mut self, t: f64, heading: Heading) {
        self.commit(t);
        if let Law::Cosine(c) = &mut self.law {
            c.turn(t, heading);
        }
    }

    /// A threshold was passed at `t`: what has transformed is remembered.
    pub fn commit(&mut self, t: f64) {
        if let Law::Plays(plays) = &mut self.law {
            for p in plays {
                p.memory = p.fraction(t);
            }
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
