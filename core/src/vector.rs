//! Wide vectors where the machine has them: loops compiled once more for AVX2, those of the texture encoder for AVX-512
//! as well, chosen at run time.
//!
//! The loops that run through [`Vectors::run`] are ordinary Rust, written so that a compiler can do several
//! elements at a time. No sum is reordered and nothing is contracted to a fused multiply-add, so every machine
//! gets the same bits, with wide vectors or without.

use pulp::Arch;
#[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
use pulp::x86::V3;
pub use pulp::{Scalar, Simd, WithSimd};

/// The vectors of this machine.
#[derive(Clone, Copy, Debug)]
pub struct Vectors(Arch);

impl Vectors {
    /// The widest there are. Asks the processor the first time, a flag afterwards.
    pub fn widest() -> Self {
        Self(Arch::new())
    }

    /// Vectors of 256 bits (AVX2 and FMA), where there are any: the reference for wider ones.
    pub fn of_256_bits() -> Self {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        return Self(V3::try_new().map_or(Arch::Scalar, Arch::V3));
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        Self::widest()
    }

    /// Vectors that every machine of this target has: the reference for wider ones.
    pub const fn plain() -> Self {
        Self(Arch::Scalar)
    }

    /// Name of the instruction set.
    pub const fn name(self) -> &'static str {
        match self.0 {
            Arch::Scalar => "plain",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Arch::V3(_) => "AVX2",
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Arch::V4(_) => "AVX-512",
            _ => "wide",
        }
    }

    /// Runs `work` compiled for these vectors, up to 256 bits. It and what it calls have to be `#[inline(always)]` to be
    /// compiled so too.
    #[inline(always)]
    pub fn run<R>(self, work: impl FnOnce() -> R) -> R {
        self.dispatch(work)
    }

    /// Runs a kernel that is written for vectors of any width, with up to 256 bits. Order and rounding are the kernel's
    /// own affair.
    #[inline(always)]
    pub fn dispatch<W: WithSimd>(self, kernel: W) -> W::Output {
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        {
            let vectors = match self.0 {
                Arch::V4(wider) => Some(*wider),
                Arch::V3(vectors) => Some(vectors),
                _ => None,
            };
            // One place that calls it, or compilers no longer put everything into one function.
            match vectors {
                Some(vectors) => Simd::vectorize(vectors, kernel),
                None => Simd::vectorize(Scalar, kernel),
            }
        }
        #[cfg(target_arch = "wasm32")]
        return Simd::vectorize(Scalar, kernel);
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64", target_arch = "wasm32")))]
        self.0.dispatch(kernel)
    }

    /// Runs a kernel with all the width there is: for the texture encoder, which takes half the time so. (K-means of
    /// 2000 points would take 0.7 of its time, a dozen taxels and the exact solver the same within an eighth.)
    #[inline(always)]
    pub fn dispatch_widest<W: WithSimd>(self, kernel: W) -> W::Output {
        #[cfg(target_arch = "wasm32")]
        return Simd::vectorize(Scalar, kernel);
        #[cfg(not(target_arch = "wasm32"))]
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
        self.dispatch(Sqrt(values));
    }
}

#[cfg(test)]
#[path = "vector_tests.rs"]
mod tests;
