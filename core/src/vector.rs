//! Wide vectors where the machine has them: plain loops, compiled once more for AVX2 and chosen at run time.
//!
//! The loops that run through [`Vectors::run`] are ordinary Rust, written so that a compiler can do several
//! elements at a time. No sum is reordered and nothing is contracted to a fused multiply-add, so every machine
//! gets the same bits, with wide vectors or without.

use pulp::Arch;
pub use pulp::{Scalar, Simd, WithSimd};

/// The vectors of this machine.
#[derive(Clone, Copy, Debug)]
pub struct Vectors(Arch);

impl Vectors {
    /// The widest there are. Asks the processor the first time, a flag afterwards.
    pub fn widest() -> Self {
        Self(Arch::new())
    }

    /// None beyond what every machine of this target has: what the wide ones are tested against.
    pub const fn plain() -> Self {
        Self(Arch::Scalar)
    }

    /// Runs `work` compiled for these vectors. What it calls has to be `#[inline(always)]` to be compiled so too.
    #[inline(always)]
    pub fn run<R>(self, work: impl FnOnce() -> R) -> R {
        self.0.dispatch(work)
    }

    /// Runs a kernel that is written for vectors of any width. Order and rounding are the kernel's own affair.
    #[inline(always)]
    pub fn dispatch<W: WithSimd>(self, kernel: W) -> W::Output {
        self.0.dispatch(kernel)
    }

    /// Square roots in place. They are exact by IEEE 754, so every width gives the same; `libm`'s would come one
    /// at a time.
    pub fn sqrt(self, values: &mut [f32]) {
        struct Sqrt<'a>(&'a mut [f32]);
        impl WithSimd for Sqrt<'_> {
            type Output = ();
            #[inline(always)]
            fn with_simd<S: Simd>(self, simd: S) {
                let (wide, rest) = S::as_mut_simd_f32s(self.0);
                for v in wide {
                    *v = simd.sqrt_f32s(*v);
                }
                for v in rest {
                    *v = libm::sqrtf(*v);
                }
            }
        }
        self.0.dispatch(Sqrt(values));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;

    #[test]
    fn square_roots_are_the_same_in_every_width() {
        let values: Vec<f32> = (0..1_000_003u32)
            .map(|i| f32::from_bits(i.wrapping_mul(2139)))
            .collect();
        let (mut wide, mut plain) = (values.clone(), values.clone());
        Vectors::widest().sqrt(&mut wide);
        Vectors::plain().sqrt(&mut plain);
        let bits = |v: &[f32]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&wide), bits(&plain));
        assert!(
            values
                .iter()
                .zip(&wide)
                .all(|(v, root)| *root == libm::sqrtf(*v))
        );
    }
}
