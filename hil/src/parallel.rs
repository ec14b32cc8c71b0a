//! Modules of a large skin on all cores. The contacts are those of a single thread, to the bit: scopes are found
//! independently, and names and levels follow in their order.

use palpate_core::contact::{Compressor, Contact};
use palpate_core::skin::{FrameError, RelativeFrame};
use rayon::prelude::*;

/// Below this many taxels the threads cost more than they save.
const WORTH_IT: usize = 20_000;

/// As [`Compressor::compress`], on all cores where the frame is large enough.
///
/// # Errors
/// As [`Compressor::compress`].
pub fn compress<'a>(
    compressor: &'a mut Compressor,
    frame: &RelativeFrame,
) -> Result<&'a [Contact], FrameError> {
    if frame.magnitude().len() < WORTH_IT {
        return compressor.compress(frame);
    }
    compressor.compress_with(frame, |scopes, locate| {
        scopes.par_iter_mut().for_each(locate)
    })
}
