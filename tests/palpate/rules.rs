//! What the rules for contact make of real recordings, that frames left out are not missed there, and the iCub's
//! forearm through the same path.

use std::fmt::Write;
use std::path::Path;

use palpate_core::contact::{Compressor, Norm, Scope, Settings};
use palpate_core::skin::{
    Axes, Baseline, BaselinePhase, BaselineSettings, Layout, Module, Scan, ThresholdRule,
};
use palpate_core::units::{Duration, Instant};
use palpate_files::{DRIFT_S, Setup, THRESHOLD_FLOOR, THRESHOLD_SIGMAS, load_bench, load_scene};
use palpate_hil::cli::{ContactsArgs, StaleArg, Threshold};
use palpate_hil::command;
use palpate_live::recording::recorded;
use palpate_run::run;

use crate::recordings::{FINGERS, at_rate, trials};

fn pad() -> Layout {
    Layout::single(Module::grid("pad", 4, 4, 4.7).unwrap()).unwrap()
}

/// Rows of a recording.
fn rows(file: &Path) -> Vec<[[u16; 3]; 16]> {
    let text = std::fs::read_to_string(file).unwrap();
    let row = |line: &str| {
        let counts: Vec<u16> = line
            .split(',')
            .map(|v| v.parse::<f64>().unwrap() as u16)
            .collect();
        std::array::from_fn(|t| std::array::from_fn(|a| counts[3 * t + a]))
    };
    text.lines().skip(1).map(row).collect()
}

fn per_taxel() -> BaselineSettings {
    BaselineSettings {
        threshold: ThresholdRule::PerTaxel {
            sigmas: THRESHOLD_SIGMAS as f32,
            floor: THRESHOLD_FLOOR as f32,
        },
        drift: Some(Duration::from_micros((DRIFT_S * 1e6) as u64)),
        ..BaselineSettings::default()
    }
}

/// Of the fresh frames after the reference: the share with all taxels in contact, the share with none, and the mean
/// number in contact over the last tenth.
fn shares(file: &Path, settings: BaselineSettings) -> [f64; 3] {
    let layout = pad();
    let mut baseline = Baseline::new(&layout, settings).unwrap();
    let mut frame = baseline.frame(&layout);
    let mut scan = Scan::new(&layout);
    let (mut last, mut counts) = (None, Vec::new());
    for (k, row) in rows(file).into_iter().enumerate() {
        let fresh = last != Some(row);
        last = Some(row);
        scan.load(Instant::from_micros(k as u64 * 25_000), &row)
            .unwrap();
        if baseline.phase() != BaselinePhase::Ready {
            baseline.feed(&scan);
            continue;
        }
        baseline.advance(&scan, &mut frame).unwrap();
        if fresh {
            counts.push(frame.contacts().len());
        }
    }
    let n = counts.len() as f64;
    let share = |of: usize| counts.iter().filter(|c| **c == of).count() as f64 / n;
    let tail = &counts[counts.len() * 9 / 10..];
    [
        share(16),
        share(0),
        tail.iter().sum::<usize>() as f64 / tail.len() as f64,
    ]
}

#[test]
fn a_threshold_of_its_own_tells_touch_from_a_board_that_has_drifted() {
    let (mut table, mut sums, mut n) = (String::new(), [[0.0; 3]; 2], 0.0);
    for trial in trials() {
        for finger in FINGERS {
            let file = trial.join(finger);
            let found = [BaselineSettings::default(), per_taxel()].map(|s| shares(&file, s));
            for (sum, found) in sums.iter_mut().zip(&found) {
                sum.iter_mut().zip(found).for_each(|(s, f)| *s += f);
            }
            n += 1.0;
            let name = file
                .strip_prefix(trial.parent().unwrap())
                .unwrap()
                .display();
            let _ = writeln!(
                table,
                "{name}: maximum {:.2?}, per taxel {:.2?}",
                found[0], found[1]
            );
        }
    }
    if n == 0.0 {
        return; // said by `trials`
    }
    let [thesis, own] = sums.map(|sum| sum.map(|v| v / n));
    println!("{table}all, none, last tenth: maximum {thesis:.3?}, per taxel {own:.3?}");
    assert!(thesis[0] > 0.6, "the thesis's rule: {thesis:?}\n{table}");
    assert!(
        own[0] < thesis[0] && own[1] > 2.0 * thesis[1],
        "{own:?} {thesis:?}\n{table}"
    );
}

