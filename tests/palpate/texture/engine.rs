//! One window, windows in flight, many modules, wide and plain vectors: one answer.

use std::sync::Arc;

use palpate_core::texture::{Encoder, Ends, Stream};
use palpate_core::units::Duration;
use palpate_core::vector::Vectors;
use proptest::prelude::*;

use palpate_files::{TextureModel, load_textures};
use palpate_tests::reference;
use palpate_tests::seeded::{Seeded, stroke};
use palpate_texture::explore;

fn encoder(model: &Seeded, vectors: Vectors) -> Encoder {
    model.with(|m| Encoder::with(m, vectors)).unwrap()
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|v| v.to_bits()).collect()
}

/// z of every window of a recording, one after the other.
fn one_by_one(encoder: &Encoder, values: &[f32]) -> Vec<Vec<u32>> {
    let (features, mut room) = (encoder.features(), encoder.room());
    values
        .windows(encoder.window() * features)
        .step_by(features)
        .map(|window| bits(encoder.encode(&mut room, window).unwrap()))
        .collect()
}

/// What comes out of a stream, with the sample after which it came.
fn streamed(
    stream: &mut Stream,
    values: &[f32],
    row: usize,
    ends: Ends,
    window: usize,
) -> Vec<(usize, Vec<u32>)> {
    let mut found = Vec::new();
    for (n, sample) in values.chunks_exact(row).enumerate() {
        let begin = ends.begins(n as u64, window);
        if let Some(latents) = stream.push(sample, begin).unwrap() {
            found.push((n, bits(latents)));
        }
    }
    found
}

/// What a network has learnt decides how much it makes of the last digits.
#[test]
fn the_model_that_ships_agrees_with_f64_over_whole_strokes() {
    let model = TextureModel::open("default").unwrap();
    let encoder = model.encoder().unwrap();
    let (mut room, row) = (encoder.room(), encoder.features());
    let table = load_textures("thesis").unwrap().value;
    for (entry, recording) in explore::explore(&table, 2, 5, |_| ()) {
        let values = explore::features(&model, &recording).unwrap();
        for window in values.windows(encoder.window() * row).step_by(13 * row) {
            let found = encoder.encode(&mut room, window).unwrap();
            let expected = model.with(|m| reference::encode(m, window));
            for (found, expected) in found.iter().zip(expected) {
                let error = (f64::from(*found) - expected).abs();
                assert!(error <= 1e-5, "{}: {error:e}", entry.name);
            }
        }
    }
}

#[test]
fn the_thesis_encoder_agrees_with_f64() {
    for seed in 0..3 {
        for size in [1.0, 3.0] {
            let model = Seeded::new(seed, &[45, 96, 96, 96, 3], 100, size);
            let encoder = encoder(&model, Vectors::widest());
            let window = stroke(seed, 100, 45);
            let expected = model.with(|m| reference::encode(m, &window));
            let mut room = encoder.room();
            let found = encoder.encode(&mut room, &window).unwrap();
            assert_eq!(found.len(), 3);
            for (found, expected) in found.iter().zip(expected) {
                let error = (f64::from(*found) - expected).abs();
                assert!(error <= 1e-5, "seed {seed}, size {size}: {error:e}");
            }
        }
    }
}

#[test]
fn windows_in_flight_are_single_windows_bit_for_bit() {
    let model = Seeded::thesis(5);
    let encoder = Arc::new(encoder(&model, Vectors::widest()));
    let values = stroke(5, 230, 45);
    let expected = one_by_one(&encoder, &values);
    let mut stream = Stream::new(encoder.clone(), 1);
    let mut found = Vec::new();
    for (n, sample) in values.chunks_exact(45).enumerate() {
        let ended = stream.push(sample, true).unwrap().map(bits);
        assert_eq!(ended.is_some(), n >= 99, "sample {n}");
        assert_eq!(stream.in_flight(), (n + 1).min(99));
        found.extend(ended);
    }
    assert_eq!(found, expected);
}

