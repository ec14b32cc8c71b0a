//! Touches in time.

use super::super::*;

fn touch(scene: &str, index: usize) -> Touch {
    load_scene(scene).unwrap().value.touches[index].clone()
}

#[test]
fn a_line_goes_there_and_back() {
    let touch = touch("sphere-along", 0);
    for (t, y) in [
        (0.8, -7.05),
        (1.8, 0.0),
        (2.8, 7.05),
        (3.8, 0.0),
        (4.8, -7.05),
    ] {
        let at = touch.at(t).unwrap();
        assert!(
            at.x_mm.abs() < 1e-12 && (at.y_mm - y).abs() < 1e-9,
            "{t}: {at:?}"
        );
    }
}

#[test]
fn a_circle_turns_anticlockwise_from_the_right() {
    let touch = touch("sphere-circle", 0);
    let start = touch.at(0.8).unwrap();
    let quarter = touch.at(0.8 + 4.6 / 4.0).unwrap();
    assert!((start.x_mm - 7.05).abs() < 1e-9 && start.y_mm.abs() < 1e-9);
    assert!(quarter.x_mm.abs() < 1e-9 && (quarter.y_mm - 7.05).abs() < 1e-9);
}

#[test]
fn corners_are_passed_at_constant_speed_and_ends_are_reached() {
    let touch = touch("two-finger-press", 1);
    let speed = |t: f64| {
        let (a, b) = (touch.at(t).unwrap(), touch.at(t + 1e-6).unwrap());
        (b.x_mm - a.x_mm).hypot(b.y_mm - a.y_mm)
    };
    assert!((speed(1.5) - speed(4.5)).abs() < 1e-9);
    let end = touch.at(4.8).unwrap();
    assert!((end.x_mm - 2.35).abs() < 1e-9 && (end.y_mm + 4.7).abs() < 1e-9);
}

#[test]
fn force_rises_from_zero_without_a_jump_and_nothing_is_felt_outside() {
    for scene in FileKind::Scene.names() {
        let touches = load_scene(scene).unwrap().value.touches.into_iter();
        // A hand lets go when it wants.
        for touch in touches.filter(|touch| touch.path.kind != PathKind::Hand) {
            assert_eq!(touch.at(touch.start_s - 1e-9), None);
            assert_eq!(touch.at(touch.end_s + 1e-9), None);
            assert!(touch.at(touch.start_s).unwrap().force_n.abs() < 1e-12);
            assert!(touch.at(touch.end_s).unwrap().force_n.abs() < 1e-12);
            let mut before = touch.at(touch.start_s).unwrap();
            let steps = ((touch.end_s - touch.start_s) * 1000.0) as u32;
            for step in 1..steps {
                let now = touch.at(touch.start_s + f64::from(step) / 1000.0).unwrap();
                assert!(now.force_n >= 0.0 && (now.force_n - before.force_n).abs() < 0.05);
                assert!((now.x_mm - before.x_mm).hypot(now.y_mm - before.y_mm) < 0.05);
                before = now;
            }
        }
    }
}

/// A scene with one touch by hand.
fn by_hand(samples: &str, more: &str) -> Result<Scene, FileError> {
    let text = format!(
        "name = \"mine\"\ndescription = \"A hand\"\nlength_s = 2.0\n[[touches]]\nstart_s = 0.6\n{more}path = {{ kind = \"hand\", samples = {samples} }}\n"
    );
    Scene::read(&Source::new("f.toml", text))
}

#[test]
fn a_hand_is_as_its_last_sample_says() {
    let samples = "[[600000, 1000, -2000, 500, 8000], [616667, 1500, -2000, 900, 8000], [1000000, 0, 0, 0, 8000]]";
    let scene = by_hand(samples, "").unwrap();
    let at = |us: f64| scene.touches[0].at(us * 1e-6);
    assert_eq!(at(599_999.0), None);
    for (us, x, force) in [
        (600_000.0, 1.0, 0.5),
        (616_666.0, 1.0, 0.5),
        (616_667.0, 1.5, 0.9),
        (999_999.0, 1.5, 0.9),
    ] {
        let point = at(us).unwrap();
        assert!(
            (point.x_mm - x).abs() < 1e-12 && (point.force_n - force).abs() < 1e-12,
            "{us}: {point:?}"
        );
        assert!((point.y_mm + 2.0).abs() < 1e-12 && (point.diameter_mm - 8.0).abs() < 1e-12);
    }
    assert_eq!(at(1_000_000.0), None, "lifted");
}

#[test]
fn what_no_hand_did_is_told_by_its_place() {
    for (samples, more, expected) in [
        (
            "[]",
            "",
            "touches[0].path.samples: expected 1 to 216000 samples",
        ),
        ("[[600000, 0, 0, 500]]", "", "touches[0].path.samples[0]"),
        (
            "[[600000, 0, 0, 500, 8000], [600000, 1, 0, 500, 8000]]",
            "",
            "touches[0].path.samples[1][0]: expected t_us: a time from 600001 us",
        ),
        (
            "[[2000001, 0, 0, 500, 8000]]",
            "",
            "to the end of the scene, found 2000001",
        ),
        (
            "[[600000, 0, 9000000, 500, 8000]]",
            "",
            "touches[0].path.samples[0][2]: expected y_um",
        ),
        (
            "[[600000, 0, 0, -1, 8000]]",
            "",
            "force_mn: a number from 0 to 20000, found -1",
        ),
        (
            "[[600000, 0, 0, 500, 8000]]",
            "diameter_mm = 3.0\n",
            "touches[0].diameter_mm: expected nothing: the samples of a hand say it",
        ),
        (
            "[[600000, 0, 0, 500, 8000]]",
            "force_n = { mean = 1.0 }\n",
            "touches[0].force_n: expected nothing",
        ),
    ] {
        let error = by_hand(samples, more).unwrap_err().to_string();
        assert!(error.contains(expected), "{samples}: {error}");
    }
    let line = "name = \"mine\"\ndescription = \"No hand\"\n[[touches]]\nstart_s = 0.6\nforce_n = { mean = 1.0 }\npath = { kind = \"hold\", points_mm = [[0, 0]], samples = [[600000, 0, 0, 1, 8000]] }\n";
    let error = Scene::read(&Source::new("f.toml", line))
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("touches[0].path.samples: expected this key for a hand only"),
        "{error}"
    );
    let error = Scene::read(&Source::new(
        "f.toml",
        line.replace("force_n = { mean = 1.0 }\n", "")
            .replace(", samples = [[600000, 0, 0, 1, 8000]]", ""),
    ))
    .unwrap_err()
    .to_string();
    assert!(
        error.contains("touches[0].force_n: expected a force"),
        "{error}"
    );
}

#[test]
fn a_saved_scene_reads_as_what_was_played() {
    let mut changes = Overrides::default();
    changes.set("test", "compression.kc=2").unwrap();
    let scene = load_scene("sphere-along").unwrap().with(&changes).unwrap();
    let mut touch = Touch::by_hand(0, [700_000, 1000, 2000, 300, 9000]);
    touch.end_s = 12.5;
    let text = scene.saved(12.5, core::slice::from_ref(&touch)).unwrap();
    let read = Scene::read(&Source::new("saved.toml", text)).unwrap();
    assert_eq!(
        (read.name.as_str(), read.compression.kc, read.length_s),
        ("sphere-along-touched", 2, 12.5)
    );
    assert_eq!(read.compression.levels, LevelsFrom::Dynamic);
    assert_eq!(read.touches[0], scene.value.touches[0]);
    assert_eq!(read.touches[1], touch);
}
