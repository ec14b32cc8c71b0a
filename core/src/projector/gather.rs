//! One contact that rubs, as the network knows surfaces: stroked by a module's whole face.
//!
//! A face carries a stroke on all its taxels, each with a relief of its own under it; a contact carries it on a few, and
//! moves. So every taxel gets the contact's load spread over all of them, and the fast changes of the contact's own taxels
//! unspread: as much of each as it bears of the load, which keeps most of the signal where the noise is one taxel's. They
//! reach one taxel a sample after the other, as asperities pass.

use alloc::boxed::Box;
use alloc::vec;

/// Samples whose mean is slow, and the one in the middle of them.
const SLOW: usize = 5;
const MIDDLE: usize = SLOW / 2;

/// A module's readings made into those of a stroke.
#[derive(Debug)]
pub(super) struct Gathering {
    /// The module's taxels that are read, in the scan.
    read: Box<[usize]>,
    /// Their newest normal readings, the newest first.
    normal: Box<[[f32; SLOW]]>,
    is_new: bool,
    /// Mean shear, turned, and mean slow normal reading.
    means: [f32; 3],
    /// Fast changes, one for each taxel of the module; the newest at `newest`.
    fast: Box<[f32]>,
    newest: usize,
}

impl Gathering {
    /// Gathering of the taxels `read` in a module of `taxels`.
    pub(super) fn new(read: Box<[usize]>, taxels: usize) -> Self {
        Self {
            normal: vec![[0.0; SLOW]; read.len()].into(),
            read,
            is_new: true,
            means: [0.0; 3],
            fast: vec![0.0; taxels.max(1)].into(),
            newest: 0,
        }
    }

    /// Takes a scan's counts, of a module that is touched or not, and of each taxel its reference, counts.
    pub(super) fn push(
        &mut self,
        counts: &[[u16; 3]],
        touched: bool,
        reference: impl Fn(usize) -> [f64; 3],
    ) {
        let (mut slow, mut sum, mut rest) = (0.0, [0.0; 2], [0.0; 2]);
        let (mut fast, mut weights) = (0.0, 0.0);
        for (&taxel, normal) in self.read.iter().zip(&mut self.normal) {
            let reading = counts[taxel].map(f32::from);
            let at_rest = reference(taxel).map(|counts| counts as f32);
            normal.copy_within(..SLOW - 1, 1);
            normal[0] = reading[2];
            if self.is_new {
                *normal = [reading[2]; SLOW];
            }
            let mean = normal.iter().sum::<f32>() / SLOW as f32;
            let load = mean - at_rest[2];
            fast += load * (normal[MIDDLE] - mean);
            weights += load * load;
            slow += mean;
            for axis in 0..2 {
                sum[axis] += reading[axis];
                rest[axis] += at_rest[axis];
            }
        }
        self.is_new = false;
        let share = 1.0 / self.read.len().max(1) as f32;
        // Shear is turned to the module's -x, where a stroke along +x drags the skin: which way it goes says the contact itself.
        let shear = libm::hypotf(sum[0] - rest[0], sum[1] - rest[1]);
        self.means = [rest[0] - shear, rest[1], slow].map(|of_all| of_all * share);
        self.newest = (self.newest + 1) % self.fast.len();
        self.fast[self.newest] = match touched && weights > 0.0 {
            true => fast / libm::sqrtf(weights),
            false => 0.0,
        };
    }

    /// The reading of an axis that a taxel of the module, counted in it, would have under a stroke.
    pub(super) fn reading(&self, taxel: usize, axis: usize) -> f32 {
        let count = self.fast.len();
        let late = (self.newest + count - taxel % count) % count;
        match axis {
            2 => self.means[2] + self.fast[late],
            _ => self.means[axis],
        }
    }
}

#[cfg(test)]
#[path = "gather_tests.rs"]
mod tests;
