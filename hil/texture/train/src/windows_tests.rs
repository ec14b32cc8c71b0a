//! Recordings are split as a whole, windows scaled by feature.

use super::*;

fn recordings() -> Recordings {
    let recording = |n: usize| Recording {
        name: format!("r{n}"),
        label: format!("label{}", n % 3),
        values: (0..300).map(|i| ((i * 7 + n * 13) % 101) as f32).collect(),
    };
    Recordings {
        columns: vec!["a".into(), "b".into(), "c".into()],
        all: (0..60).map(recording).collect(),
    }
}

#[test]
fn whole_labels_are_held_out_and_none_is_in_two_parts() {
    let mut recordings = recordings();
    for (n, recording) in recordings.all.iter_mut().enumerate() {
        recording.label = format!("label{}", n / 3);
    }
    let split = Split::by_label(&recordings, |label| label != "label2", [60, 20, 20], 3);
    let parts = [&split.train, &split.test, &split.validation, &split.unseen];
    assert_eq!(parts.iter().map(|p| p.len()).sum::<usize>(), 60);
    assert_eq!(split.unseen, [6, 7, 8]);
    for part in parts {
        assert!(!part.is_empty());
        for three in part.chunks(3) {
            assert!(three.iter().all(|r| r / 3 == three[0] / 3), "{part:?}");
        }
    }
}

#[test]
fn no_recording_is_in_two_parts_and_every_label_in_each() {
    let recordings = recordings();
    let split = Split::new(&recordings, |label| label != "label2", [80, 15, 5], 3);
    let parts = [&split.train, &split.test, &split.validation, &split.unseen];
    let mut all: Vec<usize> = parts.into_iter().flatten().copied().collect();
    all.sort_unstable();
    assert_eq!(all, (0..60).collect::<Vec<_>>());
    assert_eq!(parts.map(|p| p.len()), [32, 6, 2, 20]);
    for part in &parts[..3] {
        for label in ["label0", "label1"] {
            assert!(part.iter().any(|&r| recordings.all[r].label == label));
        }
        assert!(part.iter().all(|&r| recordings.all[r].label != "label2"));
    }
    assert_eq!(
        split,
        Split::new(&recordings, |label| label != "label2", [80, 15, 5], 3)
    );
    assert_ne!(
        split,
        Split::new(&recordings, |label| label != "label2", [80, 15, 5], 4)
    );
}

#[test]
fn windows_are_scaled_by_feature_and_begin_at_zero() {
    let recordings = recordings();
    let part = [4, 7];
    let scale = Scale::new(&recordings, &part);
    let windows = Windows {
        recordings,
        scale,
        length: 10,
    };
    assert_eq!(windows.places(&part, 1).len(), 2 * 91);
    assert_eq!(windows.places(&part, 9).len(), 2 * 11);
    let places = windows.places(&part, 30);
    let batch = windows.batch::<burn::backend::NdArray>(&places, &Default::default());
    let [steps, count, features] = batch.dims();
    assert_eq!([steps, count, features], [10, 8, 3]);
    let values: Vec<f32> = batch.into_data().into_vec().unwrap();
    assert!(
        values[..count * features].iter().all(|&v| v == 0.0),
        "the first sample is the offset"
    );
    assert!(values.iter().all(|v| (-1.0..=1.0).contains(v)));
    let (place, step, feature) = (5, 8, 2);
    let at = |row: usize| f64::from(windows.raw(places[place])[row * 3 + feature]);
    let span = f64::from(windows.scale.max[feature] - windows.scale.min[feature]);
    let expected = (at(step) - at(0)) / span;
    assert!((f64::from(values[(step * count + place) * 3 + feature]) - expected).abs() < 1e-6);
}

#[test]
fn a_feature_that_never_changes_is_zero() {
    let all = vec![Recording {
        name: "r".into(),
        label: "l".into(),
        values: vec![5.0; 40],
    }];
    let recordings = Recordings {
        columns: vec!["a".into(), "b".into()],
        all,
    };
    let scale = Scale::new(&recordings, &[0]);
    let windows = Windows {
        recordings,
        scale,
        length: 20,
    };
    let batch =
        windows.batch::<burn::backend::NdArray>(&windows.places(&[0], 1), &Default::default());
    assert!(
        batch
            .into_data()
            .into_vec::<f32>()
            .unwrap()
            .iter()
            .all(|&v| v == 0.0)
    );
}
