//! The layer and its gradient on plain slices: matrix products over the whole sequence where there is no recurrence,
//! one product a step where there is, and gates in one pass. About ten times faster than a graph of small tensors.

use ndarray::linalg::general_mat_mul;
use ndarray::{ArrayView2, ArrayViewMut2};
use palpate_core::vector::Vectors;

use super::Size;
use super::panels::Panels;

/// A layer's weights as slices, row-major: `ih` `[3H, I]`, `hh` `[3H, H]`, biases `[3H]`.
#[derive(Clone, Debug)]
pub struct Flat {
    pub ih: Vec<f32>,
    pub hh: Vec<f32>,
    pub bias_ih: Vec<f32>,
    pub bias_hh: Vec<f32>,
}

/// Values of the forward pass for the backward one: the hidden states [steps * batch, H], and for each of them the
/// gates r, z, n and the recurrent part of n before its gate, [steps * batch, 4H].
#[derive(Debug)]
pub struct Trace {
    pub hidden: Vec<f32>,
    pub gates: Vec<f32>,
}

/// Gradients of a layer.
#[derive(Debug)]
pub struct Gradients {
    /// Gradient by the input [steps * batch, I], if it was asked for.
    pub input: Option<Vec<f32>>,
    pub weights: Flat,
}

fn matrix(values: &[f32], rows: usize, columns: usize) -> ArrayView2<'_, f32> {
    ArrayView2::from_shape((rows, columns), &values[..rows * columns])
        .expect("the length is rows times columns")
}

/// `to` and the product of two matrices, row-major; `to` holds as many numbers as the product has.
fn product(a: &ArrayView2<'_, f32>, b: &ArrayView2<'_, f32>, mut to: Vec<f32>) -> Vec<f32> {
    let shape = (a.nrows(), b.ncols());
    let mut sum = ArrayViewMut2::from_shape(shape, &mut to).expect("as many as the product has");
    general_mat_mul(1.0, a, b, 1.0, &mut sum);
    to
}

/// Repeats a row.
fn rows_of(row: &[f32], count: usize) -> Vec<f32> {
    row.iter()
        .copied()
        .cycle()
        .take(count * row.len())
        .collect()
}

/// exp within two units in the last place, without a branch: the compiler makes vectors of it.
#[inline(always)]
fn exp(x: f32) -> f32 {
    const SHIFT: f32 = 12_582_912.0; // 1.5 * 2^23: adding it rounds to an integer in the low bits
    let x = x.clamp(-87.0, 88.0);
    let shifted = x * core::f32::consts::LOG2_E + SHIFT;
    let whole = shifted - SHIFT;
    let r = x - whole * 0.693_359_4 + whole * 2.121_944_4e-4;
    let p = 1.987_569_1e-4;
    let p = p * r + 1.398_199_9e-3;
    let p = p * r + 8.333_452e-3;
    let p = p * r + 4.166_579_6e-2;
    let p = p * r + 1.666_666_5e-1;
    let p = p * r + 0.5;
    let p = p * r * r + r + 1.0;
    p * f32::from_bits((shifted.to_bits() << 23).wrapping_add(127 << 23))
}

#[inline(always)]
fn sigmoid(x: f32) -> f32 {
    1.0 / (1.0 + exp(-x))
}

#[inline(always)]
fn tanh(x: f32) -> f32 {
    1.0 - 2.0 / (1.0 + exp(2.0 * x))
}

/// Gates that lie side by side in a row, `units` each.
#[inline(always)]
fn parts<const N: usize>(row: &[f32], units: usize) -> [&[f32]; N] {
    core::array::from_fn(|part| &row[part * units..][..units])
}

#[inline(always)]
fn parts_mut<const N: usize>(row: &mut [f32], units: usize) -> [&mut [f32]; N] {
    let mut parts = row.chunks_exact_mut(units);
    core::array::from_fn(|_| parts.next().expect("a row has all its gates"))
}

/// Forward over the whole sequence.
pub fn forward(x: &[f32], weights: &Flat, size: Size) -> Trace {
    let Size {
        steps,
        batch,
        inputs,
        units,
    } = size;
    let (rows, gates) = (steps * batch, 3 * units);
    let from_input = product(
        &matrix(x, rows, inputs),
        &matrix(&weights.ih, gates, inputs).t(),
        rows_of(&weights.bias_ih, rows),
    );
    let hh = Panels::transposed(&weights.hh, units);
    let biases = rows_of(&weights.bias_hh, batch);
    let mut hidden = vec![0.0; rows * units];
    let mut trace = vec![0.0; rows * 4 * units];
    let zero = vec![0.0; batch * units];
    let mut from_hidden = vec![0.0; batch * gates];
    let vectors = Vectors::widest();
    for step in 0..steps {
        let (past, future) = hidden.split_at_mut(step * batch * units);
        let before = if step == 0 {
            &zero[..]
        } else {
            &past[(step - 1) * batch * units..]
        };
        from_hidden.copy_from_slice(&biases);
        hh.add(before, &mut from_hidden, vectors);
        let from_input = &from_input[step * batch * gates..][..batch * gates];
        let trace = &mut trace[step * batch * 4 * units..][..batch * 4 * units];
        let after = &mut future[..batch * units];
        vectors.run(
            #[inline(always)]
            || gate_all(units, from_input, &from_hidden, before, trace, after),
        );
    }
    Trace {
        hidden,
        gates: trace,
    }
}

