//! `hil study`.

use serde_json::Value;

use super::*;

#[test]
fn simulated_people_say_how_well_a_protocol_finds_their_thresholds() {
    let said = good(&[
        "study",
        "simulate",
        "thresholds",
        "--people",
        "40",
        "--json",
    ]);
    let found: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(found["protocol"], "thresholds");
    assert_eq!(found["thresholds"], 320);
    let error = found["threshold_error_median"].as_f64().unwrap();
    let coverage = found["coverage"].as_f64().unwrap();
    assert!(error > 0.0 && error < 0.1, "{found}");
    assert!((0.88..=1.0).contains(&coverage), "{found}");
    assert!(found.get("false_positive_rate").is_none(), "{found}");
    assert!(
        found["assumed"].as_str().unwrap().contains("simulated"),
        "{found}"
    );
    let text = good(&["study", "simulate", "thresholds", "--people", "40"]);
    assert!(
        text.contains("median of 320 thresholds; 60 trials each"),
        "{text}"
    );
}

#[test]
fn and_how_many_people_a_difference_needs() {
    let said = good(&["study", "simulate", "roughness", "--json"]);
    let found: Value = serde_json::from_str(&said).unwrap();
    assert!(
        found["false_positive_rate"].as_f64().unwrap() <= 0.065,
        "{found}"
    );
    assert!(found["people_for_power"].as_u64().unwrap() > 8, "{found}");
}

#[test]
fn what_cannot_be_simulated_is_refused() {
    refused_with(
        &["study", "simulate", "roughness", "--people", "3"],
        &["--people", "expected 4 at least"],
    );
    refused_with(
        &["study", "simulate", "treshold"],
        &["did you mean `thresholds`"],
    );
}

