//! Every shipped file reads, and says what the documents say.

use palpate_core::guard::HARD;

use super::super::*;

#[test]
fn every_shipped_file_reads_and_is_named_after_its_file() {
    for name in FileKind::Scene.names() {
        assert_eq!(load_scene(name).unwrap().value.name, name);
    }
    for name in FileKind::Bench.names() {
        assert_eq!(load_bench(name).unwrap().value.name, name);
    }
    for name in FileKind::Activation.names() {
        assert_eq!(load_activation(name).unwrap().value.name, name);
    }
    for name in FileKind::Limits.names() {
        assert_eq!(Loaded::<LimitTable>::named(name).unwrap().value.name, name);
    }
    for name in FileKind::Layout.names() {
        let layout = match load_layout(name).unwrap().value {
            LayoutFile::Sensor(layout) => layout.name,
            LayoutFile::Display(layout) => layout.name,
        };
        assert_eq!(layout, name);
    }
}

#[test]
fn every_scene_fits_every_bench_of_one_display() {
    for scene in FileKind::Scene.names() {
        for bench in FileKind::Bench.names() {
            let there = load_bench(bench).unwrap().value;
            let Loaded {
                value: alone,
                source,
            } = load_scene(scene).unwrap();
            if alone.misses(&there).is_some() || !there.displays.is_empty() {
                continue;
            }
            let on_wires = |fault: &Fault| fault.kind.is_of_display() && !fault.kind.is_of_i2c();
            let of_wires = alone.texture.is_some()
                || alone.faults.iter().any(on_wires)
                || source.text().contains("inverse");
            let fits = Setup::load(scene, bench);
            assert_eq!(
                fits.is_err(),
                there.haptics.is_some() && of_wires,
                "{scene} {bench}"
            );
        }
    }
}

#[test]
fn the_default_limit_table_is_the_hard_one() {
    assert_eq!(
        Loaded::<LimitTable>::named("default").unwrap().value.limits,
        HARD
    );
    let bare = Source::new("bare.toml", "name = \"bare\"\ndescription = \"d\"\n");
    assert_eq!(LimitTable::read(&bare).unwrap().limits, HARD);
}

fn sensor(name: &str) -> SensorLayout {
    match load_layout(name).unwrap().value {
        LayoutFile::Sensor(layout) => layout,
        LayoutFile::Display(_) => panic!("{name} is a display"),
    }
}

#[test]
fn row_zero_column_zero_is_top_left() {
    let taxels = sensor("uskin-4x4").modules[0].taxels();
    assert_eq!(taxels.len(), 16);
    for (taxel, x, y) in [(0, -7.05, 7.05), (3, 7.05, 7.05), (15, 7.05, -7.05)] {
        assert!((taxels[taxel].x_mm - x).abs() < 1e-12);
        assert!((taxels[taxel].y_mm - y).abs() < 1e-12);
    }
}

#[test]
fn the_pitch_is_the_way_to_the_nearest_other_taxel() {
    let pitch = |name: &str| sensor(name).modules[0].pitch_mm();
    assert_eq!(pitch("uskin-4x4"), Some(4.7));
    let scattered = sensor("scattered-12");
    let taxels = scattered.modules[0].taxels();
    let others = |i: usize| taxels.iter().enumerate().filter(move |(j, _)| *j != i);
    let mut nearest = f64::INFINITY;
    for (i, one) in taxels.iter().enumerate() {
        for (_, other) in others(i) {
            nearest = nearest.min((one.x_mm - other.x_mm).hypot(one.y_mm - other.y_mm));
        }
    }
    assert_eq!(pitch("scattered-12"), Some(nearest));
    let mut single = scattered.modules[0].clone();
    single.points_mm = Some(vec![[0.0, 0.0]]);
    assert_eq!(single.pitch_mm(), None);
}

#[test]
fn a_hand_reads_240_taxels_and_leaves_the_thumbs_fourth_module_blank() {
    let hand = sensor("allegro");
    assert_eq!((hand.modules.len(), hand.readings()), (15, 240));
    assert_eq!(
        hand.modules.iter().map(|m| m.taxels().len()).sum::<usize>(),
        272
    );
    let mut cells = [[false; 16]; 16];
    for taxel in hand.modules.iter().flat_map(SkinModule::taxels) {
        assert_eq!(taxel.active, taxel.image.is_some());
        if let Some((row, column)) = taxel.image {
            cells[row][column] = true;
        }
    }
    for (row, line) in cells.iter().enumerate() {
        for (column, covered) in line.iter().enumerate() {
            assert_eq!(*covered, row < 12 || column < 12, "{row}, {column}");
        }
    }
}

