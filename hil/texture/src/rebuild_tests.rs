//! Tests of the way back.

use palpate_files::load_textures;

use super::*;
use crate::explore::explore;

/// One layer by the equations, in double precision.
fn layer(layer: &Layer, inputs: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let units = layer.units();
    let row = |weights: &[f32], r: usize, x: &[f64]| -> f64 {
        let own = weights[r * x.len()..][..x.len()].iter();
        own.zip(x).map(|(w, x)| f64::from(*w) * x).sum()
    };
    let logistic = |x: f64| 1.0 / (1.0 + (-x).exp());
    let mut h = vec![0.0; units];
    let step = |x: &Vec<f64>| {
        let from_input =
            |r| row(&layer.weight_ih.values, r, x) + f64::from(layer.bias_ih.values[r]);
        let from_state =
            |r| row(&layer.weight_hh.values, r, &h) + f64::from(layer.bias_hh.values[r]);
        let unit = |u: usize| {
            let reset = logistic(from_input(u) + from_state(u));
            let update = logistic(from_input(units + u) + from_state(units + u));
            let n = 2 * units + u;
            let new = (from_input(n) + reset * from_state(n)).tanh();
            (1.0 - update) * new + update * h[u]
        };
        let next: Vec<f64> = (0..units).map(unit).collect();
        h.clone_from(&next);
        next
    };
    inputs.iter().map(step).collect()
}

fn thesis() -> (TextureModel, TextureDecoder) {
    let model = TextureModel::open("thesis").unwrap();
    let decoder = TextureDecoder::open("thesis", &model).unwrap();
    (model, decoder)
}

#[test]
fn a_window_comes_back_as_the_equations_say() {
    let (model, decoder) = thesis();
    let rebuilder = Rebuilder::new(&model, &decoder).unwrap();
    for z in [[0.1_f32, -0.4, 0.7], [-0.9, 0.2, 0.0]] {
        let repeated = vec![z.map(f64::from).to_vec(); model.window()];
        let states = decoder.layers().iter().fold(repeated, |x, l| layer(l, &x));
        let (weights, biases) = decoder.dense();
        let units = weights.len() / biases.len();
        let found = rebuilder.decode(&z);
        assert_eq!(found.len(), model.window() * model.features());
        for (row, state) in found.chunks_exact(model.features()).zip(&states) {
            for (f, (value, bias)) in row.iter().zip(biases).enumerate() {
                let own = weights[f * units..][..units].iter().zip(state);
                let expected = own.map(|(w, x)| f64::from(*w) * x).sum::<f64>() + f64::from(*bias);
                assert!((f64::from(*value) - expected).abs() < 1e-5);
            }
        }
    }
}

/// The file has the error that training measured, by the framework, over every window of the test recordings.
#[test]
fn the_error_of_the_test_recordings_is_the_one_in_the_file() {
    let (model, decoder) = thesis();
    let rebuilder = Rebuilder::new(&model, &decoder).unwrap();
    let table = load_textures("thesis").unwrap().value;
    let all = explore(&table, 20, 1, |_| ());
    let split = model.split().unwrap();
    let of = |part: Part| -> Vec<&Recording> {
        let own = all
            .iter()
            .filter(|(e, s)| Part::named_in(&split, e, s) == part);
        own.map(|(_, stroke)| stroke).collect()
    };
    let count = Part::ALL.map(|part| of(part).len());
    assert_eq!(count, [64, 4, 12, 80]);
    let found = rebuilder.strokes(&of(Part::Test), 1).unwrap();
    assert_eq!(found.windows, 12 * 101);
    let losses: serde_json::Value = serde_json::from_str(&model.metadata()["losses"]).unwrap();
    let printed = losses["test"].as_f64().unwrap();
    assert!(
        (found.error / printed - 1.0).abs() < 1e-3,
        "{} {printed}",
        found.error
    );
}

#[test]
fn a_model_without_a_decoder_is_refused() {
    let model = TextureModel::open("default").unwrap();
    let refused = TextureDecoder::open("default", &model).unwrap_err();
    let refused = refused.to_string();
    assert!(refused.contains("`thesis`") && refused.contains("an encoder alone"));
}
