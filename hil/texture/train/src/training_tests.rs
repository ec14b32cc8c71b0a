//! A run that was interrupted ends where one ends that was not; a model file holds what its network does.

use super::*;
use crate::model_file::{self, About};
use crate::recordings::{Material, Rating, Recording, Recordings};
use crate::windows::{Scale, Windows};
use palpate_emulators::sensor::surface::spearman;
use palpate_files::TextureModel;
use palpate_tests::reference;

pub fn small() -> (Windows, Split, LabelFacts) {
    let recording = |n: usize| {
        let label = ["rough", "smooth"][n % 2];
        let at = |row: usize, feature: usize| {
            let buzz = if label == "rough" { 40.0 } else { 5.0 };
            let wave = (row as f32 * (0.9 + 0.1 * n as f32) + feature as f32).sin();
            1000.0 + 30.0 * row as f32 * (feature as f32 - 1.0) + buzz * wave
        };
        Recording {
            name: format!("{label}_{n}"),
            label: label.into(),
            values: (0..30)
                .flat_map(|row| (0..4).map(move |f| at(row, f)))
                .collect(),
        }
    };
    let recordings = Recordings {
        columns: ["a", "b", "c", "d"].map(String::from).to_vec(),
        all: (0..12).map(recording).collect(),
    };
    let rating = |(label, roughness): (&str, f32)| Rating {
        label: label.into(),
        trained: true,
        hardness: 3.0,
        roughness,
        friction: roughness,
    };
    let split = Split::new(&recordings, |_| true, [60, 20, 20], 1);
    let scale = Scale::new(&recordings, &split.train);
    let material = |(label, scale): (&str, f64)| Material {
        label: label.into(),
        trained: true,
        stiffness_n_per_mm: 10.0 / scale,
        relief_um: 20.0 * scale,
        friction: 0.5,
    };
    let known = LabelFacts {
        ratings: [("rough", 5.0), ("smooth", 2.0)].map(rating).to_vec(),
        materials: [("rough", 4.0), ("smooth", 1.0)].map(material).to_vec(),
    };
    (
        Windows {
            recordings,
            scale,
            length: 12,
        },
        split,
        known,
    )
}

pub fn settings(epochs: usize) -> Settings {
    Settings {
        seed: 3,
        latent: 3,
        batch: 8,
        rate: 2e-3,
        last_rate: 1e-4,
        warm_up: 1,
        epochs,
        hop: 1,
        share: 3,
        patience: 100,
        align: 0.1,
        heads: 0.0,
        codes: 0.0,
        along: false,
        decode: 1.0,
        whiten: false,
        high_pass: false,
        guided: 0,
        device: Device::Cpu,
    }
}

/// How far, on average, z1 and z2 of the training windows are from where the ratings put them.
fn misses(align: f64) -> [f32; 2] {
    let (windows, split, known) = small();
    let settings = Settings {
        align,
        share: 1,
        ..settings(20)
    };
    let (network, _) = train(&windows, &split, &known, &settings, None, |_| true).unwrap();
    let places = windows.places(&split.train, 1);
    let on = |label: &str| {
        if label == "rough" {
            [0.45, -0.15]
        } else {
            [-0.45, -0.15]
        }
    };
    let targets: Vec<f32> = (places.iter())
        .flat_map(|&place| on(&windows.recording(place).label))
        .collect();
    let z = latents(&network, &windows, &places);
    [0, 1].map(|c| {
        let miss = z
            .iter()
            .zip(targets.chunks_exact(2))
            .map(|(z, t)| (z[c] - t[c]).abs());
        miss.sum::<f32>() / z.len() as f32
    })
}

#[test]
fn alignment_moves_latents_to_where_the_ratings_put_them() {
    let (with, without) = (misses(1.0), misses(0.0));
    for c in 0..2 {
        assert!(with[c] < 0.7 * without[c], "{with:?} {without:?}");
    }
}

fn run(epochs: usize, folder: Option<&Path>, stop_after: usize) -> (Network<Plain>, Progress) {
    let (windows, split, known) = small();
    let go_on = |progress: &Progress| progress.epochs < stop_after;
    train(&windows, &split, &known, &settings(epochs), folder, go_on).unwrap()
}

