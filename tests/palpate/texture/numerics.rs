//! Constant, saturated, extreme, denormal and impossible numbers.

use std::sync::Arc;

use palpate_core::texture::{Encoder, ModelError, SampleError, Stream};

use palpate_tests::reference;
use palpate_tests::seeded::{Seeded, stroke};

fn build(model: &Seeded) -> Encoder {
    model.with(Encoder::new).unwrap()
}

#[test]
fn a_value_that_is_no_number_is_named_with_its_place_and_changes_nothing() {
    let model = Seeded::thesis(1);
    let encoder = Arc::new(build(&model));
    let good = stroke(1, 130, 45);
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX] {
        let mut window = good[..4500].to_vec();
        window[37 * 45 + 12] = bad;
        let error = encoder.encode(&mut encoder.room(), &window).unwrap_err();
        let SampleError::Value { index, feature, .. } = error else {
            panic!("{error}");
        };
        assert_eq!((index, feature), (37 * 45 + 12, 12));
        assert!(error.to_string().contains("feature 12"), "{error}");

        let (mut one, mut other) = (
            Stream::new(encoder.clone(), 1),
            Stream::new(encoder.clone(), 1),
        );
        for (n, sample) in good.chunks_exact(45).enumerate() {
            let mut spoiled = sample.to_vec();
            spoiled[n % 45] = bad;
            assert!(one.push(&spoiled, true).is_err());
            let (one, other) = (one.push(sample, true), other.push(sample, true));
            assert_eq!(one.unwrap(), other.unwrap());
        }
    }
    let mut room = encoder.room();
    let short = encoder.encode(&mut room, &good[..4499]);
    assert_eq!(
        short.unwrap_err(),
        SampleError::Length {
            expected: 4500,
            found: 4499
        }
    );
}

#[test]
fn a_constant_input_is_a_window_of_zeros_whatever_its_level() {
    let model = Seeded::thesis(2);
    let encoder = build(&model);
    let mut room = encoder.room();
    let zero = encoder
        .encode(&mut room, &[24_000.0; 4500])
        .unwrap()
        .to_vec();
    for level in [0.0, 31_234.0, 65_535.0, 1e-40] {
        let found = encoder.encode(&mut room, &[level; 4500]).unwrap();
        assert_eq!(found, zero);
    }
}

#[test]
fn saturated_and_wild_strokes_stay_in_range_and_near_f64() {
    let model = Seeded::thesis(3);
    let encoder = build(&model);
    let mut room = encoder.room();
    for (name, high) in [("saturated", 65_535.0f32), ("far out", 1e7)] {
        let window: Vec<f32> = (0..4500)
            .map(|i| if (i / 45 + i) % 3 == 0 { high } else { 0.0 })
            .collect();
        let expected = model.with(|m| reference::encode(m, &window));
        let found = encoder.encode(&mut room, &window).unwrap();
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.abs() <= 1.0);
            assert!(
                (f64::from(*found) - expected).abs() <= 1e-5,
                "{name}: {found} {expected}"
            );
        }
    }
}

#[test]
fn extreme_weights_give_numbers_and_impossible_ones_are_refused() {
    for size in [1e-30, 1e-6, 100.0, 1e6] {
        let model = Seeded::new(4, &[45, 96, 3], 100, size);
        let encoder = build(&model);
        let z = encoder
            .encode(&mut encoder.room(), &stroke(4, 100, 45))
            .unwrap()
            .to_vec();
        assert!(z.iter().all(|z| z.abs() <= 1.0), "{size}: {z:?}");
    }
    for bad in [f32::NAN, f32::INFINITY, 1.1e6] {
        let mut model = Seeded::thesis(4);
        model.layers[2].weight_hh[77] = bad;
        let error = model.with(Encoder::new).unwrap_err();
        assert!(
            matches!(error, ModelError::Value { index: 77, .. }),
            "{error}"
        );
        assert!(
            error
                .to_string()
                .starts_with("encoder.2.weight_hh[77]: expected"),
            "{error}"
        );
    }
    let mut model = Seeded::thesis(4);
    model.layers[1].bias_hh.pop();
    let error = model.with(Encoder::new).unwrap_err();
    assert_eq!(
        error.to_string(),
        "encoder.1.bias_hh: expected 288 numbers, found 287"
    );
    let mut model = Seeded::thesis(4);
    model.scale_max[3] = model.scale_min[3] - 1.0;
    assert_eq!(
        model.with(Encoder::new).unwrap_err(),
        ModelError::Range { feature: 3 }
    );
}

#[test]
fn a_feature_that_was_constant_in_training_carries_nothing() {
    let mut model = Seeded::thesis(5);
    model.scale_max[9] = model.scale_min[9];
    let encoder = build(&model);
    let window = stroke(5, 100, 45);
    let mut other = window.clone();
    other
        .iter_mut()
        .skip(9)
        .step_by(45)
        .for_each(|v| *v += 900.0);
    let mut room = encoder.room();
    let z = encoder.encode(&mut room, &window).unwrap().to_vec();
    assert_eq!(encoder.encode(&mut room, &other).unwrap(), z);
}