#[test]
fn on_demand_gives_the_bits_of_every_hop() {
    let model = Seeded::thesis(6);
    let encoder = Arc::new(encoder(&model, Vectors::widest()));
    let values = stroke(6, 300, 45);
    let every = streamed(
        &mut Stream::new(encoder.clone(), 1),
        &values,
        45,
        Ends::Every,
        100,
    );
    let ends = Ends::Onsets {
        sample: Duration::from_micros(10_000),
        every: Duration::from_micros(58_500),
    };
    let mut stream = Stream::new(encoder, 1);
    let asked = streamed(&mut stream, &values, 45, ends, 100);
    assert!(stream.in_flight() <= 18);
    let expected: Vec<_> = every
        .into_iter()
        .filter(|(n, _)| {
            let next = (*n as u64 * 10_000).div_ceil(58_500) * 58_500;
            next < (*n as u64 + 1) * 10_000
        })
        .collect();
    assert_eq!(asked.len(), 35);
    assert_eq!(asked, expected);
}

#[test]
fn modules_side_by_side_are_modules_alone() {
    let model = Seeded::new(7, &[12, 20, 9, 3], 16, 1.0);
    let encoder = Arc::new(encoder(&model, Vectors::widest()));
    let modules: Vec<_> = (0..15).map(|m| stroke(70 + m, 40, 12)).collect();
    let mut together = Stream::new(encoder.clone(), 15);
    let mut apart: Vec<_> = (0..15).map(|_| Stream::new(encoder.clone(), 1)).collect();
    for t in 0..40 {
        let sample: Vec<f32> = modules
            .iter()
            .flat_map(|m| m[t * 12..][..12].to_vec())
            .collect();
        let found = together.push(&sample, true).unwrap().map(bits);
        let alone: Vec<_> = apart
            .iter_mut()
            .zip(&modules)
            .filter_map(|(s, m)| s.push(&m[t * 12..][..12], true).unwrap().map(bits))
            .flatten()
            .collect();
        assert_eq!(found.unwrap_or_default(), alone, "sample {t}");
    }
}

#[test]
fn plain_vectors_give_the_bits_of_wide_ones() {
    let model = Seeded::thesis(8);
    let window = stroke(8, 100, 45);
    let of = |vectors| one_by_one(&encoder(&model, vectors), &window);
    let plain = of(Vectors::plain());
    println!("widest: {}", Vectors::widest().name());
    assert_eq!(plain, of(Vectors::widest()));
    assert_eq!(plain, of(Vectors::of_256_bits()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Any shape: in flight as alone, wide as plain, near f64, whatever is asked for.
    #[test]
    fn any_shape_agrees(
        seed in 0u64..1000,
        features in 1usize..20,
        units in proptest::collection::vec(1usize..28, 1..4),
        window in 1usize..14,
        asked in proptest::collection::vec(any::<bool>(), 30),
    ) {
        let sizes: Vec<usize> = std::iter::once(features).chain(units).collect();
        let model = Seeded::new(seed, &sizes, window, 2.0);
        let encoder = Arc::new(encoder(&model, Vectors::widest()));
        let [plain, middle] =
            [Vectors::plain(), Vectors::of_256_bits()].map(|v| self::encoder(&model, v));
        let values = stroke(seed, 30, features);
        let expected = one_by_one(&encoder, &values);
        prop_assert_eq!(&expected, &one_by_one(&plain, &values));
        prop_assert_eq!(&expected, &one_by_one(&middle, &values));
        let mut stream = Stream::new(encoder, 1);
        for (n, sample) in values.chunks_exact(features).enumerate() {
            let found = stream.push(sample, asked[n]).unwrap().map(bits);
            let due = (n + 1).checked_sub(window).filter(|&start| asked[start]);
            prop_assert_eq!(found, due.map(|start| expected[start].clone()), "sample {}", n);
        }
        let reference = model.with(|m| reference::encode(m, &values[..window * features]));
        for (z, reference) in expected[0].iter().zip(reference) {
            prop_assert!((f64::from(f32::from_bits(*z)) - reference).abs() <= 1e-5);
        }
    }
}
