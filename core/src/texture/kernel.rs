//! The loops that take the time: projections of inputs and steps of states, for a few columns at once.
//!
//! A column is a window (or a sample of one). A vector holds units of a block; a tile is one block for up to three
//! columns, nine sums in registers (with four, compilers run out of them), or for six where there are twice as many
//! registers. Every sum is one chain: bias, then the inputs in order, then the state's
//! units in order, each a fused multiply-add. So a column's result does not depend on its neighbours.

// Indices name registers here: a tile's columns, a block's gates.
#![allow(clippy::needless_range_loop)]

use pulp::{Simd, as_arrays};

use super::fused::{fused, fused_exact};
use super::gates;
use super::pack::Layer;

/// Rows of numbers at a fixed distance: column `c` starts at `c * stride`.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) values: &'a [f32],
    pub(super) stride: usize,
}

impl<'a> Rows<'a> {
    #[inline(always)]
    fn tile<const C: usize>(self, first: usize, offset: usize, length: usize) -> [&'a [f32]; C] {
        let mut rows = [&self.values[..0]; C];
        for (c, row) in rows.iter_mut().enumerate() {
            *row = &self.values[(first + c) * self.stride + offset..][..length];
        }
        rows
    }
}

/// Start values of a layer's sums.
#[derive(Clone, Copy)]
pub(super) enum Input<'a> {
    /// Inputs of every column, still to be weighted.
    Raw(Rows<'a>),
    /// The sums of bias and weighted inputs, `[column][block][gate][lane]`.
    Summed(Rows<'a>),
}

/// Registers with which a tile of six columns has room.
const MANY: usize = 32;

#[inline(always)]
fn wide<S: Simd>(values: &[f32]) -> &[S::f32s] {
    S::as_simd_f32s(values).0
}

#[inline(always)]
fn store<S: Simd>(out: &mut [f32], value: S::f32s) {
    if let Some(out) = S::as_mut_simd_f32s(out).0.first_mut() {
        *out = value;
    }
}

/// Adds the weighted `rows` to the sums.
#[inline(always)]
fn accumulate<S: Simd, const C: usize>(
    simd: S,
    mut sums: [[S::f32s; 3]; C],
    weights: &[f32],
    rows: [&[f32]; C],
) -> [[S::f32s; 3]; C] {
    let weights = as_arrays::<3, _>(wide::<S>(weights)).0;
    let mut rows = rows;
    for row in &mut rows {
        *row = &row[..weights.len()];
    }
    for (i, [r, z, n]) in weights.iter().enumerate() {
        for c in 0..C {
            let value = simd.splat_f32s(rows[c][i]);
            sums[c][0] = fused(simd, *r, value, sums[c][0]);
            sums[c][1] = fused(simd, *z, value, sums[c][1]);
            sums[c][2] = fused(simd, *n, value, sums[c][2]);
        }
    }
    sums
}

#[inline(always)]
fn three<S: Simd>(values: &[f32]) -> [S::f32s; 3] {
    let wide = wide::<S>(values);
    [wide[0], wide[1], wide[2]]
}

/// Bias and weighted inputs of `columns` columns to `out` `[column][block][gate][lane]`.
#[inline(always)]
pub(super) fn project<S: Simd>(
    simd: S,
    layer: &Layer,
    inputs: Rows<'_>,
    columns: usize,
    out: &mut [f32],
) {
    let sums_of = 3 * layer.lanes;
    let stride = layer.blocks() * sums_of;
    for block in 0..layer.blocks() {
        let weights =
            &layer.input.all()[block * layer.inputs * sums_of..][..layer.inputs * sums_of];
        let start = three::<S>(&layer.bias.all()[block * sums_of..][..sums_of]);
        let mut first = 0;
        while first < columns {
            macro_rules! tile {
                ($c:literal) => {{
                    let rows = inputs.tile::<$c>(first, 0, layer.inputs);
                    let sums = accumulate(simd, [start; $c], weights, rows);
                    for (c, sums) in sums.into_iter().enumerate() {
                        let out = &mut out[(first + c) * stride + block * sums_of..][..sums_of];
                        for (gate, sum) in sums.into_iter().enumerate() {
                            store::<S>(&mut out[gate * layer.lanes..], sum);
                        }
                    }
                    first += $c;
                }};
            }
            match columns - first {
                1 => tile!(1),
                2 | 4 => tile!(2),
                n if S::REGISTER_COUNT >= MANY && n >= 6 => tile!(6),
                _ => tile!(3),
            }
        }
    }
}

/// Numbers of three f64 vectors, at most.
const THREE: usize = 24;

/// Weighted inputs of `columns` columns without the bias, in f64: two of them are subtracted from each other, and what
/// is left must not have lost its digits. A product of two f32 is exact there. `weights` are the layer's own, `put` is
/// told column, place in `[block][gate][lane]` and sums, some at a time.
#[inline(always)]
pub(super) fn project_wide<S: Simd>(
    simd: S,
    layer: &Layer,
    weights: &[f64],
    inputs: Rows<'_>,
    columns: usize,
    mut put: impl FnMut(usize, usize, &[f64]),
) {
    let sums_of = 3 * layer.lanes;
    let (some, parts) = (3 * S::F64_LANES, layer.lanes / S::F64_LANES);
    for block in 0..layer.blocks() {
        let weights = &weights[block * layer.inputs * sums_of..][..layer.inputs * sums_of];
        let weights = as_arrays::<3, _>(S::as_simd_f64s(weights).0).0;
        for part in 0..parts {
            let place = block * sums_of + part * some;
            let mut first = 0;
            while first < columns {
                macro_rules! tile {
                    ($c:literal) => {{
                        let rows = inputs.tile::<$c>(first, 0, layer.inputs);
                        let mut sums = [[simd.splat_f64s(0.0); 3]; $c];
                        for (i, weights) in weights.iter().skip(part).step_by(parts).enumerate() {
                            for c in 0..$c {
                                let value = simd.splat_f64s(f64::from(rows[c][i]));
                                for v in 0..3 {
                                    sums[c][v] = fused_exact(simd, weights[v], value, sums[c][v]);
                                }
                            }
                        }
                        for c in 0..$c {
                            let mut numbers = [0.0; THREE];
                            let wide = S::as_mut_simd_f64s(&mut numbers[..some]).0;
                            wide.copy_from_slice(&sums[c]);
                            put(first + c, place, &numbers[..some]);
                        }
                        first += $c;
                    }};
                }
                match columns - first {
                    1 => tile!(1),
                    2 | 4 => tile!(2),
                    n if S::REGISTER_COUNT >= MANY && n >= 6 => tile!(6),
                    _ => tile!(3),
                }
            }
        }
    }
}

/// One step of a layer for `columns` columns: their states `now` to `next`, both `[column][unit, padded]`.
#[inline(always)]
pub(super) fn step<S: Simd>(
    simd: S,
    layer: &Layer,
    input: Input<'_>,
    now: &[f32],
    next: &mut [f32],
    columns: usize,
) {
    if let (Input::Summed(sums), 1) = (input, columns) {
        return step_one(simd, layer, sums.values, now, next, false);
    }
    let (sums_of, width) = (3 * layer.lanes, layer.width());
    let states = Rows {
        values: now,
        stride: width,
    };
    for block in 0..layer.blocks() {
        let hidden = &layer.hidden.all()[block * layer.units * sums_of..][..layer.units * sums_of];
        let weights =
            &layer.input.all()[block * layer.inputs * sums_of..][..layer.inputs * sums_of];
        let bias = three::<S>(&layer.bias.all()[block * sums_of..][..sums_of]);
        let bias_hidden = wide::<S>(&layer.bias_hidden.all()[block * layer.lanes..])[0];
        let mut first = 0;
        while first < columns {
            macro_rules! tile {
                ($c:literal) => {{
                    let mut sums = match input {
                        Input::Raw(rows) => {
                            let rows = rows.tile::<$c>(first, 0, layer.inputs);
                            accumulate(simd, [bias; $c], weights, rows)
                        }
                        Input::Summed(rows) => {
                            let mut sums = [bias; $c];
                            let rows = rows.tile::<$c>(first, block * sums_of, sums_of);
                            for (sums, row) in sums.iter_mut().zip(rows) {
                                *sums = three::<S>(row);
                            }
                            sums
                        }
                    };
                    let mut new = [bias_hidden; $c];
                    for (new, sums) in new.iter_mut().zip(&mut sums) {
                        core::mem::swap(new, &mut sums[2]);
                    }
                    let rows = states.tile::<$c>(first, 0, layer.units);
                    let sums = accumulate(simd, sums, hidden, rows);
                    for c in 0..$c {
                        let place = (first + c) * width + block * layer.lanes;
                        let [r, z, h] = sums[c];
                        let state = wide::<S>(&now[place..][..layer.lanes])[0];
                        let state = gates::unit(simd, [r, z, new[c]], h, state);
                        store::<S>(&mut next[place..][..layer.lanes], state);
                    }
                    first += $c;
                }};
            }
            match columns - first {
                1 => tile!(1),
                2 | 4 => tile!(2),
                n if S::REGISTER_COUNT >= MANY && n >= 6 => tile!(6),
                _ => tile!(3),
            }
        }
    }
}

/// Blocks side by side for a single column: one chain a gate would leave the multipliers waiting.
const BESIDE: usize = 3;

/// Steps a single column, as [`step`] does several. `backwards` takes the blocks from last to first: weights that the
/// step before read last are still near.
#[inline(always)]
pub(super) fn step_one<S: Simd>(
    simd: S,
    layer: &Layer,
    sums: &[f32],
    now: &[f32],
    next: &mut [f32],
    backwards: bool,
) {
    let groups = layer.blocks().div_ceil(BESIDE);
    for group in 0..groups {
        let group = if backwards { groups - 1 - group } else { group };
        let first = group * BESIDE;
        match layer.blocks() - first {
            1 => beside::<S, 1>(simd, layer, sums, now, next, first),
            2 => beside::<S, 2>(simd, layer, sums, now, next, first),
            _ => beside::<S, BESIDE>(simd, layer, sums, now, next, first),
        }
    }
}

#[inline(always)]
fn beside<S: Simd, const B: usize>(
    simd: S,
    layer: &Layer,
    start: &[f32],
    now: &[f32],
    next: &mut [f32],
    first: usize,
) {
    let (lanes, units) = (layer.lanes, layer.units);
    let sums_of = 3 * lanes;
    let state = &now[..units];
    let mut sums = [[simd.splat_f32s(0.0); 3]; B];
    let mut new = [simd.splat_f32s(0.0); B];
    let empty: &[[S::f32s; 3]] = &[];
    let mut weights = [empty; B];
    for b in 0..B {
        let block = first + b;
        let [r, z, n] = three::<S>(&start[block * sums_of..][..sums_of]);
        let bias_hidden = wide::<S>(&layer.bias_hidden.all()[block * lanes..])[0];
        (sums[b], new[b]) = ([r, z, bias_hidden], n);
        let hidden = &layer.hidden.all()[block * units * sums_of..][..units * sums_of];
        weights[b] = &as_arrays::<3, _>(wide::<S>(hidden)).0[..units];
    }
    for i in 0..units {
        let value = simd.splat_f32s(state[i]);
        for b in 0..B {
            let [r, z, n] = weights[b][i];
            sums[b][0] = fused(simd, r, value, sums[b][0]);
            sums[b][1] = fused(simd, z, value, sums[b][1]);
            sums[b][2] = fused(simd, n, value, sums[b][2]);
        }
    }
    for b in 0..B {
        let place = (first + b) * lanes;
        let [r, z, h] = sums[b];
        let before = wide::<S>(&now[place..][..lanes])[0];
        let state = gates::unit(simd, [r, z, new[b]], h, before);
        store::<S>(&mut next[place..][..lanes], state);
    }
}
