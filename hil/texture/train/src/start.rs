//! First weights that hear fast and small changes: the first layer begins as slow means of its inputs and as the rest
//! of them, the second as the size of mixtures of the latter.
//!
//! Drawn weights find friction and stiffness, which are in slow readings. A relief is in fast ones, weaker than noise
//! in one taxel, and only its size tells: that takes a difference and an even function, which training did not find by
//! itself.

use palpate_core::random::RandomStream;

/// Scale of the slow means, so that tanh hardly bends them.
const SMALL: f64 = 0.05;
/// Steps that a slow mean remembers.
const SLOW_STEPS: f64 = 4.0;
/// Bias that holds a gate open (or, negative, shut).
const OPEN: f64 = 3.0;
/// Factor on the other weights of those units.
const FAINT: f64 = 0.1;
/// Mixtures of fast inputs whose size is taken, and the length of their weights.
const MIXTURES: usize = 48;
const MIXED: f64 = 2.0;
/// Steps over which sizes are averaged, shortest and longest.
const SIZE_STEPS: [f64; 2] = [3.0, 20.0];

/// A layer's weights, row-major, in the gate order r, z, n.
pub struct Layer<'a> {
    pub ih: &'a mut [f64],
    pub hh: &'a mut [f64],
    pub bias_ih: &'a mut [f64],
    pub inputs: usize,
    pub units: usize,
}

impl Layer<'_> {
    fn input(&mut self, gate: usize, unit: usize) -> &mut [f64] {
        let row = gate * self.units + unit;
        &mut self.ih[row * self.inputs..][..self.inputs]
    }

    fn state(&mut self, gate: usize, unit: usize) -> &mut [f64] {
        let row = gate * self.units + unit;
        &mut self.hh[row * self.units..][..self.units]
    }

    fn bias(&mut self, gate: usize, unit: usize) -> &mut f64 {
        &mut self.bias_ih[gate * self.units + unit]
    }
}

/// Number of inputs that have a slow and a fast unit each in the first layer.
fn paired(inputs: usize, units: usize) -> usize {
    inputs.min(units / 2)
}

/// The first layer: unit `i` follows input `i` slowly, unit `paired + i` is input `i` less that.
pub fn high_pass(mut layer: Layer<'_>) {
    let [reset, update, new] = [0, 1, 2];
    let count = paired(layer.inputs, layer.units);
    for unit in 0..2 * count {
        let input = unit % count;
        for gate in [reset, update] {
            layer.input(gate, unit).iter_mut().for_each(|w| *w *= FAINT);
            layer.state(gate, unit).iter_mut().for_each(|w| *w *= FAINT);
        }
        layer.input(new, unit).fill(0.0);
        layer.state(new, unit).fill(0.0);
        if unit < count {
            layer.input(new, unit)[input] = SMALL;
            *layer.bias(update, unit) = SLOW_STEPS.ln();
        } else {
            layer.input(new, unit)[input] = 1.0;
            // the reset gate lets nearly all of it through
            layer.state(new, unit)[input] = -(1.0 + (-OPEN).exp()) / SMALL;
            *layer.bias(reset, unit) = OPEN;
            *layer.bias(update, unit) = -OPEN;
        }
    }
}

/// Fills the second layer, over a first one of `first_inputs` inputs: mixtures of its fast units open their own update
/// gate, so that one sign counts more than the other, and their size stays.
pub fn sizes(mut layer: Layer<'_>, first_inputs: usize, stream: &mut RandomStream) {
    let [update, new] = [1, 2];
    let count = paired(first_inputs, layer.inputs);
    for unit in 0..MIXTURES.min(layer.units) {
        let mixture: Vec<f64> = (0..count).map(|_| stream.normal()).collect();
        let length = mixture.iter().map(|m| m * m).sum::<f64>().sqrt();
        for (gate, factor) in [(new, MIXED), (update, -2.0 * MIXED)] {
            let row = layer.input(gate, unit);
            row.fill(0.0);
            let fast = row[count..2 * count].iter_mut();
            fast.zip(&mixture)
                .for_each(|(w, m)| *w = factor * m / length);
        }
        layer.state(new, unit).fill(0.0);
        let [short, long] = SIZE_STEPS;
        *layer.bias(update, unit) = (short + (long - short) * stream.uniform()).ln();
    }
}

#[cfg(test)]
#[path = "start_tests.rs"]
mod tests;