#[inline(always)]
fn gate_all(
    units: usize,
    from_input: &[f32],
    from_hidden: &[f32],
    before: &[f32],
    trace: &mut [f32],
    after: &mut [f32],
) {
    let inputs = from_input
        .chunks_exact(3 * units)
        .zip(from_hidden.chunks_exact(3 * units));
    let states = before
        .chunks_exact(units)
        .zip(after.chunks_exact_mut(units));
    for (((a, b), (before, after)), trace) in
        inputs.zip(states).zip(trace.chunks_exact_mut(4 * units))
    {
        let ([ar, az, an], [br, bz, bn]) = (parts(a, units), parts(b, units));
        let [r, z, n, q] = parts_mut(trace, units);
        for i in 0..units {
            r[i] = sigmoid(ar[i] + br[i]);
            z[i] = sigmoid(az[i] + bz[i]);
            n[i] = tanh(an[i] + r[i] * bn[i]);
            q[i] = bn[i];
            after[i] = n[i] + z[i] * (before[i] - n[i]);
        }
    }
}

/// Backward over the whole sequence; `above` is the loss's gradient with respect to every hidden state.
pub fn backward(
    x: &[f32],
    weights: &Flat,
    trace: &Trace,
    above: &[f32],
    size: Size,
    to_input: bool,
) -> Gradients {
    let Size {
        steps,
        batch,
        inputs,
        units,
    } = size;
    let (rows, gates) = (steps * batch, 3 * units);
    let hh = Panels::new(&weights.hh, units);
    let zero = vec![0.0; batch * units];
    // Gradients before the gates: through the input's product and through the hidden state's.
    let (mut by_input, mut by_hidden) = (vec![0.0; rows * gates], vec![0.0; rows * gates]);
    let mut carried = vec![0.0; batch * units];
    let vectors = Vectors::widest();
    for step in (0..steps).rev() {
        let at = step * batch;
        let before = if step == 0 {
            &zero[..]
        } else {
            &trace.hidden[(at - batch) * units..][..batch * units]
        };
        let gate = &trace.gates[at * 4 * units..][..batch * 4 * units];
        let above = &above[at * units..][..batch * units];
        let of_input = &mut by_input[at * gates..][..batch * gates];
        let of_hidden = &mut by_hidden[at * gates..][..batch * gates];
        vectors.run(
            #[inline(always)]
            || {
                ungate_all(
                    units,
                    gate,
                    before,
                    above,
                    &mut carried,
                    of_input,
                    of_hidden,
                )
            },
        );
        hh.add(of_hidden, &mut carried, vectors);
    }
    let of_input = matrix(&by_input, rows, gates);
    let later = matrix(&by_hidden[batch * gates..], rows - batch, gates);
    let earlier = matrix(&trace.hidden, rows - batch, units);
    let zeros = |count: usize| vec![0.0; count];
    let ih = product(
        &of_input.t(),
        &matrix(x, rows, inputs),
        zeros(gates * inputs),
    );
    let of_hh = product(&later.t(), &earlier, zeros(gates * units));
    let input = to_input.then(|| {
        let ih = matrix(&weights.ih, gates, inputs);
        product(&of_input, &ih, zeros(rows * inputs))
    });
    Gradients {
        input,
        weights: Flat {
            ih,
            hh: of_hh,
            bias_ih: column_sums(&by_input, gates),
            bias_hh: column_sums(&by_hidden, gates),
        },
    }
}

/// Goes one step back: `carried` comes in as the gradient from the step after and leaves as the part that goes round
/// the gates; the caller adds the part that goes through them.
#[inline(always)]
fn ungate_all(
    units: usize,
    gates: &[f32],
    before: &[f32],
    above: &[f32],
    carried: &mut [f32],
    by_input: &mut [f32],
    by_hidden: &mut [f32],
) {
    let states = before
        .chunks_exact(units)
        .zip(above.chunks_exact(units))
        .zip(carried.chunks_exact_mut(units));
    let outs = by_input
        .chunks_exact_mut(3 * units)
        .zip(by_hidden.chunks_exact_mut(3 * units));
    for ((((before, above), carried), (a, b)), gate) in
        states.zip(outs).zip(gates.chunks_exact(4 * units))
    {
        let [r, z, n, q] = parts(gate, units);
        let ([ar, az, an], [br, bz, bn]) = (parts_mut(a, units), parts_mut(b, units));
        for i in 0..units {
            let d = carried[i] + above[i];
            let dn = d * (1.0 - z[i]) * (1.0 - n[i] * n[i]);
            let dz = d * (before[i] - n[i]) * z[i] * (1.0 - z[i]);
            let dr = dn * q[i] * r[i] * (1.0 - r[i]);
            (ar[i], az[i], an[i]) = (dr, dz, dn);
            (br[i], bz[i], bn[i]) = (dr, dz, dn * r[i]);
            carried[i] = d * z[i];
        }
    }
}

fn column_sums(values: &[f32], columns: usize) -> Vec<f32> {
    let mut sums = vec![0.0; columns];
    for row in values.chunks_exact(columns) {
        sums.iter_mut()
            .zip(row)
            .for_each(|(sum, value)| *sum += value);
    }
    sums
}
