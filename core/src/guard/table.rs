//! Constants of the thermal budget. Written by `tests/palpate/guard/table.rs`, which says how; do not edit.

/// Temperature of resting skin, degrees C.
pub(super) const REST_C: f64 = 33.0;

/// Rate of the slowest decay, 1/s; each is twice as fast as the one before.
pub(super) const SLOWEST: f64 = 0.010502762;

/// What each decay of a joule makes at 0.1 mm, K/J.
#[rustfmt::skip]
pub(super) const SHALLOW: [f64; 14] = [
    1.151710, 0.210163, 1.166705,
    3.590593, 5.964436, 14.964661,
    36.466084, 107.785704, 242.937333,
    191.886904, 579.124824, -996.658482,
    477.747289, -83.727766,
];

/// What each decay of a joule makes at 0.4 mm, K/J.
#[rustfmt::skip]
pub(super) const DEEP: [f64; 14] = [
    1.216744, 0.313980, 0.860972,
    4.555084, 3.930693, 17.644876,
    12.593567, 83.662332, -143.623915,
    94.931790, -41.770102, 16.435299,
    -6.307690, 2.021883,
];

/// What released latent heat may add at 0.1 mm, to its mean over 10 s, and at 0.4 mm, K.
pub(super) const LATENT_K: [f64; 3] = [0.2, 0.1, 0.05];
