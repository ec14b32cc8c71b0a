//! Strokes are reproduced, written as training reads them, encoded by the names of columns and placed on a map.

// A failed expectation in a test is its message.
#![allow(clippy::unwrap_used)]

use palpate_files::{TextureModel, load_textures};
use palpate_tests::seeded::Seeded;
use palpate_texture::draw::draw;
use palpate_texture::explore::{encode, explore, write_rows};
use palpate_texture::map::{Axis, View, place, ranks};

fn model(features: &str, count: usize) -> TextureModel {
    let model = Seeded::new(3, &[count, 8, 3], 100, 1.0);
    let bytes = model.file_with(&[("features", features.to_owned())]);
    TextureModel::parse("test", &bytes.unwrap()).unwrap()
}

#[test]
fn strokes_are_reproduced_and_encoded_by_the_columns_names() {
    let table = load_textures("thesis").unwrap().value;
    let all = explore(&table, 2, 5, |_| ());
    assert_eq!(all.len(), 16);
    assert!(all == explore(&table, 2, 5, |_| ()) && all != explore(&table, 2, 6, |_| ()));
    let mut text = Vec::new();
    write_rows(&all[0].1, &mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert_eq!(text.lines().count(), 201);
    assert!(text.starts_with("txl1_x,txl1_y,txl1_z,txl2_x"));
    assert!(text.lines().all(|line| line.split(',').count() == 48));

    let model_of_two = model("txl1_z,txl9_x", 2);
    let encoded = encode(&model_of_two, &all, |_| ()).unwrap();
    assert_eq!(encoded.len(), 16);
    let latents = &encoded[0].latents;
    assert_eq!((latents.len(), latents[0].len()), (11, 3));
    let refused = encode(&model("proximity1,channel2", 2), &all, |_| ());
    assert!(refused.is_err_and(|e| e.to_string().contains("txl1_x to txl16_z")));

    let axis = |coordinate, sign| Axis {
        coordinate,
        sign,
        stands_for: "",
    };
    let view = View {
        x: axis(0, 1),
        y: axis(2, -1),
    };
    let placed = place(&encoded, &model_of_two, view);
    assert_eq!(placed.len(), 8);
    // both strokes of a texture, and the axes' coordinates and signs
    let z = &encoded[2].latents[3];
    assert_eq!(placed[1].points.len(), 22);
    assert_eq!(placed[1].points[3], (f64::from(z[0]), -f64::from(z[2])));
    let ranks = ranks(&placed);
    assert!(
        ranks
            .iter()
            .all(|r| r.all.abs() <= 1.0 && r.unseen.abs() <= 1.0)
    );
    let drawing = draw(&placed, view, "A map");
    for name in ["sponge1", "shoe-sole"] {
        assert!(drawing.contains(&format!(">{name}<")));
    }
    // dashed on the map and beside the name
    assert_eq!(drawing.matches("unseen w").count(), 2 * 4);
}
