//! Values in place of a file's own are checked like the file's.

use palpate_core::illusion::{Distances, IllusionModel};

use super::super::*;
use super::bad_toml::{BENCH, SCENE};

fn setup(changes: &[&str]) -> Result<Setup, FileError> {
    let scene = Source::new("s.toml", SCENE);
    let bench = Source::new("b.toml", BENCH);
    let scene = Loaded {
        value: Scene::read(&scene)?,
        source: scene,
    };
    let bench = Loaded {
        value: Bench::read(&bench)?,
        source: bench,
    };
    let mut overrides = Overrides::default();
    for change in changes {
        overrides.set("--set", change)?;
    }
    Setup::join(scene, bench)?.with(&overrides)
}

#[test]
fn any_key_of_scene_and_bench_can_change() {
    let plain = setup(&[]).unwrap();
    let same = setup(&["illusion.model=balanced", "illusion.alpha=0.0"]).unwrap();
    assert_eq!(same.scene.value, plain.scene.value);
    let changed = setup(&[
        "layout = uskin-4x6",
        "compression.iterations=2",
        "touches[0].force_n.mean=0.5",
        "illusion.weber=0.1",
        "touches[0].path.points_mm=[[1.0, 2.0], [3, 4]]",
        "bench.drive.current_ma=900",
        "bench.outputs[7].channel=9",
    ])
    .unwrap();
    let scene = &changed.scene.value;
    assert_eq!(changed.sensor.value.name, "uskin-4x6");
    assert_eq!(scene.compression.iterations, 2);
    assert_eq!(scene.illusion.weber, Some(0.1));
    assert!((scene.touches[0].force_n.mean - 0.5).abs() < 1e-12);
    assert_eq!(scene.touches[0].path.points_mm, [[1.0, 2.0], [3.0, 4.0]]);
    assert!((changed.bench.value.drive.current_ma - 900.0).abs() < 1e-12);
    assert_eq!(changed.bench.value.outputs[7].channel, 9);
    assert!(
        setup(&["touches=[]"])
            .unwrap()
            .scene
            .value
            .touches
            .is_empty()
    );
}

#[test]
fn another_model_drops_the_shape_that_was_meant_for_the_files_own() {
    let phantom = setup(&["illusion.model=phantom"]).unwrap().scene.value;
    assert_eq!(phantom.illusion.model, IllusionModel::Phantom);
    assert_eq!(phantom.illusion.shape, None);
    let both = setup(&["illusion.shape=2.0", "illusion.model=phantom"]).unwrap();
    assert_eq!(both.scene.value.illusion.shape, Some(2.0));
    let far = setup(&["illusion.model=phantom", "illusion.distances=space"]).unwrap();
    assert_eq!(far.scene.value.illusion.distances, Some(Distances::Space));
}

#[test]
fn what_cannot_be_names_the_option_and_the_key() {
    for (change, message) in [
        (
            "illusion.alpha=1.5",
            "--set: illusion.alpha: expected a number from 0 to 1, found 1.5",
        ),
        (
            "illusion.alpha=nan",
            "--set: illusion.alpha: expected a finite number, found nan",
        ),
        (
            "illusion.alfa=0.1",
            "--set: illusion.alfa: expected one of the keys `model`, `shape`, ",
        ),
        (
            "touches[3].start_s=1",
            "--set: touches[3].start_s: expected a key that the file can have, found 1",
        ),
        (
            "layout=nowhere",
            "--set: layout: expected a layout (allegro, digit, ",
        ),
        (
            "layout=thimble-8",
            "--set: layout: expected a layout of kind \"sensor\", found the display `thimble-8`",
        ),
        (
            "illusion.tau_d_ms=80",
            "--set: illusion.tau_d_ms: expected at most the time between onsets, 72.9 ms, found 80",
        ),
        (
            "illusion.intensity=maybe",
            "--set: illusion.intensity: expected true or false, found maybe",
        ),
        (
            "length_s=9",
            "s.toml:34: touches[0].end_s: expected a number from 0 to 9 s (the scene's length), found 10.0",
        ),
        (
            "length_s=9\nrate_hz=1",
            "--set: length_s: expected a number, found 9\nrate_hz=1",
        ),
        (
            "bench.drive.current_ma=9000",
            "--set: drive.current_ma: expected a number from 1 to 5000 mA, found 9000",
        ),
        ("length_s", "--set: expected KEY=VALUE, found `length_s`"),
        ("=3", "--set: expected KEY=VALUE, found `=3`"),
    ] {
        let said = setup(&[change]).expect_err(change).to_string();
        assert!(said.starts_with(message), "{change}: {said}");
    }
}
