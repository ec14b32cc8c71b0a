//! Tests of `mix.rs`.

use super::super::display::tests::line;
use super::super::model::{IllusionModel, ModelSettings, build};
use super::*;

fn mixer(sharing: Sharing) -> Mixer {
    let display = line(&[0.0, 10.0, 20.0]);
    let settings = ModelSettings {
        model: IllusionModel::Linear,
        ..ModelSettings::default()
    };
    Mixer::new(build(&display, &settings).unwrap(), sharing, 3)
}

fn target(x: f32, weight: f32) -> Target {
    Target {
        place: Point::new(x, 0.0),
        weight,
    }
}

#[test]
fn the_rules_by_hand() {
    let both = [target(6.0, 1.0), target(12.0, 0.5)];
    // Alone: 0.4 0.6 0, and 0 0.4 0.1.
    let strongest = mixer(Sharing::Strongest).activate(&both).to_vec();
    let expected = [0.4, 0.6, 0.1];
    assert!(
        strongest
            .iter()
            .zip(expected)
            .all(|(a, e)| (a - e).abs() < 1e-6)
    );
    let sum = mixer(Sharing::Sum).activate(&both).to_vec();
    assert!((sum[1] - libm::sqrtf(0.36 + 0.16)).abs() < 1e-6);
    let three = [target(10.0, 1.0); 3];
    assert_eq!(mixer(Sharing::Sum).activate(&three), [0.0, 1.0, 0.0]);
    assert_eq!(mixer(Sharing::Sum).activate(&[]), [0.0; 3]);
}

#[test]
fn slices_take_turns() {
    let both = [target(0.0, 1.0), target(20.0, 1.0)];
    let mixer = mixer(Sharing::Slices);
    assert_eq!(mixer.rendered(&both, 0), &both[..1]);
    assert_eq!(mixer.rendered(&both, 1), &both[1..]);
    assert_eq!(mixer.rendered(&both, 2), &both[..1]);
    assert!(mixer.rendered(&[], 3).is_empty());
}
