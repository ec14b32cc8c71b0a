//! Tests of `levels.rs`.

use super::*;

fn contact(intensity: f32) -> Contact {
    Contact {
        intensity,
        ..Contact::default()
    }
}

/// Levels by just noticeable differences go from the weakest intensity to the strongest.
#[test]
fn noticeable_levels_span_what_was_touched() {
    let mut found = Intensities::default();
    assert_eq!(found.noticeable(0.2), Levels::Off);
    for intensity in [200.0, 20.0, 60.0] {
        found.add(&contact(intensity));
    }
    let levels = found.noticeable(0.2);
    assert_eq!(levels.count(), 13);
    assert_eq!(levels.level(&contact(20.0)), 1);
}

#[test]
fn few_of_many_intensities_keep_the_ends_and_the_shape() {
    let mut many = Intensities::default();
    // Two contacts per frame, one of them three times as strong.
    for n in 0..400_000u32 {
        many.add(&contact([100.0, 300.0][n as usize % 2] + (n % 10) as f32));
    }
    many.add(&contact(7.0));
    assert_eq!(many.drawn.len(), TELLING);
    let strong = many.drawn.iter().filter(|i| i.0 >= 300.0).count();
    assert!(strong.abs_diff(TELLING / 2) < TELLING / 100, "{strong}");
    let ends = many.ends.map(|(least, most)| (least.0, most.0));
    assert_eq!(ends, Some((7.0, 309.0)));
    let levels = many.levels(2, false);
    let levels = [104.0, 305.0].map(|intensity| levels.level(&contact(intensity)));
    assert_eq!(levels, [1, 2]);
    for vectors in [false, true] {
        assert_eq!(Intensities::default().levels(3, vectors), Levels::Off);
    }
}
