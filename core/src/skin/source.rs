//! The door of the skin: scans of modules, from any sensor with any layout.
//!
//! Health is the projector's, since it serves every skin. The matters of one kind of sensor (frames that are lost,
//! boards that wait for a command) stay behind the door, as in [`super::uskin`].

use core::convert::Infallible;

use crate::units::Instant;

/// One module's readings of one scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ModuleScan<'a> {
    /// Module, zero-based, in the order of the layout.
    pub module: u16,
    /// Time at which the newest of the readings was received.
    pub at: Instant,
    /// Raw counts x, y, z of each of the module's taxels, active or not; a one-axis skin uses z.
    pub counts: &'a [[u16; 3]],
    /// Flags of the taxels that were read; the others keep their last counts. `None` where all were read.
    pub fresh: Option<&'a [bool]>,
}

impl<'a> ModuleScan<'a> {
    /// A scan in which every taxel was read.
    pub const fn whole(module: u16, at: Instant, counts: &'a [[u16; 3]]) -> Self {
        Self {
            module,
            at,
            counts,
            fresh: None,
        }
    }
}

/// Taker of scans, as [`SkinSource::scans`] hands them on.
pub type TakeScan<'a> = dyn FnMut(&ModuleScan<'_>) + 'a;

/// Source of a skin's scans for the loop.
pub trait SkinSource {
    /// Error of the source. The loop switches everything off for it.
    type Error: core::error::Error;

    /// Hands every scan that was complete by `now` to `take`, the oldest first. Never waits.
    ///
    /// # Errors
    /// The sensor's own; scans that were handed on before it count.
    fn scans(
        &mut self,
        now: Instant,
        take: &mut dyn FnMut(&ModuleScan<'_>),
    ) -> Result<(), Self::Error>;
}

/// A skin that sends nothing, for readings that are pushed.
impl SkinSource for () {
    type Error = Infallible;

    fn scans(&mut self, _now: Instant, _take: &mut TakeScan<'_>) -> Result<(), Infallible> {
        Ok(())
    }
}

/// A scan that is not of this layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ScanError {
    /// The layout has fewer modules.
    #[error("expected a module below {modules}, found {module}")]
    NoSuchModule {
        /// The scan's module, zero-based.
        module: u16,
        /// Number of modules in the layout.
        modules: usize,
    },
    /// The module has another number of taxels.
    #[error("module {module}: expected {expected} taxels, found {got}")]
    Taxels {
        /// The scan's module, zero-based.
        module: u16,
        /// Number of counts, or flags, in the scan.
        got: usize,
        /// Number of taxels in the module.
        expected: usize,
    },
}