#[test]
fn onsets_follow_the_stimulus_length() {
    let illusion = load_scene("sphere-along").unwrap().value.illusion;
    assert!((illusion.onset_ms() - 58.5).abs() < 1e-9);
}

#[test]
fn a_file_states_only_what_differs_from_the_default() {
    let bare = Source::new("bare.toml", "name = \"bare\"\ndescription = \"d\"\n");
    let (name, description) = ("bare".to_owned(), "d".to_owned());
    let scene = Scene::read(&bare).unwrap();
    let stated = Scene {
        name: name.clone(),
        description: description.clone(),
        ..Scene::default()
    };
    assert_eq!(scene, stated);
    let bench = Bench::read(&bare).unwrap();
    assert_eq!(bench.outputs, load_bench("emulated").unwrap().value.outputs);
    let stated = Bench {
        name,
        description,
        outputs: bench.outputs.clone(),
        ..Bench::default()
    };
    assert_eq!(bench, stated);
    let touched = "name = \"t\"\ndescription = \"d\"\nlength_s = 3.0\n[[touches]]\nstart_s = 1.0\n\
        path = { kind = \"circle\", radius_mm = 2.0 }\nforce_n = { mean = 0.5 }\n";
    let scene = Scene::read(&Source::new("t.toml", touched)).unwrap();
    let touch = &scene.touches[0];
    assert!((touch.end_s - 3.0).abs() < 1e-12 && (touch.ramp_s - 0.2).abs() < 1e-12);
    let start = touch.at(1.0).unwrap();
    assert!((start.x_mm - 2.0).abs() < 1e-12 && start.y_mm.abs() < 1e-12);
}

#[test]
fn unknown_names_list_what_exists() {
    assert_eq!(
        load_bench("no-bench").unwrap_err().to_string(),
        "no-bench: expected a bench (allegro-hand, emulated, lra-8, lra-grid-4x3, set-current, ten-fingers, thesis, three-in-line, unit, unit-whole, voice-coil-8, warm) or a file, found neither of that name"
    );
}

#[test]
fn files_are_found_beside_the_file_that_names_them() {
    let folder = std::env::temp_dir().join(format!("palpate-files-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: String| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path.to_string_lossy().into_owned()
    };
    write(
        "strict.toml",
        "name = \"strict\"\ndescription = \"d\"\n[pulse]\nwidth_us = 100\n".into(),
    );
    let bench = super::bad_toml::BENCH;
    let good = write("good.toml", bench.replace("\"default\"", "\"strict.toml\""));
    let lost = write("lost.toml", bench.replace("\"default\"", "\"gone.toml\""));
    let setup = Setup::load("idle", &good).unwrap();
    assert_eq!(setup.limits.value.limits.pulse_width_ns, 100_000);
    assert_eq!(
        Setup::load("idle", &lost).unwrap_err().to_string(),
        format!(
            "{lost}:6: limits: expected a limit table (default) or a file, found \"gone.toml\", and no such file"
        )
    );
    let binary = folder.join("binary.toml");
    std::fs::write(&binary, b"name = \"x\"\n\xFF\n").unwrap();
    let binary = binary.to_string_lossy().into_owned();
    assert_eq!(
        load_scene(&binary).unwrap_err().to_string(),
        format!("{binary}:2: expected UTF-8 text, found byte 0xFF")
    );
    let whole = folder.to_string_lossy().into_owned();
    let error = load_scene(&whole).unwrap_err();
    assert_eq!((error.path.as_str(), error.line), (&*whole, None));
    assert_eq!(error.expected, "a settings file (TOML)");
    let empty = write("empty.toml", "\n".into());
    assert_eq!(
        load_scene(&empty).unwrap_err().to_string(),
        format!("{empty}: expected a TOML file, found an empty file")
    );
    std::fs::remove_dir_all(&folder).unwrap();
}