/// Every recorded frame by the short way and by the long: fresh memory for the frame, nothing known to repeat.
#[test]
fn recorded_frames_that_repeat_are_left_out_exactly() {
    let layout = pad();
    for (case, file) in trials()
        .iter()
        .flat_map(|t| FINGERS.map(|f| t.join(f)))
        .enumerate()
    {
        let settings = Settings {
            clusters: [1, 2, 4, 8][case % 4],
            exponent: 2.0,
            ..Settings::default()
        };
        let mut baseline = Baseline::new(&layout, per_taxel()).unwrap();
        let mut short = Compressor::new(&layout, settings.clone()).unwrap();
        let mut long = Compressor::new(&layout, settings).unwrap();
        let mut frame = baseline.frame(&layout);
        let mut scan = Scan::new(&layout);
        for (k, row) in rows(&file).into_iter().enumerate() {
            scan.load(Instant::from_micros(k as u64 * 25_000), &row)
                .unwrap();
            if baseline.feed(&scan) != BaselinePhase::Ready {
                continue;
            }
            let news = baseline.advance(&scan, &mut frame).unwrap();
            if news || !short.repeat() {
                short.compress(&frame).unwrap();
            }
            let mut anew = baseline.frame(&layout);
            baseline.relative(&scan, &mut anew).unwrap();
            assert_eq!(anew.magnitude(), frame.magnitude());
            assert_eq!(
                long.compress(&anew).unwrap(),
                short.contacts(),
                "{} row {k}",
                file.display()
            );
        }
        assert!(short.work().repeats > 100, "{:?}", short.work());
    }
}

/// 60 taxels at 50 Hz, the left five columns first. The file says 200 x 6 x 10 x 75, but what lies next to each other in it is a row of six
/// taxels, then time, then the ten columns: only so do values change smoothly.
fn forearm(data: &[u8]) -> Vec<Vec<u16>> {
    let header = usize::from(u16::from_le_bytes([data[8], data[9]])) + 10;
    let values: Vec<f32> = data[header..]
        .chunks_exact(4)
        .map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]))
        .collect();
    let slide = &values[..4500];
    let frame = |t: usize| {
        // Row and column of the layout's taxel.
        let taxel = |i: usize| slide[i % 10 * 450 + t * 6 + i / 10].round() as u16;
        (0..60).map(taxel).collect()
    };
    (0..75).map(frame).collect()
}

#[test]
fn a_recorded_forearm_goes_the_same_way() {
    let Some(data) = trials()
        .first()
        .and_then(|t| Some(t.parent()?.parent()?.join("icub_texture/icub_0.npy")))
    else {
        return; // said by `trials`
    };
    let frames = forearm(&std::fs::read(data).unwrap());
    // The slides start in contact: rows at rest stand before them.
    let rest = vec![0; 60];
    let folder = std::env::temp_dir().join(format!("palpate-forearm-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, taxels: std::ops::Range<usize>| {
        let header: Vec<String> = (1..=taxels.len()).map(|t| format!("txl{t}_z")).collect();
        let mut text = header.join(",");
        for row in std::iter::repeat_n(&rest, 11).chain(&frames) {
            let values: Vec<String> = row[taxels.clone()].iter().map(u16::to_string).collect();
            let _ = write!(text, "\n{}", values.join(","));
        }
        let file = folder.join(name);
        std::fs::write(&file, text + "\n").unwrap();
        file
    };
    let file = write("forearm.csv", 0..60);
    command::contacts(&ContactsArgs {
        time: None,
        columns: None,
        topic: None,
        gain: None,
        split_jumps: false,
        force: true,
        file: file.clone(),
        layout: Some("icub-forearm".into()),
        recipe: None,
        kc: 3,
        ki: 10,
        weber: None,
        vectors: false,
        stop_mm: 0.001,
        reference_frames: 10,
        threshold: Threshold::Counts(5.0),
        drift_s: None,
        faulty_deviations: None,
        scope: Scope::Skin,
        weight_exponent: 1.0,
        norm: Norm::L2,
        axes: Axes::Z,
        rate: Some(50.0),
        seed: 1,
        replay_stale: StaleArg::Keep,
        out: Some(folder.clone()),
        json: false,
        quiet: true,
    })
    .unwrap();
    let found = std::fs::read_to_string(folder.join("contacts.csv")).unwrap();
    assert!(found.lines().count() > 75, "{found}");

    let mut scene = load_scene("sphere-along").unwrap();
    scene.value.layout = "icub-forearm".into();
    scene.value.touches.clear();
    scene.value.reference_frames = 10;
    scene.value.compression.kc = 3;
    scene.value.compression.scope = Scope::Skin;
    scene.value.compression.axes = Axes::Z;
    let setup = Setup::join(scene, load_bench("emulated").unwrap()).unwrap();
    let (input, _) = recorded(&[file], &setup.sensor.value, &at_rate(50.0)).unwrap();
    let summary = run(&setup, &input, 1).unwrap().summary;
    assert!(summary.contacts > 75 && summary.stimuli > 0, "{summary:?}");
    let _ = std::fs::remove_dir_all(folder);
}