/// All that tells materials apart, stopped after two of four epochs and not.
#[test]
fn a_training_by_materials_learns_them_and_resumes_with_the_same_bits() {
    let (windows, split, known) = small();
    let settings = Settings {
        align: 0.0,
        heads: 1.0,
        along: true,
        decode: 0.02,
        whiten: true,
        high_pass: true,
        share: 1,
        ..settings(16)
    };
    let name = format!("palpate-train-heads-{}", std::process::id());
    let folder = std::env::temp_dir().join(name);
    std::fs::create_dir_all(&folder).unwrap();
    let run = |folder: Option<&Path>, stop_after: usize| {
        let go_on = |progress: &Progress| progress.epochs < stop_after;
        train(&windows, &split, &known, &settings, folder, go_on).unwrap()
    };
    let (whole, progress) = run(None, 99);
    run(Some(&folder), 5);
    let (resumed, again) = run(Some(&folder), 99);
    std::fs::remove_dir_all(folder).unwrap();
    assert_eq!(progress, again);
    assert_eq!(weights(&whole), weights(&resumed));
    // The network takes plain readings, and says which of two reliefs and stiffnesses it was.
    let found = model_file::drivers(&whole, &windows, &split.train, (&known, true));
    let [roughness, hardness] = [found.roughness, found.hardness].map(Option::unwrap);
    assert_eq!((roughness.coordinate, hardness.coordinate), (0, 2));
    assert_eq!(roughness.learned, Some([20.0, 80.0]));
    assert!(
        roughness.spearman > 0.8 && hardness.spearman > 0.8,
        "{found:?}"
    );
}

/// The aims of two labels are far apart in every coordinate, so each window of a label lands on its side of each.
#[test]
fn a_training_by_codes_parts_labels_in_every_coordinate() {
    let (windows, split, known) = small();
    let settings = Settings {
        align: 0.0,
        codes: 1.0,
        decode: 0.0,
        share: 1,
        ..settings(20)
    };
    let (network, _) = train(&windows, &split, &known, &settings, None, |_| true).unwrap();
    let places = windows.places(&split.test, 1);
    let z = latents(&network, &windows, &places);
    let labels = places.iter().map(|&p| windows.recording(p).label.as_str());
    for (z, label) in z.iter().zip(labels) {
        // Labels are sorted, and the first has the lower corner.
        let side = if label == "rough" { -1.0 } else { 1.0 };
        assert!(z.iter().all(|z| z * side > 0.1), "{label}: {z:?}");
    }
}

fn weights(network: &Network<Plain>) -> Vec<f32> {
    network.encoder[0]
        .weight_ih
        .val()
        .into_data()
        .into_vec()
        .unwrap()
}

