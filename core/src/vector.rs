//! Wide vectors where the machine has them: plain loops, compiled once more for AVX2 and chosen at run time.
//!
//! The loops that run through [`Vectors::run`] are ordinary Rust, written so that a compiler can do several
//! elements at a time. No sum is reordered and nothing is contracted to a fused multiply-add, so every machine
//! gets the same bits, with wide vectors or without.

use pulp::Arch;

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
}
