//! Weights w = ||s||_l^p of (4.7), scaled so that the heaviest taxel in scope weighs 1.
//!
//! The scale cancels in the centroid; without it p = 16 overflows f32. A floor keeps every weight positive.

use super::settings::Norm;
use crate::skin::relative::RelativeFrame;

/// The smallest weight beside 1.
const FLOOR: f32 = 1e-30;

/// Fills `weights` for the taxels `indices`, in their order; both of one length, indices within the frame.
#[inline(always)] // in every frame
pub fn fill(
    frame: &RelativeFrame,
    indices: &[u32],
    norm: Norm,
    exponent: f32,
    weights: &mut [f32],
) {
    if exponent <= 0.0 {
        weights.fill(1.0);
        return;
    }
    let (x, y, z) = (frame.axis(0), frame.axis(1), frame.axis(2));
    let mut largest = 0.0f32;
    for (w, &i) in weights.iter_mut().zip(indices) {
        let i = i as usize;
        *w = match norm {
            Norm::L1 => x[i] + y[i] + z[i],
            Norm::L2 => frame.magnitude()[i],
            Norm::LInf => x[i].max(y[i]).max(z[i]),
        };
        largest = largest.max(*w);
    }
    let scale = if largest > 0.0 { 1.0 / largest } else { 0.0 };
    let scale = if scale.is_finite() { scale } else { 0.0 };
    let (linear, square) = ((exponent - 1.0).abs() <= 0.0, (exponent - 2.0).abs() <= 0.0);
    for w in weights {
        let s = *w * scale;
        let s = if linear {
            s
        } else if square {
            s * s
        } else {
            libm::powf(s, exponent)
        };
        *w = s.max(FLOOR);
    }
}
