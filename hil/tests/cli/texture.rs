//! `hil texture`: models that are refused, recordings that are refused, latent vectors and the way out.

use palpate_tests::seeded::{Seeded, stroke};

use super::*;

/// A folder with a small model and a recording for it, and their paths.
pub fn ground(name: &str) -> (Folder, String, String) {
    let folder = Folder::new(name);
    let model = folder.path("model.safetensors");
    fs::write(&model, Seeded::new(3, &[5, 8, 3], 20, 1.0).file().unwrap()).unwrap();
    let mut text = String::from("time_us,a,b,c,d,e\n");
    for (n, row) in stroke(4, 60, 5).chunks_exact(5).enumerate() {
        let fields: Vec<_> = row.iter().map(f32::to_string).collect();
        text.push_str(&format!("{},{}\n", n * 10_000, fields.join(",")));
    }
    let rows = folder.write("rows.csv", &text);
    let text = |path: &Path| path.display().to_string();
    let (model, rows) = (text(&model), text(&rows));
    (folder, model, rows)
}

#[test]
fn every_window_has_a_line_named_by_its_last_row() {
    let (_folder, model, rows) = ground("texture-encode");
    let every = good(&["texture", "encode", &model, &rows]);
    let lines: Vec<&str> = every.lines().collect();
    assert_eq!(lines[0], "frame,z1,z2,z3");
    assert_eq!(lines.len(), 1 + 41);
    assert!(lines[1].starts_with("19,") && lines[41].starts_with("59,"));
    let asked = good(&[
        "texture", "encode", &model, &rows, "--soa-ms", "58.5", "--rate", "100",
    ]);
    let asked: Vec<&str> = asked.lines().collect();
    assert_eq!(asked.len(), 1 + 7);
    assert!(asked.iter().all(|line| lines.contains(line)));
    let json = good(&["texture", "encode", &model, &rows, "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json[0]["frame"], 19);
    assert_eq!(json[0]["z"].as_array().unwrap().len(), 3);
}

#[test]
fn what_cannot_be_encoded_is_refused_with_its_place() {
    let (folder, model, rows) = ground("texture-refused");
    let text = folder.text("rows.csv");
    let spoiled = folder.write(
        "nan.csv",
        &text
            .replacen("\n10000,", "\n10000,nan,", 1)
            .replace(",nan,,", ",nan,"),
    );
    let spoiled = spoiled.display().to_string();
    refused_with(
        &["texture", "encode", &model, &spoiled],
        &["nan.csv:3", "column 2"],
    );
    let short: String = text.lines().take(20).map(|l| format!("{l}\n")).collect();
    let short = folder.write("short.csv", &short).display().to_string();
    refused_with(
        &["texture", "encode", &model, &short],
        &["at least 20 rows", "found 19"],
    );
    refused_with(
        &["texture", "encode", "nowhere.safetensors", &rows],
        &["nowhere.safetensors", "model"],
    );
    refused_with(
        &["texture", "encode", &rows, &rows],
        &["rows.csv", "safetensors"],
    );
}

#[test]
fn a_model_that_misses_its_golden_vector_is_refused() {
    let (folder, model, rows) = ground("texture-golden");
    let right = fs::read(&model).unwrap();
    let file = safetensors::SafeTensors::deserialize(&right).unwrap();
    let weights = file.tensor("encoder.0.weight_hh").unwrap().data();
    let at = weights.as_ptr() as usize - right.as_ptr() as usize;
    let mut mixed = right.clone();
    mixed[at..at + 4].copy_from_slice(&0.9f32.to_le_bytes());
    let header = 8 + u64::from_le_bytes(right[..8].try_into().unwrap()) as usize;
    let path = folder.path("mixed.safetensors");
    fs::write(&path, &mixed).unwrap();
    let path = path.display().to_string();
    refused_with(
        &["texture", "encode", &path, &rows],
        &["mixed.safetensors: golden.latent["],
    );
    for length in [0, 7, header / 2, header, right.len() - 1] {
        fs::write(&path, &right[..length]).unwrap();
        refused_with(&["texture", "encode", &path, &rows], &["safetensors"]);
    }
}

#[test]
fn the_export_is_an_onnx_file_with_its_names() {
    let (folder, model, _) = ground("texture-export");
    let out = folder.path("encoder.onnx").display().to_string();
    let said = hil(&["texture", "export", &model, "--out", &out]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert!(said.err.contains("`raw` [20, N, 5]"), "{}", said.err);
    let bytes = fs::read(&out).unwrap();
    for name in ["linear_before_reset", "hidden_size", "GRU", "latent"] {
        let found = bytes.windows(name.len()).any(|w| w == name.as_bytes());
        assert!(found, "no {name}");
    }
}

#[test]
fn strokes_are_recordings_beside_their_ratings() {
    let folder = Folder::new("texture-strokes");
    let out = folder.path("strokes").display().to_string();
    let said = hil(&["texture", "strokes", "--out", &out, "--strokes", "2"]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    let strokes = Folder(folder.path("strokes"));
    let names = strokes.names();
    assert_eq!(names.len(), 8 * 2 + 2, "ratings and materials: {names:?}");
    let table = strokes.text("wood_01.csv");
    let rows: Vec<Vec<u16>> = table
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|v| v.parse().unwrap()).collect())
        .collect();
    assert_eq!((rows.len(), rows[0].len()), (200, 48));
    // the seventh taxel is dead, its neighbours are not
    let changes = |column: usize| rows.iter().any(|row| row[column] != rows[0][column]);
    assert!((18..21).all(|c| !changes(c)) && changes(17) && changes(21));
    let ratings = strokes.text("ratings.csv");
    assert!(ratings.starts_with("label,trained,hardness,roughness,friction\nsponge1,true,"));

    let shaken = Folder::new("texture-strokes-shaken");
    let path = shaken.path("strokes").display().to_string();
    let said = hil(&[
        "texture",
        "strokes",
        "--out",
        &path,
        "--strokes",
        "2",
        "--accelerometer",
    ]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    let accelerometer = Folder(shaken.path("strokes/accelerometer"));
    assert_eq!(accelerometer.names().len(), 8 * 2);
    let rows = accelerometer.text("wood_01.csv");
    assert!(rows.starts_with("x_mg,y_mg,z_mg\n"));
    assert_eq!(rows.lines().count(), 1 + 6000);

    let again = Folder::new("texture-strokes-again");
    let (other, same) = (again.path("other"), again.path("same"));
    for (path, seed) in [(&other, "2"), (&same, "1")] {
        let path = path.display().to_string();
        hil(&[
            "texture",
            "strokes",
            "--out",
            &path,
            "--strokes",
            "2",
            "--seed",
            seed,
        ]);
    }
    let read = |path: &Path| fs::read_to_string(path.join("wood_01.csv")).unwrap();
    assert!(read(&same) == table && read(&other) != table);

    refused_with(
        &["texture", "strokes", "--out", &out, "--strokes", "0"],
        &["--strokes", "1"],
    );
    let twice = folder.write(
        "twice.toml",
        &include_str!("../../../fixtures/textures/thesis.toml")
            .replace("name = \"towel\"", "name = \"sponge1\""),
    );
    let twice = twice.display().to_string();
    refused_with(
        &["texture", "strokes", "--out", &out, "--textures", &twice],
        &["twice.toml:", "texture[1].name", "no other texture"],
    );
    let file = folder.write("taken", "").display().to_string();
    let said = hil(&["texture", "strokes", "--out", &file, "--strokes", "1"]);
    assert_eq!(said.status, Some(2));
    assert!(said.err.contains("taken"), "{}", said.err);
}

#[test]
fn the_map_of_the_default_model_has_every_texture() {
    let folder = Folder::new("texture-map");
    let svg = folder.path("map.svg").display().to_string();
    let table = good(&["texture", "map", "--strokes", "1", "--svg", &svg]);
    assert!(table.contains("rank correlation"));
    // It learned materials, none of these.
    assert!(
        table.starts_with("x: z1 (roughness), y: z3 (hardness)\n"),
        "{table}"
    );
    assert_eq!(table.matches("  unseen\n").count(), 8 + 1, "{table}");
    let drawing = folder.text("map.svg");
    for name in ["sponge1", "cardboard", "sponge2", "shoe-sole"] {
        assert!(table.contains(name) && drawing.contains(&format!(">{name}<")));
    }
    let rows = |from: &str| table.split(from).nth(1).unwrap().lines().skip(1);
    assert_eq!(rows("emulated").take_while(|l| !l.is_empty()).count(), 8);
    assert!(table.ends_with("\n\ncatalogue: EXTRAPOLATED: relief 4 um (learned 5 to 349.41)\n"));
    for row in rows("rank correlation").take_while(|l| !l.is_empty()) {
        let figures: Vec<f64> = row[38..]
            .split_whitespace()
            .map(|f| f.parse().unwrap())
            .collect();
        assert!(
            figures.len() == 2 && figures.iter().all(|f| f.abs() <= 1.0),
            "{row}"
        );
    }
    let (_folder, model, _) = ground("texture-map-other");
    refused_with(&["texture", "map", &model], &["txl1_x to txl16_z"]);
}

/// `hil` in a folder of its own, beside what a test puts there, with nothing on the PATH.
#[cfg(unix)]
#[test]
fn training_is_the_training_programs_or_says_how_to_build_it() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new("texture-train");
    let hil = folder.path("hil");
    fs::copy(env!("CARGO_BIN_EXE_hil"), &hil).unwrap();
    let train = |arguments: &[&str]| -> Said {
        let mut command = Command::new(&hil);
        command.args(["texture", "train"]).args(arguments);
        command.env("PATH", "").output().unwrap().into()
    };
    let said = train(&["strokes", "--model", "out.safetensors"]);
    assert_eq!(said.status, Some(2));
    let line = "cargo build --release -p palpate-train";
    assert!(said.err.contains(line), "{}", said.err);

    let script = "#!/bin/sh\nfor a in \"$@\"; do echo \"<$a>\"; done\nexit $2\n";
    let program = folder.write("palpate-train", script);
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).unwrap();
    let said = train(&["a b", "0", "--help", "--align", "0.1"]);
    assert_eq!(
        (said.status, said.out.as_str(), said.err.as_str()),
        (Some(0), "<a b>\n<0>\n<--help>\n<--align>\n<0.1>\n", "")
    );
    // what it says of a failure is its own; its exit status stays
    for (status, expected) in [("2", 2), ("1", 1)] {
        let said = train(&["folder", status]);
        assert_eq!((said.status, said.err.as_str()), (Some(expected), ""));
    }
}

/// One recording of five features a label: what a panel is shown of each, said to be simulated everywhere.
#[test]
fn a_panel_rates_recordings_and_says_that_it_is_simulated() {
    let (folder, model, rows) = ground("texture-panel");
    let recordings = folder.path("recordings");
    fs::create_dir(&recordings).unwrap();
    for name in ["felt_0.csv", "silk_0.csv"] {
        fs::copy(&rows, recordings.join(name)).unwrap();
    }
    let recordings = recordings.display().to_string();
    let args = ["texture", "panel", &model, "--recordings", &recordings];
    let with = |more: &[&str]| good(&[&args[..], &["--rate", "100"], more].concat());
    let table = with(&[]);
    assert!(table.starts_with("SIMULATED"), "{table}");
    assert!(table.contains("felt") && table.contains("silk") && table.contains("of 1 pairs"));
    let svg = folder.path("panel.svg").display().to_string();
    let json: serde_json::Value = serde_json::from_str(&with(&["--json", "--svg", &svg])).unwrap();
    assert_eq!(json["textures"].as_array().unwrap().len(), 2);
    assert!(json["source"].as_str().unwrap().starts_with("simulated"));
    assert_eq!(
        json,
        serde_json::from_str::<serde_json::Value>(&with(&["--json"])).unwrap()
    );
    let drawing = fs::read_to_string(svg).unwrap();
    assert!(drawing.contains("SIMULATED") && drawing.contains(">silk<"));
    refused_with(&args, &["--rate"]);
    let empty = folder.path("").display().to_string();
    refused_with(
        &[
            "texture",
            "panel",
            &model,
            "--recordings",
            &empty,
            "--rate",
            "100",
        ],
        &["expected", "_"],
    );
}

#[test]
fn independent_materials_are_drawn_stroked_mapped_and_felt() {
    let folder = Folder::new("texture-materials");
    let table = folder.path("materials.toml").display().to_string();
    let draw = ["texture", "materials", "--out", &table, "--count", "4"];
    refused_with(&draw, &["--unseen 50", "at most --count, which is 4"]);
    let done = |args: &[&str]| {
        let said = hil(args);
        assert_eq!(said.status, Some(0), "{}", said.err);
    };
    done(&[&draw[..], &["--unseen", "1"]].concat());
    good(&["check", &table]);
    let strokes = folder.path("strokes");
    let out = strokes.display().to_string();
    let stroke = ["texture", "strokes", "--out", &out, "--textures", &table];
    let more = ["--strokes", "1", "--varied", "--rate", "500"];
    done(&[&stroke[..], &more].concat());
    let rows = fs::read_to_string(strokes.join("material-0003_00.csv")).unwrap();
    assert_eq!(rows.lines().count(), 1 + 1000, "2 s at 500 Hz");
    let truth = fs::read_to_string(strokes.join("materials.csv")).unwrap();
    assert_eq!(truth.lines().filter(|l| l.contains(",true,")).count(), 3);
    assert!(!strokes.join("ratings.csv").exists(), "of no person");
    // What goes with ratings is left out of the map. A panel needs none: a bare finger feels what the surface is.
    let map = ["texture", "map", "--textures", &table, "--strokes", "1"];
    let map = good(&map);
    assert!(map.contains("friction") && !map.contains("rated"), "{map}");
    let panel = good(&["texture", "panel", "--textures", &table, "--json"]);
    let panel: serde_json::Value = serde_json::from_str(&panel).unwrap();
    assert_eq!(panel["textures"].as_array().map(Vec::len), Some(4));
    assert!(
        panel["spearman"]
            .as_object()
            .is_some_and(|all| all.len() == 6)
    );
    let tests = &panel["textures"][3]["tests"];
    assert_eq!(tests[0]["against"], "bare finger");
}

/// A model of all 48 features of a flat module whose file says this of its coordinates.
fn knows(folder: &Folder, latent: &str, more: &[(&str, String)]) -> String {
    let names = (1..=16).flat_map(|t| ["x", "y", "z"].map(|axis| format!("txl{t}_{axis}")));
    let names: Vec<String> = names.collect();
    let mut about = vec![
        ("features", serde_json::json!(names).to_string()),
        ("latent", latent.to_owned()),
    ];
    about.extend_from_slice(more);
    let model = Seeded::new(3, &[48, 8, 3], 100, 1.0).file_with(&about);
    let path = folder.path("knows.safetensors");
    fs::write(&path, model.unwrap()).unwrap();
    path.display().to_string()
}

#[test]
fn what_a_model_cannot_know_of_a_surface_is_said() {
    let folder = Folder::new("texture-cannot");
    let one = |n: usize, learned: &str| {
        format!(r#"{{"coordinate":{n},"sign":1,"z_lo":-0.5,"z_hi":0.5{learned}}}"#)
    };
    let run = |model: &str, more: &[&str]| -> Vec<String> {
        let model = format!("texture.model=\"{model}\"");
        let all = [&["run", "texture-wood", "--set", &model], more].concat();
        all.iter().map(|part| (*part).to_owned()).collect()
    };
    let refuse = |args: Vec<String>, parts: &[&str]| {
        let args: Vec<&str> = args.iter().map(String::as_str).collect();
        refused_with(&args, parts);
    };
    let asked = ["--set", "texture.hardness=true"];
    // a model without a head for hardness
    let model = knows(&folder, &format!(r#"{{"roughness":{}}}"#, one(0, "")), &[]);
    refuse(
        run(&model, &asked),
        &["texture.model", "a coordinate for hardness"],
    );
    // one with it, where nothing can carry it
    let both = format!(
        r#"{{"roughness":{},"hardness":{}}}"#,
        one(0, ""),
        one(2, "")
    );
    let model = knows(&folder, &both, &[]);
    let contacts = [&asked[..], &["--set", "texture.carrier=\"contacts\""]].concat();
    refuse(
        run(&model, &contacts),
        &["texture.hardness", "carrier \"display\""],
    );
    // readings at another rate than it was trained on
    let model = knows(&folder, &both, &[("rate_hz", "1000".to_owned())]);
    let parts = ["rate_hz", "1000 Hz", "100 Hz"];
    refuse(run(&model, &[]), &parts);
    for command in ["map", "response", "panel"] {
        refused_with(&["texture", command, &model], &parts);
    }
    // a surface outside what it learned
    let learned = format!(
        r#"{{"roughness":{},"hardness":{}}}"#,
        one(0, r#","learned":[50.0,200.0]"#),
        one(2, r#","learned":[1.0,100.0]"#)
    );
    let split = r#"{"train":["wood_00","sponge2_01"],"test":["towel_00"]}"#;
    let model = knows(&folder, &learned, &[("split", split.to_owned())]);
    let args = run(&model, &[]);
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let said = good(&args);
    let line = "EXTRAPOLATED: relief 25 um (learned 50 to 200)";
    assert!(
        said.contains(line) && !said.contains("stiffness 60"),
        "{said}"
    );
    let map = good(&["texture", "map", &model, "--strokes", "1"]);
    assert!(map.contains("wood: EXTRAPOLATED: relief 25 um"), "{map}");
    assert!(!map.contains("towel: EXTRAPOLATED"), "{map}");
    // What it was trained on, as its file says.
    for (name, seen) in [
        ("wood ", true),
        ("sponge2", true),
        ("towel", false),
        ("sponge1", false),
    ] {
        let row = map.lines().find(|l| l.starts_with(name)).unwrap();
        assert_eq!(!row.ends_with("unseen"), seen, "{map}");
    }
}

#[test]
fn a_response_says_what_each_coordinate_makes_of_each_property() {
    let ask = ["texture", "response", "--strokes", "1", "--materials", "20"];
    let json = good(&[&ask[..], &["--json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let rows = json.as_array().unwrap();
    assert_eq!(rows.len(), 3 * 6, "coordinates times factors");
    let of = |coordinate: &str, property: &str| {
        let is = |row: &&serde_json::Value| {
            row["coordinate"] == coordinate && row["property"] == property
        };
        rows.iter().find(is).unwrap()
    };
    // Each coordinate of the shipped model goes with its own property, and friction and hardness with nothing else.
    for (coordinate, own) in [
        ("roughness", "relief"),
        ("friction", "friction"),
        ("hardness", "stiffness"),
    ] {
        let rank = &of(coordinate, own)["probe_rank_correlation"];
        assert!(rank.as_f64().unwrap() > 0.8, "{coordinate}: {json}");
    }
    for (coordinate, foreign) in [
        (
            "friction",
            ["relief", "wavelength", "stiffness", "speed", "force"],
        ),
        (
            "hardness",
            ["relief", "wavelength", "friction", "speed", "force"],
        ),
    ] {
        for factor in foreign {
            let crosstalk = of(coordinate, factor)["crosstalk"].as_f64().unwrap();
            assert!(crosstalk <= 0.2, "{coordinate} over {factor}: {crosstalk}");
        }
    }
    assert_eq!(of("roughness", "relief")["own"], true);
    assert_eq!(of("roughness", "relief")["materials"], "unseen");
    assert_eq!(of("roughness", "speed")["materials"], "probes");
    assert!(of("roughness", "speed")["interval"].is_null());
    let table = good(&ask);
    for part in ["z1 roughness", "crosstalk", "20 materials", " to "] {
        assert!(table.contains(part), "{part}: {table}");
    }
    refused_with(&["texture", "response", "missing"], &["missing"]);
}

#[test]
fn a_response_over_several_seeds_has_the_median_and_the_range_of_each_crosstalk() {
    let ask = ["texture", "response", "--strokes", "1", "--seeds", "3"];
    let json = good(&[&ask[..], &["--json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let rows = json.as_array().unwrap();
    assert_eq!(rows.len(), 3 * 6, "coordinates times factors");
    for row in rows {
        let of = |figure: &str| row["crosstalk"][figure].as_f64().unwrap();
        let (least, median, largest) = (of("least"), of("median"), of("largest"));
        assert!(least <= median && median <= largest, "{row}");
        assert_eq!(row["own"] == true, (least, largest) == (1.0, 1.0), "{row}");
        assert_eq!(row["seeds"], 3);
    }
    let table = good(&ask);
    for part in ["seeds 1 to 3", "z1 roughness", "own", " to "] {
        assert!(table.contains(part), "{part}: {table}");
    }
    let both = ["texture", "response", "--seeds", "3", "--seed", "2"];
    refused_with(&both, &["--seed"]);
}
