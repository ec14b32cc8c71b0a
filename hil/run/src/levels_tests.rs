//! Tests of `levels.rs`.

use super::*;

#[test]
fn few_of_many_intensities_keep_the_ends_and_the_shape() {
    let mut many = Intensities::default();
    // Two contacts per frame, one of them three times as strong.
    for n in 0..400_000u32 {
        many.add([100.0, 300.0][n as usize % 2] + (n % 10) as f32);
    }
    many.add(7.0);
    assert_eq!(many.drawn.len(), TELLING);
    let strong = many.drawn.iter().filter(|i| **i >= 300.0).count();
    assert!(strong.abs_diff(TELLING / 2) < TELLING / 100, "{strong}");
    assert_eq!(many.ends, Some((7.0, 309.0)));
    let table = many.table(2).unwrap();
    let levels = [104.0, 305.0].map(|intensity| table.level(intensity));
    assert_eq!(levels, [1, 2]);
    assert!(Intensities::default().table(3).is_none());
}