fn folder(name: &str) -> PathBuf {
    let path =
        std::env::temp_dir().join(format!("palpate-cli-study-{name}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&path);
    path
}

/// A short study of every kind of answer.
fn short(path: &Path) -> String {
    let text = r#"
name = "short"
description = "Every task, as short as can be"
consent = "Do you take part?"
instructions = "Answer."
pause_s = 0.1
stimulus_s = 0.3
questions = [{ name = "hand", text = "Which hand?", choices = ["left", "right"] }]
conditions = [
    { name = "up", scene = "brush-strokes" },
    { name = "along", scene = "sphere-along", set = ["length_s=3"] },
    { name = "wood", present = "wood" },
]

[absolute_threshold]
wires = [0, 1, 2, 3, 4, 5, 6, 7]
method = "quest-plus"
trials = 4
simulated = { threshold_db = { mean = -14.0, sd = 3.3 }, wire_sd_db = 2.0, slope = { mean = 3.5, sd = 0.5 }, lapse = 0.04 }

[matching]
reference = 3
level_db = -6.0
wires = [0, 1, 2, 4, 5, 6, 7]
trials = 2
simulated = { level_db = { mean = -6.0, sd = 2.0 }, slope = { mean = 5.0, sd = 0.5 }, lapse = 0.02 }

[localisation]
wires = [0, 7]
level_db = 0.0
repeats = 2
simulated = { bias_mm = { mean = 0.0, sd = 1.0 }, noise_mm = 2.0, slips = 0.0 }

[drawing]
conditions = ["up", "along"]
repeats = 1
simulated = { bias_mm = { mean = 0.0, sd = 0.5 }, scale = { mean = 1.0, sd = 0.05 }, noise_mm = 1.0, breaks_hz = 0.0 }

[rating]
scales = [{ name = "roughness", low = "smooth", high = "rough" }]
conditions = ["along", "wood"]
compare = [["along", "wood"]]
groups = "within"
repeats = 1
simulated = { rating = { mean = 3.0, sd = 0.5 }, noise = 0.5, difference = 1.0 }
"#;
    fs::create_dir_all(path).unwrap();
    let file = path.join("short.toml");
    fs::write(&file, text).unwrap();
    file.display().to_string()
}

#[test]
fn simulated_people_go_the_whole_way_from_protocol_to_wearer() {
    let here = folder("whole");
    let protocol = short(&here);
    let out = here.join("study");
    let out = out.to_str().unwrap();
    for n in ["1", "2", "3"] {
        let said = good(&[
            "study",
            "run",
            &protocol,
            "--participant",
            n,
            "--out",
            out,
            "--simulated",
        ]);
        assert!(said.contains("done; next: hil study analyse"), "{said}");
    }
    refused_with(
        &[
            "study",
            "run",
            &protocol,
            "--participant",
            "2",
            "--out",
            out,
            "--simulated",
        ],
        &[
            "--participant 2",
            "no participant of this study has",
            "that is over",
        ],
    );
    let said = good(&["study", "analyse", out, "--json"]);
    let found: Value = serde_json::from_str(&said).unwrap();
    assert_eq!(found["participants"].as_array().unwrap().len(), 3);
    assert_eq!(found["simulated"], true);
    assert_eq!(found["participants"][0]["answers"][0][1], "left");
    assert_eq!(
        found["participants"][0]["thresholds"]
            .as_array()
            .unwrap()
            .len(),
        8
    );
    let rmse = found["drawings"][0]["rmse_mm"]["value"].as_f64().unwrap();
    assert!(rmse > 0.2 && rmse < 4.0, "{rmse}");
    assert_eq!(found["comparisons"][0]["counts"], serde_json::json!([3, 3]));
    let off = found["localisation_mm"]["value"].as_f64().unwrap();
    assert!(off > 0.1 && off < 8.0, "{off}");

    kept(out);
    fs::remove_dir_all(here).unwrap();
}

#[test]
fn what_two_studies_rated_is_compared() {
    let here = folder("beside");
    let out = |study: &str| here.join(study).display().to_string();
    let (hand, wires, other) = (out("hand"), out("wires"), out("other"));
    let run = |protocol: &str, number: &str, out: &str| {
        let words = ["study", "run", protocol, "--participant", number];
        good(&[&words[..], &["--out", out, "--simulated"]].concat());
    };
    for number in ["1", "2", "3", "4"] {
        run("textures-by-hand", number, &hand);
    }
    run("textures-on-wires", "1", &wires);
    run("textures-on-wires", "2", &wires);
    run("thresholds", "1", &other);
    let said = good(&["study", "analyse", &wires, "--beside", &hand, "--json"]);
    let found: Value = serde_json::from_str(&said).unwrap();
    let compared = found["comparisons"].as_array().unwrap();
    // Eight surfaces on three scales.
    assert_eq!(compared.len(), 24, "{found}");
    let wood = compared
        .iter()
        .find(|c| c["of"] == "roughness of wood")
        .unwrap();
    // Other people: what they rated goes together on no scale and surface.
    let us = compared.iter().map(|c| c["u"].to_string());
    assert!(
        us.collect::<std::collections::BTreeSet<_>>().len() > 3,
        "{found}"
    );
    assert!(
        (wood["least_p"].as_f64().unwrap() - 2.0 / 15.0).abs() < 1e-9,
        "{wood}"
    );
    let text = good(&["study", "analyse", &wires, "--beside", &hand]);
    let nothing = "4 against 2 people say nothing: no answers of so few differ at p below 0.13";
    assert_eq!(text.matches(nothing).count(), 24, "{text}");
    assert!(!text.contains(", p "), "{text}");
    run("textures-on-wires", "2", &out("wires-again"));
    refused_with(
        &["study", "analyse", &wires, "--beside", &out("wires-again")],
        &[
            "simulated participants of the same protocol, number and seed: 2",
            "--seed",
        ],
    );
    assert_eq!(wood["first"], "textures-by-hand");
    assert_eq!(wood["second"], "textures-on-wires");
    assert_eq!(wood["counts"], serde_json::json!([4, 2]));
    let own = found["ratings"].as_array().unwrap().iter();
    let mut own = own.filter(|r| r["scale"] == "roughness" && r["condition"] == "wood");
    assert_eq!(
        wood["medians"][1],
        own.next().unwrap()["median"]["value"],
        "{wood}"
    );
    let table = fs::read_to_string(format!("{wires}/analysis/comparisons.csv")).unwrap();
    assert_eq!(table.lines().count(), 25, "{table}");
    refused_with(
        &["study", "analyse", &wires, "--beside", &other],
        &["--beside", "found none in common"],
    );
    fs::remove_dir_all(here).unwrap();
}

/// Data as Psych-DS lays them out, what of a trial was played in the record, and the wearer's file that a run takes.
fn kept(out: &str) {
    let read = |name: &str| fs::read_to_string(format!("{out}/{name}")).unwrap();
    let description: Value = serde_json::from_str(&read("dataset_description.json")).unwrap();
    assert_eq!(description["@type"], "Dataset");
    let table = read("data/subject-2_study-short_data.csv");
    let columns: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    assert_eq!(description["variableMeasured"], serde_json::json!(columns));
    assert_eq!(table.lines().count(), 1 + 32 + 14 + 4 + 2 + 2);
    let record = read("records/participant-2.jsonl");
    let about: Value = serde_json::from_str(record.lines().next().unwrap()).unwrap();
    assert_eq!(about["session"]["protocol"], "short");
    assert_eq!(about["session"]["bench"], "emulated");
    assert_eq!(
        about["session"]["limits_digest"].as_str().unwrap().len(),
        16
    );
    let pulses = record
        .lines()
        .filter(|line| line.contains("\"requested\":"))
        .count();
    assert!(pulses >= 30, "{pulses} trials with a schedule");

    let wearer = format!("{out}/analysis/participant-1.toml");
    good(&["check", &wearer]);
    let said = good(&[
        "run",
        "sphere-along",
        "--wearer",
        &wearer,
        "--illusion",
        "balanced",
        "--set",
        "length_s=2",
        "--json",
    ]);
    assert!(said.contains("\"source\":\"emulated\""), "{said}");
    let page = read("analysis/index.html");
    assert!(page.contains("Simulated people answered") && page.contains("Participant 3"));
}

#[test]
fn a_session_that_is_too_much_is_refused_with_its_arithmetic_before_anything_is_made() {
    let here = folder("dose");
    fs::create_dir_all(&here).unwrap();
    let file = here.join("long.toml");
    let text = r#"
name = "long"
description = "One wire at full drive for most of a day"
pause_s = 0.1
stimulus_s = 10.0
[localisation]
wires = [0]
level_db = 0.0
repeats = 1000
simulated = { bias_mm = { mean = 0.0, sd = 1.0 }, noise_mm = 2.0, slips = 0.0 }
"#;
    fs::write(&file, text).unwrap();
    let out = here.join("study");
    refused_with(
        &[
            "study",
            "run",
            file.to_str().unwrap(),
            "--participant",
            "1",
            "--out",
            out.to_str().unwrap(),
            "--simulated",
        ],
        &[
            "the session's dose",
            "1000 trials of localisation at",
            "% = ",
        ],
    );
    assert!(!out.exists());
    fs::remove_dir_all(here).unwrap();
}

/// What ships is within the dose of a session on the default bench.
#[test]
fn every_protocol_that_ships_fits_into_a_session() {
    let list = good(&["list", "protocols"]);
    let names: Vec<&str> = list
        .lines()
        .filter_map(|l| l.split_whitespace().next())
        .collect();
    assert!(names.contains(&"wearer"), "{list}");
    for name in names {
        let words = ["study", "run", name, "--participant", "1"];
        let said = good(&[&words[..], &["--out", "unused", "--dose"]].concat());
        assert!(
            said.contains("of the dose that a session may have"),
            "{said}"
        );
    }
}

#[test]
fn what_a_bench_cannot_play_is_refused() {
    let here = folder("bench");
    fs::create_dir_all(&here).unwrap();
    let wearer = palpate_fixtures::protocol("wearer").unwrap();
    let file = here.join("w.toml");
    fs::write(&file, wearer.replacen("wires = [3]", "wires = [12]", 1)).unwrap();
    let out = here.join("study");
    let run = |protocol: &str, more: &[&str], expected: &[&str]| {
        let mut args = vec![
            "study",
            "run",
            protocol,
            "--participant",
            "1",
            "--out",
            out.to_str().unwrap(),
        ];
        args.extend(more);
        refused_with(&args, expected);
    };
    run(
        file.to_str().unwrap(),
        &["--simulated"],
        &["difference.wires[0]", "a wire of bench `emulated`, 0 to 7"],
    );
    run(
        "felt-paths",
        &["--simulated", "--bench", "ten-fingers"],
        &["one display"],
    );
    let hardware = Folder::new("study-real");
    let real = real_bench(&hardware);
    run(
        "felt-paths",
        &["--bench", &real],
        &["conditions[0].scene", "a scene of [[strokes]]"],
    );
    run(
        "wearer",
        &["--simulated", "--bench", &real],
        &["--simulated", "an emulated bench"],
    );
    assert!(!out.exists());
    fs::remove_dir_all(here).unwrap();
}

#[test]
fn a_new_protocol_reads_and_simulates() {
    let here = folder("new");
    fs::create_dir_all(&here).unwrap();
    let file = here.join("mine.toml");
    let path = file.to_str().unwrap();
    good(&["study", "new", "mine", "--like", "illusions", "--out", path]);
    good(&["check", path]);
    let said = good(&["study", "simulate", path, "--people", "10", "--json"]);
    assert!(said.contains("\"choice\":{"), "{said}");
    fs::remove_dir_all(here).unwrap();
}
