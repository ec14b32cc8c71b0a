//! Gauss's rule on one interval: integrals, running integrals and values between the nodes of what is smooth there.
//!
//! Products of exponentials over a piece (see [`super::wire`]) are integrated to rounding: with twelve nodes the rest is
//! under 1e-8 of the whole for what both filters let through.

/// Nodes.
pub const NODES: usize = 12;
/// Places in a piece that are looked at, both ends among them: 0.25 ms apart in the longest piece that vibrates.
pub const LOOKS: usize = 22;

/// Differences of this part of a value are rounding.
const FLAT: f64 = 1e-9;

/// Nodes, weights and what follows from them, on the interval from 0 to 1.
#[derive(Clone, Debug)]
pub struct Gauss {
    /// Places, rising.
    pub nodes: [f64; NODES],
    /// Weights, their sum is 1.
    pub weights: [f64; NODES],
    /// Values at evenly spaced places from those at the nodes: `looks[node][place]`.
    pub looks: [[f64; LOOKS]; NODES],
    /// No look is further from 0 than this times the largest value at a node.
    pub reach: f64,
    /// Coefficients over Legendre's polynomials from values at the nodes: `series[node][degree]`.
    series: [[f64; NODES]; NODES],
}

/// Legendre's polynomials of degree 0 to `NODES` at `x` in -1 to 1.
#[inline(always)]
fn legendre(x: f64) -> [f64; NODES + 1] {
    let mut p = [
        1.0, x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ];
    for n in 1..NODES {
        let k = n as f64;
        p[n + 1] = ((2.0 * k + 1.0) * x * p[n] - k * p[n - 1]) / (k + 1.0);
    }
    p
}

impl Gauss {
    /// Computes it.
    pub fn new() -> Self {
        let mut rule = Self {
            nodes: [0.0; NODES],
            weights: [0.0; NODES],
            looks: [[0.0; LOOKS]; NODES],
            reach: 0.0,
            series: [[0.0; NODES]; NODES],
        };
        let n = NODES as f64;
        for i in 0..NODES {
            let mut x = -libm::cos(core::f64::consts::PI * (i as f64 + 0.75) / (n + 0.5));
            let mut slope = 1.0;
            // Newton's method doubles the digits each time.
            for _ in 0..6 {
                let p = legendre(x);
                slope = n * (x * p[NODES] - p[NODES - 1]) / (x * x - 1.0);
                x -= p[NODES] / slope;
            }
            let weight = 1.0 / ((1.0 - x * x) * slope * slope);
            rule.nodes[i] = (1.0 + x) / 2.0;
            rule.weights[i] = weight;
            let p = legendre(x);
            for (degree, (term, p)) in rule.series[i].iter_mut().zip(p).enumerate() {
                *term = (2.0 * degree as f64 + 1.0) * weight * p;
            }
            for look in 0..LOOKS {
                let at = legendre(2.0 * look as f64 / (LOOKS - 1) as f64 - 1.0);
                let terms = rule.series[i].iter().zip(at);
                rule.looks[i][look] = terms.map(|(c, p)| c * p).sum();
            }
        }
        for look in 0..LOOKS {
            let parts = rule.looks.iter().map(|of_node| of_node[look].abs());
            rule.reach = rule.reach.max(parts.sum());
        }
        rule
    }

    /// The mean of what has these values at the nodes.
    #[inline(always)]
    pub fn mean(&self, values: &[f64; NODES]) -> f64 {
        let terms = self.weights.iter().zip(values);
        terms.map(|(w, v)| w * v).sum()
    }

    /// Coefficients of what has these values at the nodes.
    #[inline(always)]
    pub fn coefficients(&self, values: &[f64; NODES]) -> [f64; NODES] {
        let mut out = [0.0; NODES];
        for (series, value) in self.series.iter().zip(values) {
            for (sum, term) in out.iter_mut().zip(series) {
                *sum += term * value;
            }
        }
        out
    }
}

/// The square at the start of what has these [`Gauss::coefficients`], where its magnitude only falls on the interval.
#[inline(always)]
pub fn fades(coefficients: &[f64; NODES]) -> Option<f64> {
    let (mut start, mut end, mut bends) = (0.0, 0.0, 0.0);
    for (degree, c) in coefficients.iter().enumerate() {
        start += if degree % 2 == 0 { *c } else { -c };
        end += c;
        // The steepest that a polynomial of Legendre's is.
        bends += match degree {
            0 | 1 => 0.0,
            _ => (degree * (degree + 1) / 2) as f64 * c.abs(),
        };
    }
    // In a piece as short as rounding makes some, nothing but that moves.
    let most = start.abs() * (1.0 + FLAT);
    let one_way = bends <= coefficients[1].abs() + FLAT * start.abs();
    (one_way && start * end >= 0.0 && end.abs() <= most).then_some(start * start)
}

/// Integral from 0 to `part` of what has these [`Gauss::coefficients`].
#[inline(always)]
pub fn integral(coefficients: &[f64; NODES], part: f64) -> f64 {
    let x = 2.0 * part - 1.0;
    let p = legendre(x);
    let mut sum = coefficients[0] * (x + 1.0);
    for degree in 1..NODES {
        sum += coefficients[degree] * (p[degree + 1] - p[degree - 1]) / (2.0 * degree as f64 + 1.0);
    }
    sum / 2.0
}
