//! Effects of the chip's library. Their waveforms are licensed and not published: level and length of each stand for it here,
//! by its name in the data sheet's list. They are assumed.

/// Part of an effect: share of full drive, and milliseconds.
pub type Part = (f64, u16);

/// Parts of an effect, 1 to 123, in their order; none of a number that no effect has.
pub const fn parts(effect: u8) -> &'static [Part] {
    match effect {
        2 => &[(0.6, 15)],
        3 => &[(0.3, 15)],
        4 => &[(1.0, 10)],
        5 => &[(0.6, 10)],
        6 => &[(0.3, 10)],
        7 => &[(1.0, 30)],
        8 => &[(0.6, 30)],
        9 => &[(0.3, 30)],
        10 => &[(1.0, 15), (0.0, 100), (1.0, 15)],
        11 => &[(0.6, 15), (0.0, 100), (0.6, 15)],
        12 => &[(1.0, 15), (0.0, 85), (1.0, 15), (0.0, 85), (1.0, 15)],
        14 => &[(1.0, 250)],
        15 => &[(1.0, 750)],
        16 => &[(1.0, 1000)],
        47 => &[(1.0, 200)],
        48 => &[(0.8, 200)],
        49 => &[(0.6, 200)],
        50 => &[(0.4, 200)],
        51 => &[(0.2, 200)],
        118 => &[(1.0, 10_000)],
        1 | 13 | 17..=46 | 52..=117 | 119..=123 => &[(1.0, 15)],
        0 | 124..=255 => &[],
    }
}
