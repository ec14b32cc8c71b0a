//! Results of compression: contacts, and the work that they took.

use crate::units::Point;

/// A contact: one place where the skin is touched.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Identity, from 1; the same as long as the contact lasts, never given twice.
    pub id: u32,
    /// Module, zero-based; with [`Scope::Skin`](super::Scope::Skin) that of the member taxel nearest to the place.
    pub module: u16,
    /// Place, mm: in module coordinates, or with [`Scope::Skin`](super::Scope::Skin) in the skin's.
    pub place: Point,
    /// Magnitude of the relative frame there (4.9), raw counts; finite, never negative.
    pub intensity: f32,
    /// Differences there along x, y and z (4.9), raw counts, whose norm is the intensity; zeros without
    /// [`Settings::vectors`](super::Settings::vectors).
    pub vector: [f32; 3],
    /// Intensity level, 1 ..= K_I; 1 without levels.
    pub level: u16,
    /// Taxels in the cluster.
    pub members: u32,
}

/// Work of the compressor so far, done and left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Frames compressed.
    pub frames: u64,
    /// Frames that came once more, with nothing to do ([`repeat`](super::Compressor::repeat)).
    pub repeats: u64,
    /// Scopes without contact.
    pub untouched: u64,
    /// Scopes whose taxels repeated the frame before, with nothing to do.
    pub repeated: u64,
    /// Scopes passed through (N_C <= K_C).
    pub passed: u64,
    /// Scopes solved by the weighted mean (K_C = 1).
    pub means: u64,
    /// K-means solves.
    pub solves: u64,
    /// K-means solves seeded by k-means++.
    pub seeded: u64,
    /// Assignments of all solves.
    pub iterations: u64,
    /// Passes over the points that these assignments took; the others were known to change nothing.
    pub passes: u64,
}

impl Work {
    /// Takes in what another compressor, or a part of one, did.
    pub fn add(&mut self, other: &Self) {
        self.frames += other.frames;
        self.repeats += other.repeats;
        self.untouched += other.untouched;
        self.repeated += other.repeated;
        self.passed += other.passed;
        self.means += other.means;
        self.solves += other.solves;
        self.seeded += other.seeded;
        self.iterations += other.iterations;
        self.passes += other.passes;
    }
}
