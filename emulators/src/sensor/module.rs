//! One skin module: taxels at rest, their noise and drift, and the counts they report.

use palpate_core::codec::uskin::Reading;
use palpate_core::random::RandomStream;
use palpate_core::units::Point;

use super::mechanics::{Dent, Press, Silicone, Touches};
use super::transducer::Transducer;
use crate::time::Nanos;

/// Settings of a module.
#[derive(Clone, Debug, PartialEq)]
pub struct ModuleConfig {
    /// The module's number on the bench: names its random streams (`"taxel m0 t3"`).
    pub number: usize,
    /// Places of the taxels, mm.
    pub taxels: Vec<Point>,
    /// Taxels that are there and that the board does not read, by index.
    pub unread: Vec<usize>,
    /// Distance of neighbouring taxels, mm.
    pub pitch_mm: f64,
    /// Transducer of the taxels.
    pub transducer: Transducer,
    /// Range from which each axis of each taxel draws its noise's standard deviation, LSB.
    pub noise_lsb: (f64, f64),
    /// Largest drift, counts: each axis approaches its own share, -1 to 1 times this. 0: none.
    pub drift_counts: f64,
    /// Time constant of the drift, s.
    pub drift_s: f64,
    /// The silicone.
    pub mechanics: Silicone,
    /// The scene's seed.
    pub seed: u64,
}

impl Default for ModuleConfig {
    /// A flat 4x4 module as sold now: noise 1 to 2.3 LSB, no drift.
    fn default() -> Self {
        Self {
            number: 0,
            taxels: grid(4, 4, 4.7),
            unread: Vec::new(),
            pitch_mm: 4.7,
            transducer: Transducer::default(),
            noise_lsb: (1.0, 2.3),
            drift_counts: 0.0,
            drift_s: 180.0,
            mechanics: Silicone::default(),
            seed: 0,
        }
    }
}

/// Taxel places of a grid around its centre, row-major, row 0 on top.
pub fn grid(rows: usize, columns: usize, pitch_mm: f64) -> Vec<Point> {
    let along = |i: usize, n: usize| (i as f64 - (n as f64 - 1.0) / 2.0) * pitch_mm;
    let place = |row, column| Point::new(along(column, columns) as f32, -along(row, rows) as f32);
    (0..rows)
        .flat_map(|row| (0..columns).map(move |column| place(row, column)))
        .collect()
}

/// Constant properties of a taxel.
#[derive(Clone, Debug)]
struct Taxel {
    at: Point,
    noise: RandomStream,
    rest: [f64; 3],
    noise_lsb: [f64; 3],
    drift: [f64; 3],
    neighbours: Vec<usize>,
}

/// A module of skin. Its physical face: [`EmulatedModule::touch`] presses on it.
pub struct EmulatedModule {
    config: ModuleConfig,
    taxels: Vec<Taxel>,
    touches: Box<dyn Touches>,
    /// Touches at the last sample.
    pressed: Vec<Press>,
    dents: Vec<Dent>,
    /// Response that the last sample tends to, and the response that the silicone has reached.
    target: Vec<[f64; 3]>,
    response: Vec<[f64; 3]>,
    direct: Vec<[f64; 3]>,
    quiet: bool,
    sampled_at: Option<Nanos>,
}

impl EmulatedModule {
    /// A module that nothing touches yet.
    pub fn new(config: ModuleConfig) -> Self {
        let reach = (1.2 * config.pitch_mm) as f32;
        let taxels: Vec<_> = (0..config.taxels.len())
            .map(|t| Taxel::new(&config, t, reach))
            .collect();
        let zero = vec![[0.0; 3]; taxels.len()];
        Self {
            taxels,
            touches: Box::new(|_, _: &mut Vec<Press>| {}),
            pressed: Vec::new(),
            dents: Vec::new(),
            target: zero.clone(),
            response: zero.clone(),
            direct: zero,
            quiet: true,
            sampled_at: None,
            config,
        }
    }

    /// Sets what touches the module from now on.
    pub fn touch(&mut self, touches: Box<dyn Touches>) {
        self.touches = touches;
    }

    /// Settings that the module was built from.
    pub const fn config(&self) -> &ModuleConfig {
        &self.config
    }

    /// Rest counts (x, y, z) of a taxel without drift.
    pub fn rest(&self, taxel: usize) -> Option<[f64; 3]> {
        Some(self.taxels.get(taxel)?.rest)
    }

    /// Reads all taxels at once at `now`, which must not lie before the last sample.
    pub fn sample(&mut self, now: Nanos, out: &mut Vec<Reading>) {
        self.respond(now);
        out.clear();
        let drift = if self.config.drift_counts > 0.0 && self.config.drift_s > 0.0 {
            1.0 - libm::exp(-now.as_secs_f64() / self.config.drift_s)
        } else {
            0.0
        };
        let most = self.config.transducer.most();
        for (taxel, response) in self.taxels.iter_mut().zip(&self.response) {
            out.push(taxel.read(response, drift, most));
        }
    }

