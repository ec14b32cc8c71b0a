//! Settings of the compressor, and why they are refused.

use super::found::Contact;
use super::levels::LevelTable;
use super::vectors::VectorTable;

/// Extent of a cluster and of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scope {
    /// Every module for itself; places are in its coordinates.
    #[default]
    Module,
    /// The skin as one; places are in the skin's plane (module origin + place).
    Skin,
}

/// l of (4.7): the vector norm that weighs a taxel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Norm {
    /// Sum of the axes.
    L1,
    /// Euclidean.
    #[default]
    L2,
    /// The largest axis.
    LInf,
}

/// The second stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Levels {
    /// No levels: every contact has level 1.
    #[default]
    Off,
    /// The nearest level of a table: static levels, or just-noticeable differences.
    Table(LevelTable),
    /// The nearest level of a table of vectors; needs [`Settings::vectors`].
    Vectors(VectorTable),
    /// K_I levels found anew in every frame, exactly; never more than the intensities in scope. On the wires the frame's
    /// highest counts as K_I.
    Dynamic(u16),
}

impl Levels {
    /// K_I: the highest level of a contact.
    pub fn count(&self) -> u16 {
        let count = match self {
            Self::Off => 1,
            Self::Table(table) => table.values().len(),
            Self::Vectors(table) => table.values().len(),
            Self::Dynamic(levels) => usize::from(*levels),
        };
        u16::try_from(count).unwrap_or(u16::MAX)
    }

    /// The level of a contact by a table; 1 without.
    pub fn level(&self, contact: &Contact) -> u16 {
        match self {
            Self::Off | Self::Dynamic(_) => 1,
            Self::Table(table) => table.level(contact.intensity),
            Self::Vectors(table) => table.level(contact.vector),
        }
    }
}

/// Settings of the compressor.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// K_C: contacts per scope, 1 to 4096.
    pub clusters: u16,
    /// Largest K_C while frames come ([`super::Compressor::allow`]), up to 4096. A number below `clusters` lets K_C grow no
    /// further.
    pub growth: u16,
    /// Scope within which K_C and K_I count.
    pub scope: Scope,
    /// l of (4.7).
    pub norm: Norm,
    /// p of (4.7), 0 to 16; 0 weighs all taxels alike.
    pub exponent: f32,
    /// zeta_C of (4.8), mm.
    pub tolerance: f32,
    /// Most iterations a frame.
    pub max_iterations: u32,
    /// The second stage.
    pub levels: Levels,
    /// `true` where intensities are vectors (4.9): levels are found and given along x, y and z.
    pub vectors: bool,
    /// Seed of the k-means++ draws; every scope has its own stream.
    pub seed: u64,
}

impl Default for Settings {
    /// One contact a module, weights ||s||_2, 0.001 mm, 32 iterations, no levels, seed 0.
    fn default() -> Self {
        Self {
            clusters: 1,
            growth: 0,
            scope: Scope::Module,
            norm: Norm::L2,
            exponent: 1.0,
            tolerance: 1e-3,
            max_iterations: 32,
            levels: Levels::Off,
            vectors: false,
            seed: 0,
        }
    }
}

/// Most clusters a scope may have.
const MOST_CLUSTERS: u16 = 4096;

impl Settings {
    /// The largest K_C that can come.
    pub(crate) const fn most_clusters(&self) -> u16 {
        if self.growth > self.clusters {
            self.growth
        } else {
            self.clusters
        }
    }

    /// Checks every value.
    pub fn check(&self) -> Result<(), SettingsError> {
        if self.clusters == 0 || self.most_clusters() > MOST_CLUSTERS {
            return Err(SettingsError::BadClusters);
        }
        if !(0.0..=16.0).contains(&self.exponent) {
            return Err(SettingsError::BadExponent);
        }
        if !(self.tolerance >= 0.0 && self.tolerance.is_finite()) {
            return Err(SettingsError::BadTolerance);
        }
        if self.max_iterations == 0 {
            return Err(SettingsError::NoIterations);
        }
        if self.levels == Levels::Dynamic(0) {
            return Err(SettingsError::NoLevels);
        }
        if matches!(self.levels, Levels::Vectors(_)) && !self.vectors {
            return Err(SettingsError::NoVectors);
        }
        Ok(())
    }
}

/// Reasons for which settings are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// K_C is 0 or over 4096.
    #[error("the number of contacts K_C must be 1 to 4096")]
    BadClusters,
    /// p is not within 0 to 16.
    #[error("the weight exponent must be 0 to 16")]
    BadExponent,
    /// zeta_C is not a finite number of mm, 0 or more.
    #[error("the stop tolerance must be finite and not negative")]
    BadTolerance,
    /// No iteration allowed.
    #[error("at least one iteration is needed")]
    NoIterations,
    /// K_I = 0.
    #[error("the number of levels K_I must be 1 or more")]
    NoLevels,
    /// Levels that are vectors for intensities that are none.
    #[error("levels that are vectors need intensities that are vectors")]
    NoVectors,
}
