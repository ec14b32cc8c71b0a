//! The relative frame (4.2): the distance of every taxel from its reference, and the taxels in contact.
//!
//! The frame is always finite: the only ways in check their input and name the place of what they refuse.

use alloc::vec::Vec;
use core::array::from_fn;
use core::iter::repeat;
use core::ops::Range;

use super::layout::Layout;
use crate::units::Instant;
use crate::vector::Vectors;

/// A choice of axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axes([bool; 3]);

impl Axes {
    /// All three.
    pub const XYZ: Self = Self([true; 3]);
    /// The normal axis only.
    pub const Z: Self = Self([false, false, true]);

    /// Axes of any choice; `None` if it is empty.
    pub const fn new(x: bool, y: bool, z: bool) -> Option<Self> {
        if x || y || z {
            Some(Self([x, y, z]))
        } else {
            None
        }
    }

    /// Flags of the chosen axes x, y, z.
    pub const fn flags(self) -> [bool; 3] {
        self.0
    }
}

/// Reasons for which a relative frame is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FrameError {
    /// A value is NaN, infinite, or beyond 10^9 counts.
    #[error("taxel {taxel}, axis {}: expected a finite number of counts", ['x', 'y', 'z'].get(*.axis).unwrap_or(&'?'))]
    NotFinite {
        /// Taxel, running index.
        taxel: usize,
        /// Number of the axis: 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// A threshold that is NaN, infinite or negative.
    #[error("the threshold must be finite and not negative")]
    BadThreshold,
    /// Readings of another layout, or of another number of taxels.
    #[error("a frame of {got} taxels for a layout of {expected}")]
    OtherLayout {
        /// Taxels given.
        got: usize,
        /// Taxels expected.
        expected: usize,
    },
}

/// Largest value of an axis, counts: its square stays finite in f32.
const LARGEST: f32 = 1e9;

/// Distance from the reference per taxel, and the taxels in contact. Running index throughout.
#[derive(Clone, Debug)]
pub struct RelativeFrame {
    starts: Vec<u32>,
    pub(super) axes: [Vec<f32>; 3],
    /// Raw counts that the frame was made from, and the time at which they were read.
    pub(super) counts: Vec<[u16; 3]>,
    pub(super) at: Instant,
    /// True if the frame was made from those counts with the taxels now left out.
    pub(super) made: bool,
    /// Measured values, taxel by taxel: |difference| along every axis.
    pub(super) measured: Vec<[f32; 3]>,
    vectors: Vectors,
    magnitude: Vec<f32>,
    usable: Vec<bool>,
    contacts: Vec<u32>,
    contact_starts: Vec<u32>,
}

impl RelativeFrame {
    /// An untouched frame; every active taxel is usable.
    pub fn new(layout: &Layout) -> Self {
        let n = layout.taxels();
        let active = layout.modules().iter().flat_map(|m| m.active());
        Self {
            starts: layout.starts().to_vec(),
            axes: from_fn(|_| alloc::vec![0.0; n]),
            counts: alloc::vec![[0; 3]; n],
            at: Instant::ZERO,
            made: false,
            measured: alloc::vec![[0.0; 3]; n],
            vectors: Vectors::widest(),
            magnitude: alloc::vec![0.0; n],
            usable: active.copied().collect(),
            contacts: Vec::with_capacity(n),
            contact_starts: alloc::vec![0; layout.modules().len() + 1],
        }
    }

    /// Takes differences from the reference, counts (their sign is dropped), of all taxels; the axes not chosen
    /// count as 0. For callers with their own reference; [`super::Baseline`] does it from raw counts.
    ///
    /// # Errors
    /// [`FrameError`] for a wrong length, a value that is no finite number, or a bad threshold; the frame is
    /// unchanged then.
    pub fn load(
        &mut self,
        differences: &[[f32; 3]],
        axes: Axes,
        threshold: f32,
    ) -> Result<(), FrameError> {
        if differences.len() != self.magnitude.len() {
            return Err(FrameError::OtherLayout {
                got: differences.len(),
                expected: self.magnitude.len(),
            });
        }
        if !(threshold.is_finite() && threshold >= 0.0) {
            return Err(FrameError::BadThreshold);
        }
        let flags = axes.flags();
        for (taxel, d) in differences.iter().enumerate() {
            let bad = |a: &usize| flags[*a] && !(0.0..=LARGEST).contains(&libm::fabsf(d[*a]));
            if let Some(axis) = (0..3).find(bad) {
                return Err(FrameError::NotFinite { taxel, axis });
            }
        }
        for (measured, d) in self.measured.iter_mut().zip(differences) {
            // An axis that is not chosen may hold no number.
            *measured = from_fn(|a| if flags[a] { libm::fabsf(d[a]) } else { 0.0 });
        }
        self.made = false;
        self.spread(axes);
        self.find_contacts(repeat(threshold));
        Ok(())
    }

    /// Clears the frame: nothing differs and nothing is in contact.
    pub(super) fn clear(&mut self) {
        self.made = false;
        self.axes.iter_mut().for_each(|axis| axis.fill(0.0));
        self.magnitude.fill(0.0);
        self.find_contacts(repeat(0.0));
    }

    /// Returns true if the frame has the counts of this scan.
    pub(super) fn is_of(&self, scan: &super::Scan) -> bool {
        self.counts.as_flattened() == scan.counts().as_flattened()
    }

    /// Spreads the measured values by axis, with their magnitude; the axes not chosen count as 0.
    pub(super) fn spread(&mut self, axes: Axes) {
        let [x, y, z] = &mut self.axes;
        let (measured, magnitude) = (&self.measured[..], &mut self.magnitude[..]);
        // Measured values are finite: a factor of 0 makes 0.
        let factor = axes.flags().map(|chosen| if chosen { 1.0 } else { 0.0 });
        self.vectors.run(
            #[inline(always)]
            || spread(measured, factor, [x, y, z], magnitude),
        );
        self.vectors.sqrt(&mut self.magnitude);
    }

