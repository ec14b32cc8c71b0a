//! Reasons for which a layout is refused: the messages state what was expected.

pub(super) const MOST_TAXELS: usize = 1 << 22;
pub(super) const MOST_MODULES: usize = 4096;

/// Reasons for which a layout is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LayoutError {
    /// A layout without modules.
    #[error("a layout needs at least one module")]
    NoModules,
    /// More than 4096 modules.
    #[error("{count} modules, at most {MOST_MODULES}")]
    TooManyModules {
        /// Number of modules given.
        count: usize,
    },
    /// A module without taxels.
    #[error("a module needs at least one taxel")]
    NoTaxels,
    /// More than 2^22 taxels.
    #[error("{count} taxels, at most {MOST_TAXELS}")]
    TooManyTaxels {
        /// Number of taxels given.
        count: usize,
    },
    /// No taxel of any module is active.
    #[error("no taxel of any module is active")]
    NothingActive,
    /// A coordinate is NaN, infinite or further out than 10^6 mm.
    #[error("taxel {taxel}: coordinates must be finite and within 10^6 mm")]
    NotFinite {
        /// The taxel.
        taxel: usize,
    },
    /// Two taxels at one place.
    #[error("taxels {first} and {second} are at the same place")]
    Duplicate {
        /// The lower index.
        first: usize,
        /// The higher index.
        second: usize,
    },
    /// A pitch that is not a positive number of millimetres.
    #[error("pitch {pitch} mm: expected a positive number")]
    BadPitch {
        /// The pitch, mm.
        pitch: f32,
    },
    /// Neither one nor three axes.
    #[error("{axes} axes: expected 1 or 3")]
    BadAxes {
        /// The number of axes.
        axes: u8,
    },
    /// A module's origin is NaN, infinite or further out than 10^6 mm.
    #[error("the origin must be finite and within 10^6 mm")]
    BadOrigin,
    /// A seam that does not name two modules of the layout.
    #[error("seam {index}: expected two different modules of the layout")]
    SeamModules {
        /// The seam.
        index: usize,
    },
    /// A seam whose edges are none, or of two lengths.
    #[error(
        "seam {index}: expected an edge over 0.01 mm long, of one length to 0.01 mm in both modules"
    )]
    SeamEdges {
        /// The seam.
        index: usize,
    },
    /// Seams in so many rings that there are too many ways.
    #[error(
        "seams that leave more than {most} ways from module to module: leave out some that close a ring"
    )]
    SeamWays {
        /// The most ways.
        most: usize,
    },
    /// A board number over 15.
    #[error("board {board}: expected 0 to 15")]
    BadBoard {
        /// The board.
        board: u8,
    },
    /// The list of active taxels has another length than the module.
    #[error("{got} active flags for {expected} taxels")]
    MaskLength {
        /// Length of the mask given.
        got: usize,
        /// The module's number of taxels.
        expected: usize,
    },
    /// Two modules with one name.
    #[error("modules {first} and {second} have the same name")]
    SameName {
        /// The first module.
        first: usize,
        /// The second module.
        second: usize,
    },
    /// Two modules on one board of one bus.
    #[error("modules {first} and {second} are the same board of one bus")]
    SameAddress {
        /// The first module.
        first: usize,
        /// The second module.
        second: usize,
    },
}