    /// Moves the silicone on to `now`.
    fn respond(&mut self, now: Nanos) {
        self.pressed.clear();
        self.touches.touches(now, &mut self.pressed);
        let area = self.config.pitch_mm * self.config.pitch_mm;
        let dents = self.pressed.iter();
        self.dents.clear();
        self.dents
            .extend(dents.filter_map(|touch| self.config.mechanics.dent(touch, area)));
        if self.dents.is_empty() && self.quiet {
            self.sampled_at = Some(now);
            return; // nothing presses and nothing is left of earlier presses: all stays zero
        }
        let drag = self.touches.drag(now);
        let drag = drag.map(|d| {
            if self.config.transducer.shears() {
                d
            } else {
                0.0
            }
        });
        for (taxel, direct) in self.taxels.iter().zip(&mut self.direct) {
            *direct = [0.0; 3];
            for dent in &self.dents {
                let counts = dent.at(taxel.at, drag);
                (0..3).for_each(|axis| direct[axis] += counts[axis]);
            }
        }
        let span = self.sampled_at.map(|last| now.since(last).as_secs_f64());
        let lag = Lag::new(self.config.mechanics.lag_s, span);
        let leak = self.config.mechanics.crosstalk;
        let mut largest = 0.0f64;
        let states = self.target.iter_mut().zip(&mut self.response);
        for ((taxel, own), (before, response)) in self.taxels.iter().zip(&self.direct).zip(states) {
            let mut flow = [0.0; 3];
            for other in taxel.neighbours.iter().filter_map(|&n| self.direct.get(n)) {
                (0..3).for_each(|axis| flow[axis] += other[axis] - own[axis]);
            }
            for axis in 0..3 {
                let target = own[axis] + leak * flow[axis];
                response[axis] = lag.step((before[axis], response[axis]), target);
                before[axis] = target;
                largest = largest.max(response[axis].abs());
            }
        }
        // Below a thousandth of a count nothing can be seen again.
        self.quiet = self.dents.is_empty() && largest < 1e-3;
        if self.quiet {
            self.target.fill([0.0; 3]);
            self.response.fill([0.0; 3]);
        }
        self.sampled_at = Some(now);
    }
}

/// First-order low-pass over one sampling interval, exact for an input that moves along a line from
/// the last target to the new one.
#[derive(Clone, Copy)]
struct Lag {
    decay: f64,
    /// Lag of the response behind a ramp, as a share of the ramp's height.
    behind: f64,
}

impl Lag {
    /// `span` is the interval, s; `None` at the first sample, which finds the skin settled.
    fn new(lag_s: f64, span: Option<f64>) -> Self {
        match span {
            Some(span) if span > 0.0 && lag_s > 0.0 => Self {
                decay: libm::exp(-span / lag_s),
                behind: lag_s / span,
            },
            Some(_) if lag_s > 0.0 => Self {
                decay: 1.0, // no time has passed
                behind: 0.0,
            },
            _ => Self {
                decay: 0.0,
                behind: 0.0,
            },
        }
    }

    fn step(self, (target, response): (f64, f64), next: f64) -> f64 {
        if self.decay >= 1.0 {
            return response;
        }
        let behind = (next - target) * self.behind;
        next - behind + (response - target + behind) * self.decay
    }
}

impl Taxel {
    fn new(config: &ModuleConfig, t: usize, reach: f32) -> Self {
        let at = config.taxels[t];
        let mut build =
            RandomStream::new(config.seed, &format!("taxel m{} t{t} build", config.number));
        let mut per_axis = |middle: [f64; 3], half: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|axis| middle[axis] + half[axis] * (2.0 * build.uniform() - 1.0))
        };
        let rest = config.transducer.rest();
        let (low, high) = config.noise_lsb;
        Self {
            at,
            noise: RandomStream::new(config.seed, &format!("taxel m{} t{t}", config.number)),
            rest: per_axis(rest.map(|r| r.0), rest.map(|r| r.1)),
            noise_lsb: per_axis([(low + high) / 2.0; 3], [(high - low) / 2.0; 3]),
            drift: per_axis([0.0; 3], [config.drift_counts; 3]),
            // A camera's thousands of taxels would look for their neighbours in vain.
            neighbours: (0..config.taxels.len())
                .filter(|_| config.mechanics.crosstalk > 0.0)
                .filter(|&n| n != t && config.taxels[n].distance(at) <= reach)
                .collect(),
        }
    }

    fn read(&mut self, response: &[f64; 3], drift: f64, most: f64) -> Reading {
        let mut axis = |axis: usize| {
            let noise = self.noise_lsb[axis] * bell(self.noise.next_u64());
            let value = self.rest[axis] + response[axis] + drift * self.drift[axis] + noise;
            libm::rint(value).min(most) as u16 // the cast saturates at both ends, like the chip
        };
        Reading {
            x: axis(0),
            y: axis(1),
            z: axis(2),
        }
    }
}

/// A nearly normal deviate of unit variance from 64 random bits: the sum of four uniform ones
/// (Irwin-Hall), which ends at 3.46. A tenth of the cost of Box-Muller, and noise is most of what a
/// board computes.
fn bell(bits: u64) -> f64 {
    const UNIT: f64 = 1.732_050_807_568_877_2 / 65_536.0; // four twelfths have variance 1/3
    let lanes = (bits & 0xFFFF) + (bits >> 16 & 0xFFFF) + (bits >> 32 & 0xFFFF) + (bits >> 48);
    (lanes as f64 - 2.0 * 65_535.0) * UNIT
}

#[cfg(test)]
mod tests;
