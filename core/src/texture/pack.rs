//! Weights in the order in which the kernels read them.
//!
//! Units stand in blocks as wide as a vector; a block's weights follow each other input by input, the three gates
//! r, z, n side by side. The last block is filled up with units of zero weights, which stay at zero.

use alloc::vec::Vec;

use super::model::Gru;

/// Numbers that start on a cache line, so that no vector straddles two.
#[derive(Debug)]
pub(super) struct Aligned {
    values: Vec<f32>,
    start: usize,
    length: usize,
}

impl Aligned {
    const LINE: usize = 64;

    pub(super) fn zeros(length: usize) -> Self {
        let spare = Self::LINE / size_of::<f32>();
        let values = alloc::vec![0.0f32; length + spare];
        let start = values.as_ptr().align_offset(Self::LINE).min(spare);
        Self {
            values,
            start,
            length,
        }
    }

    #[inline(always)]
    pub(super) fn all(&self) -> &[f32] {
        &self.values[self.start..][..self.length]
    }

    #[inline(always)]
    pub(super) fn all_mut(&mut self) -> &mut [f32] {
        &mut self.values[self.start..][..self.length]
    }
}

impl Clone for Aligned {
    fn clone(&self) -> Self {
        let mut copy = Self::zeros(self.length);
        copy.all_mut().copy_from_slice(self.all());
        copy
    }
}

/// A layer as the kernels read it.
#[derive(Clone, Debug)]
pub(super) struct Layer {
    pub(super) inputs: usize,
    pub(super) units: usize,
    /// Units of a block: the width of a vector.
    pub(super) lanes: usize,
    /// `[block][input][gate][lane]`.
    pub(super) input: Aligned,
    /// `[block][unit][gate][lane]`.
    pub(super) hidden: Aligned,
    /// `[block][gate][lane]`: what sums start from; both biases for r and z, the input's for n.
    pub(super) bias: Aligned,
    /// `[block][lane]`: n's bias on the state's side of the reset gate.
    pub(super) bias_hidden: Aligned,
}

impl Layer {
    pub(super) fn new(gru: &Gru<'_>, lanes: usize) -> Self {
        let Gru { inputs, units, .. } = *gru;
        let blocks = units.div_ceil(lanes);
        let packed = |rows: &[f32], columns: usize| {
            let mut packed = Aligned::zeros(blocks * columns * 3 * lanes);
            let mut out = packed.all_mut().iter_mut();
            for block in 0..blocks {
                for column in 0..columns {
                    for (gate, lane) in places(lanes) {
                        let unit = block * lanes + lane;
                        if let (Some(out), true) = (out.next(), unit < units) {
                            *out = kept(rows[(gate * units + unit) * columns + column]);
                        }
                    }
                }
            }
            packed
        };
        let mut bias = Aligned::zeros(blocks * 3 * lanes);
        let mut bias_hidden = Aligned::zeros(blocks * lanes);
        for unit in 0..units {
            let (block, lane) = (unit / lanes, unit % lanes);
            for gate in 0..3 {
                let row = gate * units + unit;
                let (i, h) = (gru.bias_ih[row], gru.bias_hh[row]);
                bias.all_mut()[(block * 3 + gate) * lanes + lane] =
                    if gate < 2 { i + h } else { i };
            }
            bias_hidden.all_mut()[unit] = gru.bias_hh[2 * units + unit];
        }
        Self {
            inputs,
            units,
            lanes,
            input: packed(gru.weight_ih, inputs),
            hidden: packed(gru.weight_hh, units),
            bias,
            bias_hidden,
        }
    }

    /// Blocks of units.
    #[inline(always)]
    pub(super) const fn blocks(&self) -> usize {
        self.units.div_ceil(self.lanes)
    }

    /// Numbers of one state: the units, filled up to whole blocks.
    #[inline(always)]
    pub(super) const fn width(&self) -> usize {
        self.blocks() * self.lanes
    }
}

fn places(lanes: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..3).flat_map(move |gate| (0..lanes).map(move |lane| (gate, lane)))
}

/// A weight as it is kept. Numbers so small that products with them would be denormal are zero.
fn kept(weight: f32) -> f32 {
    if weight.abs() < 1e-18 { 0.0 } else { weight }
}
