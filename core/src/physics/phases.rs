//! Phases of a wire by temperature: their present state, and the straight line that leads on from it.
//!
//! Between two events every fraction, the strain and the stress change evenly with the wire's temperature. An event is a
//! band that begins or ends, a share's R phase that meets its austenite, a knot of the bow, or a turn of the temperature.

use super::law::{ALL, Band, Law, SAME};
use super::{ParameterError, WireState, check};

/// Distance at which two strains are the same; rounding is a hundredth of it.
const SAME_STRAIN: f64 = 1e-15;
/// Temperatures, degrees C, at which a history begins with all of any wire martensite, or austenite.
const COLDEST_C: f64 = -273.15;
const HOTTEST_C: f64 = 600.0;
/// Largest temperature that is computed with, degrees C; a higher one counts as this.
const FURTHEST_C: f64 = 1e6;
/// Most events on a walk between two temperatures: a bound on the work, far beyond what a wire has.
const EVENTS: usize = 10_000;

/// State of a share of the martensite, or its change with a kelvin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Part {
    /// Fraction of the share that is martensite.
    m: f64,
    /// Kelvins of expansion beyond austenite's: m (T - T0) but for the straightening.
    x: f64,
}

/// State of a wire's phases, and the line on which it goes on. It belongs to the [`Law`] that it was made with.
#[derive(Clone, Copy, Debug)]
pub struct Phases {
    at_c: f64,
    parts: [Part; ALL],
    rho: f64,
    /// Fractions of martensite and of R, and strain.
    fractions: [f64; 2],
    strain: f64,
    piece: usize,
    line: Line,
    slopes: Slopes,
}

/// Changes with a kelvin until the next event.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// Fraction of martensite, 1/K.
    pub martensite: f64,
    /// Fraction of R, 1/K.
    pub r: f64,
    /// Heat that a kelvin takes up beside the specific heat, J/K. It may be negative where stress outruns temperature; the
    /// sum of both is not.
    pub latent: f64,
    /// Strain, 1/K.
    pub strain: f64,
    /// Displacement of the bow's middle, m/K.
    pub u_m: f64,
    /// Lowest temperature of the line, degrees C.
    pub low: f64,
    /// Highest temperature of the line, degrees C.
    pub high: f64,
    /// True if the line ends when the temperature turns.
    pub one_way: bool,
}

/// Changes of the state with a kelvin.
#[derive(Clone, Copy, Debug, Default)]
struct Slopes {
    parts: [Part; ALL],
    rho: f64,
    strain: f64,
    r: f64,
    theta_m: f64,
    theta_r: f64,
    piece: usize,
}

/// Assumptions that make a line computable: the way of both thetas, 1 or -1, the piece of the bow, and whether R follows its
/// play in a share whose play and austenite change alike.
#[derive(Clone, Copy)]
struct Guess {
    way_m: f64,
    way_r: f64,
    piece: usize,
    by_play: bool,
}

/// Rates of all shares by a guess, and of their strain.
#[derive(Default)]
struct Turns {
    /// Rates of each share: with theta_M, 1/K, and the change of `x` by a kelvin and by the share's own change.
    parts: [(f64, f64, f64); ALL],
    rho: f64,
    /// Shares whose R just meets their austenite.
    ties: [bool; ALL],
    /// Shares whose R follows the play.
    by_play: [bool; ALL],
    /// Strain by a kelvin alone, by theta_M and by theta_R, 1/K.
    alone: f64,
    by_m: f64,
    by_r: f64,
}

impl Phases {
    /// A wire that went through its history, at rest; its line leads up.
    ///
    /// # Errors
    /// `mount.sag_m` where the bow is past [`super::TIGHTEST`] before the first pulse, `bias_stress_pa` where the wire would
    /// be pressed.
    pub fn rest(law: &Law) -> Result<Self, ParameterError> {
        let mut rest = Self::through(law, law.history.state, law.history.coldest_c);
        rest.commit(law, law.start_c, true);
        check("mount.sag_m", !rest.is_tight(law))?;
        check("bias_stress_pa", rest.stress_pa(law, law.start_c) >= 0.0)?;
        Ok(rest)
    }

    /// Brings a wire into the state in which its sag was measured, at its bias stress throughout.
    pub(super) fn of_sag(law: &Law) -> Self {
        let mut free = law.clone();
        free.curve.pieces.truncate(1);
        let piece = &mut free.curve.pieces[0];
        (piece.high, piece.stiffness_pa, piece.stress_pa) = (f64::INFINITY, 0.0, 0.0);
        Self::through(&free, law.history.sag_state, None)
    }