#[test]
fn an_interrupted_run_ends_where_an_uninterrupted_one_does() {
    let folder = std::env::temp_dir().join(format!("palpate-train-resume-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (whole, progress) = run(4, None, 99);
    let (_, half) = run(4, Some(&folder), 2);
    assert_eq!(half.epochs, 2);
    let (resumed, again) = run(4, Some(&folder), 99);
    assert_eq!(progress, again);
    assert_eq!(weights(&whole), weights(&resumed));
    assert!(
        progress.validation[3] < progress.validation[0],
        "{progress:?}"
    );

    let (windows, split, known) = small();
    let other = Settings {
        rate: 1e-3,
        ..settings(4)
    };
    let refused = train(&windows, &split, &known, &other, Some(&folder), |_| true);
    assert!(refused.is_err_and(|e| e.to_string().contains("other settings")));
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_guided_latent_vector_goes_with_the_principal_components() {
    let (windows, split, known) = small();
    let places = windows.places(&split.train, 1);
    let guide = Guide::new(&windows, &split.train, 3);
    let wanted = guide.latents::<Plain>(&windows, &places, &Default::default());
    let wanted: Vec<f32> = wanted.into_data().into_vec().unwrap();
    assert!(wanted.iter().all(|w| w.abs() < 1.0) && wanted.iter().any(|w| w.abs() > 0.3));
    let first = |guided| {
        let settings = Settings {
            align: 0.0,
            guided,
            ..settings(10)
        };
        let (network, _) = train(&windows, &split, &known, &settings, None, |_| true).unwrap();
        let z = latents(&network, &windows, &places);
        let pairs = z.iter().zip(wanted.chunks_exact(3));
        let (a, b): (Vec<f64>, Vec<f64>) = pairs
            .map(|(z, w)| (f64::from(z[0]), f64::from(w[0])))
            .unzip();
        spearman(&a, &b)
    };
    assert!(first(10) > 0.9, "{}", first(10));
}

#[test]
fn without_ratings_roughness_is_what_buzzes() {
    let (windows, split, known) = small();
    let network = Network::<Plain>::new(4, 3, 12, 5, &Default::default());
    let drivers =
        |known: &LabelFacts| model_file::drivers(&network, &windows, &split.train, (known, false));
    let (rated, unrated) = (drivers(&known), drivers(&LabelFacts::default()));
    assert!(rated.roughness.is_some_and(|d| d.with == "ratings"));
    assert!(rated.hardness.is_some() && unrated.hardness.is_none());
    let found = unrated.roughness.unwrap();
    assert!(found.with == "buzz" && found.z_lo < found.z_hi);
    // as the definition says: the mean step of each feature by its range
    let places = windows.places(&split.train, 4);
    let buzz: Vec<f64> = places
        .iter()
        .map(|&p| {
            let raw = windows.raw(p);
            (0..44)
                .map(|i| {
                    let span = windows.scale.max[i % 4] - windows.scale.min[i % 4];
                    f64::from((raw[i + 4] - raw[i]).abs() / span) / 44.0
                })
                .sum()
        })
        .collect();
    let z = latents(&network, &windows, &places);
    let z: Vec<f64> = z.iter().map(|z| f64::from(z[found.coordinate])).collect();
    assert!((spearman(&z, &buzz) - found.spearman).abs() < 1e-9);
}

#[test]
fn a_model_file_holds_the_network_and_its_golden_vector() {
    let (windows, split, known) = small();
    let (network, progress) = run(3, None, 99);
    let path = std::env::temp_dir().join(format!(
        "palpate-train-model-{}.safetensors",
        std::process::id()
    ));
    let about = About {
        windows: &windows,
        split: &split,
        settings: &settings(3),
        progress: &progress,
        test_error: Some(0.5),
        latent: model_file::drivers(&network, &windows, &split.train, (&known, false)),
        rate_hz: Some(100.0),
        command: "palpate-train".into(),
        revision: "test".into(),
        precision: palpate_files::Precision::Single,
    };
    model_file::write(&path, &network, &about).unwrap();
    let bytes = std::fs::read(&path).unwrap();

    std::fs::remove_file(&path).unwrap();

    // The reader holds its encoder against the golden vector; the equations in f64 say the same.
    let model = TextureModel::parse("test", &bytes).unwrap();
    assert_eq!(model.feature_names(), windows.recordings.columns);
    assert_eq!((model.window(), model.latents()), (12, 3));
    let golden = windows.places(&split.test, 1)[0];
    let found = latents(&network, &windows, &[golden]).swap_remove(0);
    let expected = model.with(|m| reference::encode(m, windows.raw(golden)));
    assert_eq!(expected.len(), 3);
    for (found, expected) in found.iter().zip(expected) {
        let found = f64::from(*found);
        assert!(
            found.abs() > 1e-4 && (found - expected).abs() < 2e-6,
            "{found} {expected}"
        );
    }
    let latent: serde_json::Value = serde_json::from_str(&model.metadata()["latent"]).unwrap();
    let driver = &latent["roughness"];
    assert!(driver["z_lo"].as_f64() < driver["z_hi"].as_f64());
    // No other coordinate goes with the ratings better.
    let places = windows.places(&split.train, 4);
    let rated: Vec<f64> = places
        .iter()
        .map(|p| {
            if windows.recording(*p).label == "rough" {
                5.0
            } else {
                2.0
            }
        })
        .collect();
    let all = latents(&network, &windows, &places);
    let found = driver["spearman"].as_f64().unwrap();
    for coordinate in 0..3 {
        let z: Vec<f64> = all.iter().map(|z| f64::from(z[coordinate])).collect();
        let here = spearman(&z, &rated);
        assert!(here.abs() <= found.abs() + 1e-9);
        if driver["coordinate"] == coordinate {
            assert!(
                (here - found).abs() < 1e-9 && driver["sign"] == if here < 0.0 { -1 } else { 1 }
            );
        }
    }
}

/// Two epochs, interrupted after the first.
#[cfg(feature = "gpu")]
#[test]
fn training_on_a_card_goes_as_on_the_processor() {
    if !crate::device::tests::has_card() {
        return;
    }
    let (windows, split, known) = small();
    let name = format!("palpate-train-card-{}", std::process::id());
    let folder = std::env::temp_dir().join(name);
    std::fs::create_dir_all(&folder).unwrap();
    let run = |device, folder: Option<&std::path::Path>, more: fn(&Progress) -> bool| {
        let settings = Settings {
            device,
            share: 9,
            ..settings(2)
        };
        train(&windows, &split, &known, &settings, folder, more).map(|(_, progress)| progress)
    };
    run(Device::Gpu, Some(&folder), |_| false).unwrap();
    let other = run(Device::Cpu, Some(&folder), |_| true).unwrap_err();
    assert!(other.to_string().contains("other settings"), "{other}");
    let gpu = run(Device::Gpu, Some(&folder), |_| true).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    let cpu = run(Device::Cpu, None, |_| true).unwrap();
    let errors = |of: &Progress| [of.train.clone(), of.validation.clone()].concat();
    let (cpu, gpu) = (errors(&cpu), errors(&gpu));
    println!("{cpu:?} {gpu:?}");
    assert_eq!((cpu.len(), gpu.len()), (4, 4));
    for (cpu, gpu) in cpu.iter().zip(&gpu) {
        assert!((cpu - gpu).abs() < 1e-4 * cpu, "{cpu} {gpu}");
    }
}

#[test]
fn settings_from_before_there_was_a_choice_are_of_the_processor() {
    let mut told = serde_json::to_value(settings(1)).unwrap();
    assert_eq!(
        told.as_object_mut().unwrap().remove("device").unwrap(),
        "cpu"
    );
    let read: Settings = serde_json::from_value(told).unwrap();
    assert_eq!(read, settings(1));
}
