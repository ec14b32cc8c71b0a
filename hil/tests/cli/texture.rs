//! `hil texture`: models that are refused, recordings that are refused, latent vectors and the way out.

use palpate_hil::texture::seeded::{Seeded, stroke};

use super::*;

/// A folder with a small model and a recording for it, and their paths.
fn ground(name: &str) -> (Folder, String, String) {
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
    let half = good(&["texture", "encode", &model, &rows, "--weights", "half"]);
    assert_ne!(half, every);
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
        &["texture", "encode", &model, &rows, "--steps", "21"],
        &["--steps", "at most 20"],
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
fn pulses_are_seeded_and_of_the_displays_wires() {
    let (_folder, model, rows) = ground("texture-pulses");
    let of = |more: &[&str]| {
        let args = [
            &[
                "texture",
                "pulses",
                model.as_str(),
                rows.as_str(),
                "--rate",
                "100",
            ],
            more,
        ]
        .concat();
        let text = good(&args);
        let mut lines = text.lines().map(str::to_owned);
        assert_eq!(lines.next().unwrap(), "period,time_us,wire");
        lines.collect::<Vec<_>>()
    };
    let line = of(&[]);
    assert_eq!(line, of(&["--seed", "1"]));
    assert_ne!(line, of(&["--seed", "2"]));
    assert_ne!(line, of(&["--draw", "diffusion"]));
    let wires = |lines: &[String], count: usize| {
        lines
            .iter()
            .all(|l| l.rsplit(',').next().unwrap().parse::<usize>().unwrap() < count)
    };
    assert!(!line.is_empty() && wires(&line, 3));
    let thimble = of(&["--display", "thimble-8"]);
    assert!(thimble.len() > line.len() / 2 && wires(&thimble, 8) && !wires(&thimble, 3));
    let args = ["texture", "pulses", &model, &rows, "--rate", "100"];
    refused_with(
        &[&args[..], &["--display", "uskin-4x4"]].concat(),
        &["--display", "\"display\""],
    );
    refused_with(
        &[&args[..], &["--activation", "none-such"]].concat(),
        &["assumed", "or a file"],
    );
}

#[test]
fn the_export_is_an_onnx_file_with_its_names() {
    let (folder, model, _) = ground("texture-export");
    let out = folder.path("encoder.onnx").display().to_string();
    let said = hil(&["texture", "export", &model, &out]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert!(said.err.contains("`raw` [20, N, 5]"), "{}", said.err);
    let bytes = fs::read(&out).unwrap();
    for name in ["linear_before_reset", "hidden_size", "GRU", "latent"] {
        let found = bytes.windows(name.len()).any(|w| w == name.as_bytes());
        assert!(found, "no {name}");
    }
}
