//! Why a layout is refused: the messages say what was expected.

use core::fmt;

pub(super) const MOST_TAXELS: usize = 1 << 22;
pub(super) const MOST_MODULES: usize = 4096;

/// Why a layout is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LayoutError {
    /// A layout without modules.
    NoModules,
    /// More than 4096 modules.
    TooManyModules {
        /// How many there were.
        count: usize,
    },
    /// A module without taxels.
    NoTaxels,
    /// More than 2^22 taxels.
    TooManyTaxels {
        /// How many there were.
        count: usize,
    },
    /// No taxel of any module is active.
    NothingActive,
    /// A coordinate is NaN, infinite or further out than 10^6 mm.
    NotFinite {
        /// The taxel.
        taxel: usize,
    },
    /// Two taxels at one place.
    Duplicate {
        /// The lower index.
        first: usize,
        /// The higher index.
        second: usize,
    },
    /// A pitch that is not a positive number of millimetres.
    BadPitch {
        /// The pitch, mm.
        pitch: f32,
    },
    /// Neither one nor three axes.
    BadAxes {
        /// The number of axes.
        axes: u8,
    },
    /// A module's origin is NaN, infinite or further out than 10^6 mm.
    BadOrigin,
    /// A board number over 15.
    BadBoard {
        /// The board.
        board: u8,
    },
    /// The list of active taxels has another length than the module.
    MaskLength {
        /// Its length.
        got: usize,
        /// The module's number of taxels.
        expected: usize,
    },
    /// Two modules with one name.
    SameName {
        /// The first module.
        first: usize,
        /// The second module.
        second: usize,
    },
    /// Two modules on one board of one bus.
    SameAddress {
        /// The first module.
        first: usize,
        /// The second module.
        second: usize,
    },
}

impl fmt::Display for LayoutError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoModules => write!(f, "a layout needs at least one module"),
            Self::TooManyModules { count } => write!(f, "{count} modules, at most {MOST_MODULES}"),
            Self::NoTaxels => write!(f, "a module needs at least one taxel"),
            Self::TooManyTaxels { count } => write!(f, "{count} taxels, at most {MOST_TAXELS}"),
            Self::NothingActive => write!(f, "no taxel of any module is active"),
            Self::NotFinite { taxel } => {
                write!(
                    f,
                    "taxel {taxel}: coordinates must be finite and within 10^6 mm"
                )
            }
            Self::Duplicate { first, second } => {
                write!(f, "taxels {first} and {second} are at the same place")
            }
            Self::BadPitch { pitch } => write!(f, "pitch {pitch} mm: expected a positive number"),
            Self::BadAxes { axes } => write!(f, "{axes} axes: expected 1 or 3"),
            Self::BadOrigin => write!(f, "the origin must be finite and within 10^6 mm"),
            Self::BadBoard { board } => write!(f, "board {board}: expected 0 to 15"),
            Self::MaskLength { got, expected } => {
                write!(f, "{got} active flags for {expected} taxels")
            }
            Self::SameName { first, second } => {
                write!(f, "modules {first} and {second} have the same name")
            }
            Self::SameAddress { first, second } => {
                write!(
                    f,
                    "modules {first} and {second} are the same board of one bus"
                )
            }
        }
    }
}

impl core::error::Error for LayoutError {}