    /// The list of taxels strictly above their thresholds.
    pub(super) fn find_contacts(&mut self, thresholds: impl Iterator<Item = f32> + Clone) {
        self.contacts.clear();
        let magnitude = &self.magnitude[..];
        // Most skin is not touched most of the time: one look at all of it, without a branch.
        let touched = self.vectors.run(
            #[inline(always)]
            || {
                let above = magnitude.iter().zip(thresholds.clone());
                above.fold(false, |any, (m, t)| any | (*m > t))
            },
        );
        if !touched {
            self.contact_starts.fill(0);
            return;
        }
        let mut taxels = magnitude.iter().zip(thresholds).zip(&self.usable);
        for (module, pair) in self.starts.windows(2).enumerate() {
            let of_module = taxels.by_ref().take((pair[1] - pair[0]) as usize);
            for (i, ((magnitude, threshold), usable)) in (pair[0]..).zip(of_module) {
                if *magnitude > threshold && *usable {
                    self.contacts.push(i); // its capacity is all taxels
                }
            }
            self.contact_starts[module + 1] = self.contacts.len() as u32;
        }
    }

    /// Leaves contacts out of the list.
    pub(super) fn retain_contacts(&mut self, keep: impl Fn(u32) -> bool) {
        let mut kept = 0;
        for m in 0..self.starts.len().saturating_sub(1) {
            let listed = self.contact_starts[m] as usize..self.contact_starts[m + 1] as usize;
            // The start of the next module is read before it is set.
            self.contact_starts[m] = kept as u32;
            for from in listed {
                let taxel = self.contacts[from];
                if keep(taxel) {
                    self.contacts[kept] = taxel;
                    kept += 1;
                }
            }
        }
        if let Some(end) = self.contact_starts.last_mut() {
            *end = kept as u32;
        }
        self.contacts.truncate(kept);
    }

    /// Leaves a taxel out of contacts and interpolation, or takes it in again; holds from the next frame on.
    pub(crate) fn set_usable(&mut self, index: usize, usable: bool) {
        if let Some(u) = self.usable.get_mut(index)
            && *u != usable
        {
            *u = usable;
            self.made = false;
        }
    }

    /// Differences along x, y, z (0..3), counts, without sign; 0 where the axis is not chosen.
    pub fn axis(&self, axis: usize) -> &[f32] {
        self.axes.get(axis).map_or(&[], Vec::as_slice)
    }
    /// Raw counts along x, y, z that the frame was made from; zeros where it was made from none.
    pub fn counts(&self) -> &[[u16; 3]] {
        &self.counts
    }

    /// Euclidean norms over the chosen axes, counts.
    pub fn magnitude(&self) -> &[f32] {
        &self.magnitude
    }
    /// Flags of the taxels that are used.
    pub fn usable(&self) -> &[bool] {
        &self.usable
    }
    /// All taxels in contact, ascending.
    pub fn contacts(&self) -> &[u32] {
        &self.contacts
    }
    /// One module's taxels in contact, ascending.
    pub(crate) fn contacts_of(&self, module: usize) -> &[u32] {
        match (
            self.contact_starts.get(module),
            self.contact_starts.get(module + 1),
        ) {
            (Some(&from), Some(&to)) => &self.contacts[from as usize..to as usize],
            _ => &[],
        }
    }
    /// One module's taxels.
    pub fn range(&self, module: usize) -> Range<usize> {
        match (self.starts.get(module), self.starts.get(module + 1)) {
            (Some(&from), Some(&to)) => from as usize..to as usize,
            _ => 0..0,
        }
    }
    /// First taxel of each module, like [`Layout::starts`].
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }
}

/// Axes of their own, and squared magnitudes; slices of one length.
#[inline(always)]
fn spread(
    measured: &[[f32; 3]],
    factor: [f32; 3],
    [x, y, z]: [&mut [f32]; 3],
    squares: &mut [f32],
) {
    // Compilers make a loop over any number for many taxels: a module's few would come one at a time.
    const FEW: usize = 8;
    if measured.len() > 4 * FEW {
        return several(measured, factor, [x, y, z], squares);
    }
    let (measured, rest) = measured.as_chunks::<FEW>();
    let (x, last_x) = x.as_chunks_mut::<FEW>();
    let (y, last_y) = y.as_chunks_mut::<FEW>();
    let (z, last_z) = z.as_chunks_mut::<FEW>();
    let (squares, last_squares) = squares.as_chunks_mut::<FEW>();
    let axes = x.iter_mut().zip(y).zip(z);
    for ((measured, ((x, y), z)), squares) in measured.iter().zip(axes).zip(squares) {
        several(measured, factor, [x, y, z], squares);
    }
    several(rest, factor, [last_x, last_y, last_z], last_squares);
}

/// Spreads several taxels at once, like [`spread`].
#[inline(always)]
fn several(
    measured: &[[f32; 3]],
    factor: [f32; 3],
    [x, y, z]: [&mut [f32]; 3],
    squares: &mut [f32],
) {
    let axes = x.iter_mut().zip(y).zip(z);
    for ((measured, ((x, y), z)), square) in measured.iter().zip(axes).zip(squares) {
        (*x, *y, *z) = (
            measured[0] * factor[0],
            measured[1] * factor[1],
            measured[2] * factor[2],
        );
        *square = *x * *x + *y * *y + *z * *z;
    }
}

#[cfg(test)]
#[path = "relative_tests.rs"]
mod tests;