    fn through(law: &Law, state: WireState, coldest_c: Option<f64>) -> Self {
        let (at_c, p) = match state {
            WireState::Cold => (COLDEST_C, 1.0),
            WireState::Passed => (HOTTEST_C, 0.0),
        };
        let x = p * (at_c - law.rest_c);
        let mut phases = Self {
            at_c,
            parts: [Part { m: p, x }; ALL],
            rho: p,
            fractions: [0.0; 2],
            strain: 0.0,
            piece: 0,
            line: Line::default(),
            slopes: Slopes::default(),
        };
        phases.fractions = phases.sums(law);
        phases.strain = phases.strain_of(law);
        phases.piece = law.curve.at(phases.strain);
        if let Some(coldest_c) = coldest_c {
            phases.walk(law, coldest_c.min(law.start_c));
        }
        phases.walk(law, law.start_c);
        phases
    }

    /// Goes to a temperature, degrees C, slowly and without a turn.
    pub fn walk(&mut self, law: &Law, to_c: f64) {
        let up = to_c > self.at_c;
        self.commit(law, self.at_c, up);
        for _ in 0..EVENTS {
            let event = if up { self.line.high } else { self.line.low };
            if (up && event >= to_c) || (!up && event <= to_c) {
                break;
            }
            self.commit(law, event, up);
        }
        self.commit(law, to_c, up);
    }

    /// Takes an event or a turn at `t` degrees C; the temperature goes up from there, or down.
    pub fn commit(&mut self, law: &Law, t: f64, up: bool) {
        *self = self.moved(t);
        let away = self.at_c - law.rest_c;
        for part in &mut self.parts[..law.shares.len()] {
            if part.m < SAME {
                *part = Part::default();
            } else if part.m > 1.0 - SAME {
                *part = Part { m: 1.0, x: away };
            }
        }
        if self.rho < SAME || self.rho > 1.0 - SAME {
            self.rho = libm::round(self.rho);
        }
        self.fractions = self.sums(law);
        self.strain = self.strain_of(law);
        self.slopes = self.lead_on(law, if up { 1.0 } else { -1.0 });
        self.piece = self.slopes.piece;
        self.line = self.line(law, up);
    }

    /// Returns the line that leads on.
    pub const fn line_on(&self) -> &Line {
        &self.line
    }

    /// Temperature to compute with, degrees C. In electrical runaway `t` may be any number, or none.
    const fn place(&self, t: f64) -> f64 {
        if t.is_nan() {
            return self.at_c;
        }
        t.clamp(-FURTHEST_C, FURTHEST_C)
    }

    /// Moves a copy to another temperature of the line.
    fn moved(&self, t: f64) -> Self {
        let (by, mut moved) = (self.place(t) - self.at_c, *self);
        for (part, slope) in moved.parts.iter_mut().zip(&self.slopes.parts) {
            part.m += slope.m * by;
            part.x += slope.x * by;
        }
        moved.rho += self.slopes.rho * by;
        moved.strain += self.slopes.strain * by;
        moved.at_c = self.place(t);
        moved
    }

    /// Fractions of martensite and of R at a temperature of the line, each in \[0, 1\], as their sum is.
    pub const fn fractions(&self, t: f64) -> [f64; 2] {
        let (by, [m, r]) = (self.place(t) - self.at_c, self.fractions);
        let (m, r) = (m + self.line.martensite * by, r + self.line.r * by);
        let m = m.clamp(0.0, 1.0);
        [m, r.min(1.0 - m).max(0.0)]
    }

    fn sums(&self, law: &Law) -> [f64; 2] {
        let (mut m, mut r) = (0.0, 0.0);
        for (share, part) in law.shares.iter().zip(&self.parts) {
            m += share.weight * part.m;
            if share.has_r {
                r += share.weight * self.rho.min(1.0 - part.m);
            }
        }
        [m, r]
    }

    /// Strain by expansion at a temperature of the line, 1.
    pub fn thermal_strain(&self, law: &Law, t: f64) -> f64 {
        self.moved(t).expansion(law)
    }

    fn expansion(&self, law: &Law) -> f64 {
        let mut x = 0.0;
        for (share, part) in law.shares.iter().zip(&self.parts) {
            x += share.weight * part.x;
        }
        law.expansion * (self.at_c - law.rest_c) + law.expansion_m * x
    }

    /// Strain beyond the one at which the sag was measured.
    fn strain_of(&self, law: &Law) -> f64 {
        let [m, r] = self.fractions;
        self.expansion(law) + law.strain_m * m + law.strain_r * r - law.rest_strain
    }

    /// Strain beyond the one at which the sag was measured, without elastic parts, where the phases stand.
    pub(super) const fn strain(&self) -> f64 {
        self.strain
    }

