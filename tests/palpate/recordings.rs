//! Recordings of real sensors through the whole loop, and their contacts against the formulas done over.

use std::path::{Path, PathBuf};

use palpate_core::contact::{Norm, Scope};
use palpate_core::skin::Axes;
use palpate_files::{Setup, Timing, load_bench, load_scene};
use palpate_hil::cli::{ContactsArgs, StaleArg, Threshold};
use palpate_hil::command;
use palpate_live::recording::{Reading, recorded};
use palpate_records::trace::{Event, event};
use palpate_run::{Outcome, run};

pub const FINGERS: [&str; 2] = ["xela_sensor1.csv", "xela_sensor2.csv"];

/// The folder of every trial, in order; none, and said so, where the recordings are not at hand.
pub fn trials() -> Vec<PathBuf> {
    let data = std::env::var_os("PALPATE_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    let Ok(entries) = std::fs::read_dir(data.join("uskin_grasp")) else {
        println!("skipped: no recordings");
        return Vec::new();
    };
    let mut trials: Vec<_> = entries.map(|e| e.unwrap().path()).collect();
    trials.sort();
    assert!(!trials.is_empty(), "{} is empty", data.display());
    trials
}

/// `frequency_hz` of a trial.
fn rate(trial: &Path) -> f64 {
    let text = std::fs::read_to_string(trial.join("meta_data.csv")).unwrap();
    let mut lines = text.lines().map(|l| l.split(','));
    let column = lines.next().unwrap().position(|n| n == "frequency_hz");
    lines
        .next()
        .unwrap()
        .nth(column.unwrap())
        .unwrap()
        .parse()
        .unwrap()
}

/// Rows of our own header that come at this rate, Hz.
pub fn at_rate(hz: f64) -> Reading {
    let timing = Timing {
        rate_hz: Some(hz),
        ..Timing::default()
    };
    Reading {
        timing,
        ..Reading::default()
    }
}

fn replay(trial: &Path, files: &[&str], layout: &str) -> Outcome {
    let mut scene = load_scene("sphere-along").unwrap();
    scene.value.layout = layout.into();
    scene.value.touches.clear();
    let setup = Setup::join(scene, load_bench("emulated").unwrap()).unwrap();
    let paths: Vec<_> = files.iter().map(|f| trial.join(f)).collect();
    let (input, _) = recorded(&paths, &setup.sensor.value, &at_rate(rate(trial))).unwrap();
    run(&setup, &input, 1).unwrap()
}

fn check(outcome: &Outcome, rows: usize, modules: u16, what: &str) {
    let summary = &outcome.summary;
    let events = &outcome.trace.events;
    // 50 reference rows, and the one that makes the threshold.
    assert!(
        summary.frames as usize >= rows - 52,
        "{what}: {} of {rows}",
        summary.frames
    );
    let entries = events.iter().filter(|e| matches!(e, Event::Schedule(_)));
    assert!(entries.count() > 100, "{what}: hardly a schedule");
    assert!(
        summary.stimuli > 0 && summary.energy_mj > Some(0.0),
        "{what}"
    );
    for module in 0..modules {
        let mut found = 0;
        for event in events {
            if let Event::Contact(event::Contact {
                module: m, place, ..
            }) = event
                && *m == module
            {
                assert!(
                    place.x.abs() <= 7_051 && place.y.abs() <= 7_051,
                    "{what}: {place:?}"
                );
                found += 1;
            }
        }
        assert!(found > 50, "{what}: {found} contacts on finger {module}");
    }
    // The sensor refreshed at about 10 Hz under a logger at 40 Hz.
    let taxels = &summary.taxels;
    let refresh = taxels.refresh_hz.expect(what);
    assert!((8.0..12.0).contains(&refresh.median), "{what}: {taxels:?}");
    assert!((7.0..12.0).contains(&refresh.min), "{what}: {taxels:?}");
    assert!((0.6..0.9).contains(&taxels.repeated), "{what}: {taxels:?}");
    assert_eq!(taxels.dead, 0, "{what}");
    // No truth is known of a recording.
    assert_eq!(summary.path_error_mm, None, "{what}");
}

fn rows(trial: &Path, file: &str) -> usize {
    std::fs::read_to_string(trial.join(file))
        .unwrap()
        .lines()
        .count()
        - 1
}

#[test]
fn every_finger_of_every_trial_reaches_the_wires() {
    for trial in trials() {
        for finger in FINGERS {
            let what = format!("{}/{finger}", trial.display());
            let outcome = replay(&trial, &[finger], "uskin-4x4");
            check(&outcome, rows(&trial, finger), 1, &what);
        }
    }
}

#[test]
fn both_fingers_of_every_trial_run_together() {
    for trial in trials() {
        let what = trial.display().to_string();
        let outcome = replay(&trial, &FINGERS, "uskin-4x4-pair");
        check(&outcome, rows(&trial, FINGERS[0]), 2, &what);
    }
}

