//! The 8-bit protocol of the iCub skin's MTB boards, which FabricSlide-type fingers speak too.
//!
//! A triangle of twelve single-axis taxels comes in two frames under the class 4 identifier
//! `0x400 | board << 4 | triangle`: `40 t0..t6`, then `C0 t7..t11 e6 e7`.

use super::can::CanFrame;

/// Identifier class of skin data.
const CLASS: u16 = 0x400;
/// Byte 0 of the frame with taxels 0 to 6.
pub const FIRST: u8 = 0x40;
/// Byte 0 of the frame with taxels 7 to 11 and the error bytes.
pub const SECOND: u8 = 0xC0;
/// Taxels of a triangle.
pub const TAXELS: usize = 12;
/// Taxels in the first frame of a triangle.
pub const FIRST_HALF: usize = 7;
/// Taxels of a board: sixteen triangles.
pub const MOST_TAXELS: usize = 16 * TAXELS;

/// Half a triangle, as one frame carries it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// Taxels 0 to 6, counts.
    First([u8; 7]),
    /// Taxels 7 to 11, counts, and the board's two error bytes.
    Second([u8; 5], [u8; 2]),
}

impl Half {
    /// Place of the half's first taxel in the triangle, and the half's taxels.
    pub fn taxels(&self) -> (u16, &[u8]) {
        match self {
            Self::First(taxels) => (0, taxels),
            Self::Second(taxels, _) => (FIRST_HALF as u16, taxels),
        }
    }
}

/// A frame's meaning: who sent which half.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Message {
    /// Board, 0 ..= 15.
    pub board: u8,
    /// Triangle on that board, 0 ..= 15.
    pub triangle: u8,
    /// The taxels.
    pub half: Half,
}

/// Identifier of a triangle; `None` for a board or triangle over 15.
pub fn id(board: u8, triangle: u8) -> Option<u16> {
    let fits = board <= 15 && triangle <= 15;
    fits.then(|| CLASS | u16::from(board) << 4 | u16::from(triangle))
}

/// Board and triangle that send under an identifier; `None` for an identifier outside skin data.
pub fn sender(id: u16) -> Option<(u8, u8)> {
    (id & 0x700 == CLASS).then_some(((id >> 4 & 0xF) as u8, (id & 0xF) as u8))
}

impl Message {
    /// The meaning of a frame, or `None` if it is no skin data of this protocol.
    pub fn decode(frame: &CanFrame) -> Option<Self> {
        let half = match *frame.data() {
            [FIRST, a, b, c, d, e, f, g] => Half::First([a, b, c, d, e, f, g]),
            [SECOND, a, b, c, d, e, e6, e7] => Half::Second([a, b, c, d, e], [e6, e7]),
            _ => return None,
        };
        let (board, triangle) = sender(frame.id())?;
        Some(Self {
            board,
            triangle,
            half,
        })
    }

    /// The frame; `None` for a board or triangle over 15.
    pub fn encode(&self) -> Option<CanFrame> {
        let id = id(self.board, self.triangle)?;
        match self.half {
            Half::First([a, b, c, d, e, f, g]) => CanFrame::new(id, &[FIRST, a, b, c, d, e, f, g]),
            Half::Second([a, b, c, d, e], [e6, e7]) => {
                CanFrame::new(id, &[SECOND, a, b, c, d, e, e6, e7])
            }
        }
    }
}

/// Both halves of one triangle in wire order, without errors.
pub fn halves(taxels: &[u8; TAXELS]) -> [Half; 2] {
    let [a, b, c, d, e, f, g, h, i, j, k, l] = *taxels;
    [
        Half::First([a, b, c, d, e, f, g]),
        Half::Second([h, i, j, k, l], [0, 0]),
    ]
}

#[cfg(test)]
#[path = "mtb_tests.rs"]
mod tests;