    /// Strain beyond that at which the sag was measured at a temperature of the line, without elastic parts, 1.
    pub const fn strain_at(&self, t: f64) -> f64 {
        self.strain + self.slopes.strain * (self.place(t) - self.at_c)
    }

    /// Stress at a temperature of the line, Pa.
    pub fn stress_pa(&self, law: &Law, t: f64) -> f64 {
        law.bias_pa + law.curve.pieces[self.piece].stress_at(self.strain_at(t))
    }

    /// Displacement of the bow's middle from its sag at a temperature of the line, m, positive into the skin.
    pub fn u_m(&self, law: &Law, t: f64) -> f64 {
        law.curve.pieces[self.piece].u_at(self.strain_at(t))
    }

    /// True if skin and wire are apart on the line.
    pub fn is_apart(&self, law: &Law) -> bool {
        law.curve.pieces[self.piece].apart
    }

    /// True if the bow is past [`super::TIGHTEST`] on the line.
    pub fn is_tight(&self, law: &Law) -> bool {
        law.curve.pieces[self.piece].tight
    }

    /// Latent heat that the wire holds at a temperature of the line, J: none where all of it is martensite.
    pub const fn latent_j(&self, law: &Law, t: f64) -> f64 {
        let [m, r] = self.fractions(t);
        law.latent_m * (1.0 - m) - law.latent_r * r
    }

    /// Both thetas where the phases stand, degrees C.
    fn thetas(&self, law: &Law) -> [f64; 2] {
        let stress = self.stress_pa(law, self.at_c);
        [law.slope_m, law.slope_r].map(|slope| self.at_c - stress / slope)
    }