/// One contact of a frame.
#[derive(Debug)]
struct Place {
    frame: usize,
    x: f64,
    y: f64,
    intensity: f64,
    members: usize,
}

/// (4.2), (4.3), the weighted mean of (4.7) as corrected, and (4.9), in f64 and as one would write them down.
fn by_hand(text: &str, reference_rows: usize, exponent: f64) -> Vec<Place> {
    let frames: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|l| l.split(',').map(|f| f.parse().unwrap()).collect())
        .collect();
    let reference: Vec<f64> = (0..48)
        .map(|c| frames[..reference_rows].iter().map(|f| f[c]).sum::<f64>() / reference_rows as f64)
        .collect();
    let relative = |f: &[f64]| -> Vec<f64> {
        f.iter()
            .zip(&reference)
            .map(|(g, r)| (g - r).abs())
            .collect()
    };
    let threshold = relative(&frames[reference_rows])
        .into_iter()
        .fold(0.0, f64::max);
    let place = |taxel: usize| {
        let (row, column) = ((taxel / 4) as f64, (taxel % 4) as f64);
        (4.7 * (column - 1.5), 4.7 * (1.5 - row))
    };
    let mut contacts = Vec::new();
    for (frame, counts) in frames.iter().enumerate().skip(reference_rows) {
        let d = relative(counts);
        let norm: Vec<f64> = d
            .chunks(3)
            .map(|s| s.iter().map(|v| v * v).sum::<f64>().sqrt())
            .collect();
        let touched: Vec<usize> = (0..16).filter(|&t| norm[t] > threshold).collect();
        if touched.is_empty() {
            continue;
        }
        let (mut sum, mut x, mut y) = (0.0, 0.0, 0.0);
        for &t in &touched {
            let w = norm[t].powf(exponent);
            (sum, x, y) = (sum + w, x + w * place(t).0, y + w * place(t).1);
        }
        let (x, y) = (x / sum, y / sum);
        // Bilinear: every taxel's tent, one pitch wide on either side, at the place.
        let tent = |t: usize| {
            let (tx, ty) = place(t);
            (1.0 - (x - tx).abs() / 4.7).max(0.0) * (1.0 - (y - ty).abs() / 4.7).max(0.0)
        };
        contacts.push(Place {
            frame,
            x,
            y,
            intensity: (0..16).map(|t| tent(t) * norm[t]).sum(),
            members: touched.len(),
        });
    }
    contacts
}

#[test]
fn contacts_of_a_recording_are_those_of_the_formulas() {
    let folder = std::env::temp_dir().join(format!("palpate-by-hand-{}", std::process::id()));
    for (trial, finger, exponent) in trials()
        .iter()
        .flat_map(|t| FINGERS.map(|f| (t.clone(), f)))
        .zip([1.0, 2.0].into_iter().cycle())
        .map(|((t, f), e)| (t, f, e))
    {
        let file = trial.join(finger);
        let what = file.display().to_string();
        command::contacts(&ContactsArgs {
            time: None,
            columns: None,
            topic: None,
            gain: None,
            split_jumps: false,
            force: true,
            file: file.clone(),
            layout: Some("uskin-4x4".into()),
            recipe: None,
            kc: 1,
            ki: 10,
            weber: None,
            vectors: false,
            stop_mm: 0.001,
            reference_frames: 10,
            threshold: Threshold::Auto,
            drift_s: None,
            faulty_deviations: None,
            scope: Scope::Module,
            weight_exponent: exponent,
            norm: Norm::L2,
            axes: Axes::XYZ,
            rate: Some(rate(&trial)),
            seed: 1,
            replay_stale: StaleArg::Keep,
            out: Some(folder.clone()),
            json: false,
            quiet: true,
        })
        .unwrap();
        let found = std::fs::read_to_string(folder.join("contacts.csv")).unwrap();
        let expected = by_hand(&std::fs::read_to_string(&file).unwrap(), 10, exponent);
        assert!(!expected.is_empty(), "{what}");
        assert_eq!(found.lines().count() - 1, expected.len(), "{what}");
        for (line, expected) in found.lines().skip(1).zip(&expected) {
            let f: Vec<f64> = line.split(',').map(|f| f.parse().unwrap()).collect();
            let near = |a: f64, b: f64, by: f64| (a - b).abs() <= by;
            let agrees = f[0] as usize == expected.frame
                && near(
                    f[1],
                    (expected.frame as f64 * 1e6 / rate(&trial)).round(),
                    0.5,
                )
                && near(f[4], expected.x, 1e-3)
                && near(f[5], expected.y, 1e-3)
                && near(f[6], expected.intensity, 1e-3 + 1e-5 * expected.intensity)
                && f[8] as usize == expected.members;
            assert!(agrees, "{what}: {line}, by hand {expected:?}");
        }
    }
    let _ = std::fs::remove_dir_all(folder);
}
