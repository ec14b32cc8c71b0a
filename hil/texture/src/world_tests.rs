//! Materials are drawn as they say, and their table is one that is read.

use palpate_emulators::sensor::surface::spearman;
use palpate_files::{Source, TextureTable};

use super::*;

#[test]
fn drawn_properties_say_nothing_of_each_other_and_fill_their_ranges() {
    let materials = draw(500, 1);
    let values = |factor: Factor| -> Vec<f64> {
        let all = materials.iter().map(|m| factor.value(m));
        all.collect::<Option<_>>().unwrap()
    };
    for (n, a) in Factor::PROPERTIES.into_iter().enumerate() {
        let (low, high) = a.range();
        let inside = |value: &f64| (low..=high).contains(value);
        assert!(values(a).iter().all(inside), "{a:?}");
        // By ratios even: the middle one lies near the geometric mean.
        let mut sorted = values(a);
        sorted.sort_by(f64::total_cmp);
        let share = (sorted[250] / low).ln() / (high / low).ln();
        assert!((share - 0.5).abs() < 0.08, "{a:?}: {share}");
        for b in &Factor::PROPERTIES[n + 1..] {
            // Three standard errors of a rank correlation of 500.
            let rank = spearman(&values(a), &values(*b));
            assert!(rank.abs() < 3.0 / 499f64.sqrt(), "{a:?} {b:?}: {rank}");
        }
    }
}

#[test]
fn unseen_materials_are_in_no_table_of_the_same_seed() {
    let (drawn, unseen) = (draw(100, 1), draw_unseen(100, 1));
    for material in &unseen {
        // neither the surface nor, by the name, the strokes over it
        let like = |m: &&SurfaceTexture| {
            m.name == material.name || m.friction.to_bits() == material.friction.to_bits()
        };
        assert_eq!(drawn.iter().find(like), None);
    }
}

#[test]
fn a_table_of_them_is_one_that_is_read() {
    let materials = draw(5, 7);
    let mut text = Vec::new();
    write_table(&materials, (2, 7), &mut text).unwrap();
    let source = Source::new("independent.toml", String::from_utf8(text).unwrap());
    let table = TextureTable::read(&source).unwrap();
    let trained: Vec<bool> = table.texture.iter().map(|t| t.trained).collect();
    assert_eq!(trained, [true, true, true, false, false]);
    for (entry, material) in table.texture.iter().zip(&materials) {
        assert!((entry.relief_um - 1e3 * material.relief_mm).abs() < 0.01);
        assert!((entry.friction - material.friction).abs() < 1e-4);
        assert_eq!(entry.rated, None);
    }
}
