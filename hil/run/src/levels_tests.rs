//! Tests of `levels.rs`.

use super::*;

/// Levels by just noticeable differences go from the weakest intensity to the strongest.
#[test]
fn noticeable_levels_span_what_was_touched() {
    let mut found = Intensities::default();
    assert_eq!(found.noticeable(0.2), None);
    [200.0, 20.0, 60.0].into_iter().for_each(|v| found.add(v));
    let table = found.noticeable(0.2).unwrap();
    assert_eq!(table.values().len(), 13);
    assert_eq!(table.level(20.0), 1);
}

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