    /// Slopes from here on for a temperature that goes `way`: those of the guess that proves true. Exactly one does,
    /// because the balance is monotone.
    fn lead_on(&mut self, law: &Law, way: f64) -> Slopes {
        let last = law.curve.pieces.len() - 1;
        let here = &law.curve.pieces[self.piece];
        let above = (self.strain >= here.high - SAME_STRAIN).then(|| (self.piece + 1).min(last));
        let below = (self.strain <= here.low + SAME_STRAIN).then(|| self.piece.saturating_sub(1));
        // Mostly the strain goes on as before.
        let ahead = match self.slopes.strain * way > 0.0 {
            true => above,
            false => below,
        };
        let pieces = [ahead, Some(self.piece), above, below];
        let (mut best, mut least) = (Slopes::default(), f64::INFINITY);
        for piece in pieces.into_iter().flatten() {
            self.piece = piece;
            let thetas = self.thetas(law);
            for (m, r) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
                for by_play in [true, false] {
                    let guess = Guess {
                        way_m: m * way,
                        way_r: r * way,
                        piece,
                        by_play,
                    };
                    let (slopes, wrong) = self.slopes(law, thetas, way, &guess);
                    if wrong < least {
                        (best, least) = (slopes, wrong);
                    }
                    if wrong <= 0.0 {
                        return slopes;
                    }
                }
            }
        }
        best
    }

    /// Computes rates by a guess.
    fn turns(&self, law: &Law, [theta_m, theta_r]: [f64; 2], guess: &Guess) -> Turns {
        let away = self.at_c - law.rest_c;
        let mut turns = Turns {
            rho: law.r.rate(self.rho, theta_r, guess.way_r),
            alone: law.expansion,
            ..Turns::default()
        };
        for (k, (share, part)) in law.shares.iter().zip(&self.parts).enumerate() {
            let m = share.band.rate(part.m, theta_m, guess.way_m);
            let (free, per_m) = match (m < 0.0, guess.way_m > 0.0) {
                (false, _) => (part.m, 0.0),
                (true, true) => (0.0, part.x / part.m),
                (true, false) => (1.0, (away - part.x) / (1.0 - part.m)),
            };
            turns.parts[k] = (m, free, per_m);
            turns.alone += share.weight * law.expansion_m * free;
            turns.by_m += share.weight * (law.strain_m + law.expansion_m * per_m) * m;
            if !share.has_r {
                continue;
            }
            let over = self.rho - (1.0 - part.m);
            turns.ties[k] = over.abs() <= SAME;
            let (r_grows, rest_grows) = (sign(turns.rho, -guess.way_r), sign(m, guess.way_m));
            turns.by_play[k] = match turns.ties[k] {
                false => over < 0.0,
                true if r_grows * rest_grows > 0.0 => guess.by_play,
                true => r_grows < rest_grows,
            };
            if turns.by_play[k] {
                turns.by_r += share.weight * law.strain_r * turns.rho;
            } else {
                turns.by_m -= share.weight * law.strain_r * m;
            }
        }
        turns
    }

    /// Computes slopes by a guess for a temperature that goes `way`, and the error of the guess.
    fn slopes(&self, law: &Law, thetas: [f64; 2], way: f64, guess: &Guess) -> (Slopes, f64) {
        let (piece, turns) = (
            &law.curve.pieces[guess.piece],
            self.turns(law, thetas, guess),
        );
        let (by_m, by_r, kappa) = (turns.by_m, turns.by_r, piece.stiffness_pa);
        let gives = 1.0 - kappa * (by_m / law.slope_m + by_r / law.slope_r);
        let strain = (turns.alone + by_m + by_r) / gives;
        let theta_m = 1.0 + kappa * strain / law.slope_m;
        let theta_r = 1.0 + kappa * strain / law.slope_r;
        let mut slopes = Slopes {
            rho: turns.rho * theta_r,
            strain,
            theta_m,
            theta_r,
            piece: guess.piece,
            ..Slopes::default()
        };
        let mut wrong = f64::max(-theta_m * guess.way_m * way, -theta_r * guess.way_r * way);
        for (k, share) in law.shares.iter().enumerate() {
            let (turn, free, per_m) = turns.parts[k];
            let m = turn * theta_m;
            slopes.parts[k] = Part {
                m,
                x: free + per_m * m,
            };
            if share.has_r {
                let [chosen, other] = match turns.by_play[k] {
                    true => [slopes.rho, -m],
                    false => [-m, slopes.rho],
                };
                slopes.r += share.weight * chosen;
                if turns.ties[k] {
                    wrong = wrong.max((chosen - other) * way);
                }
            }
        }
        if self.strain >= piece.high - SAME_STRAIN {
            wrong = wrong.max(strain * way);
        }
        if self.strain <= piece.low + SAME_STRAIN {
            wrong = wrong.max(-strain * way);
        }
        (slopes, wrong)
    }

    /// Sums up the slopes, and finds their end.
    fn line(&self, law: &Law, up: bool) -> Line {
        let (slopes, piece) = (&self.slopes, &law.curve.pieces[self.piece]);
        let mut martensite = 0.0;
        let mut ends = Ends {
            at: self.at_c,
            low: f64::NEG_INFINITY,
            high: f64::INFINITY,
        };
        let [theta_m, theta_r] = self.thetas(law);
        ends.play(&law.r, self.rho, slopes.rho, (theta_r, slopes.theta_r));
        let mut one_way = slopes.rho.abs() > 0.0;
        for (k, share) in law.shares.iter().enumerate() {
            let (m, slope) = (self.parts[k].m, slopes.parts[k].m);
            martensite += share.weight * slope;
            one_way |= slope.abs() > 0.0;
            ends.play(&share.band, m, slope, (theta_m, slopes.theta_m));
            let over = self.rho - (1.0 - m);
            if share.has_r && over.abs() > SAME {
                ends.reach(over.abs(), -over.signum() * (slopes.rho + slope));
            }
        }
        ends.reach(piece.high - self.strain, slopes.strain);
        ends.reach(self.strain - piece.low, -slopes.strain);
        if one_way && up {
            ends.low = f64::NEG_INFINITY;
        } else if one_way {
            ends.high = f64::INFINITY;
        }
        Line {
            martensite,
            r: slopes.r,
            latent: -law.latent_m * martensite - law.latent_r * slopes.r,
            strain: slopes.strain,
            u_m: piece.u_per * slopes.strain,
            low: ends.low,
            high: ends.high,
            one_way,
        }
    }
}

/// Sign that a change has along the way: that of a play's rate, or none.
fn sign(rate: f64, way: f64) -> f64 {
    if rate < 0.0 { way } else { 0.0 }
}

/// Temperatures between which a line holds.
struct Ends {
    at: f64,
    low: f64,
    high: f64,
}

impl Ends {
    /// Adds the end of a value that is `gap` away and comes nearer by `slope` with a kelvin.
    fn reach(&mut self, gap: f64, slope: f64) {
        let at = self.at + gap.max(0.0) / slope;
        if slope > 0.0 {
            self.high = self.high.min(at);
        } else if slope < 0.0 {
            self.low = self.low.max(at);
        }
    }

    /// Adds the beginning or end of a play that stands at `p` and changes by `slope` with a kelvin, by its theta and
    /// the slope of that.
    fn play(&mut self, band: &Band, p: f64, slope: f64, (theta, theta_slope): (f64, f64)) {
        if slope.abs() > 0.0 {
            self.reach(p, -slope);
            self.reach(1.0 - p, slope);
            return;
        }
        if p > 0.0 {
            self.reach(band.up(p) - theta, theta_slope);
        }
        if p < 1.0 {
            self.reach(theta - band.down(p), -theta_slope);
        }
    }
}

#[cfg(test)]
#[path = "phases_tests.rs"]
mod tests;
