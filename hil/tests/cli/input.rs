//! Bad files, as people write them: the message says where, and what was expected.

use super::*;

/// A built-in file with one change.
fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

#[test]
fn an_unknown_name_lists_what_there_is() {
    let mut names: Vec<_> = palpate_fixtures::scene_names().collect();
    names.push("nowhere");
    refused_with(&["run", "nowhere"], &names);
    let mut names: Vec<_> = palpate_fixtures::bench_names().collect();
    names.push("nowhere");
    refused_with(&["run", "--bench", "nowhere"], &names);
    refused_with(&["run", ""], &["idle"]);
}

#[test]
fn bad_scenes() {
    let folder = Folder::new("bad-scenes");
    let good = palpate_fixtures::scene("sphere-along").unwrap();
    let line = |key: &str| 1 + good.lines().position(|l| l.starts_with(key)).unwrap();
    for (from, to, key, words) in [
        (
            "kc = 1",
            "kc = 0",
            "kc",
            &["compression.kc", "expected", "found 0"][..],
        ),
        ("kc = 1", "kc = -1", "kc", &["compression.kc", "expected"]),
        (
            "kc = 1",
            "kc = \"one\"",
            "kc",
            &["compression.kc", "whole number"],
        ),
        ("ki = 10", "ki = 0", "ki", &["compression.ki", "expected"]),
        (
            "rate_hz = 100.0",
            "rate_hz = 0.0",
            "rate_hz",
            &["rate_hz", "expected", "0.0"],
        ),
        (
            "rate_hz = 100.0",
            "rate_hz = nan",
            "rate_hz",
            &["rate_hz", "nan"],
        ),
        (
            "rate_hz = 100.0",
            "rate_hz = inf",
            "rate_hz",
            &["rate_hz", "inf"],
        ),
        (
            "length_s = 10.0",
            "length_s = \"ten\"",
            "length_s",
            &["length_s", "a number"],
        ),
        (
            "kc = 1",
            "kc = 1\nkd = 2",
            "ki",
            &["compression.kd", "unknown key"],
        ),
        (
            "layout = \"uskin-4x4\"",
            "layout = \"nowhere\"",
            "layout",
            &["layout", "uskin-4x4", "nowhere"],
        ),
        (
            "layout = \"uskin-4x4\"",
            "layout = \"thimble-8\"",
            "layout",
            &["layout", "sensor", "display"],
        ),
        (
            "norm = \"l2\"",
            "norm = \"l3\"",
            "norm",
            &["compression.norm", "`l2`", "l3"],
        ),
        (
            "drives = 0",
            "drives = 1",
            "drives",
            &["drives", "expected"],
        ),
        (
            "generation = \"2021\"",
            "generation = \"2020\"",
            "generation",
            &["generation", "2021"],
        ),
    ] {
        let file = folder
            .write("scene.toml", &changed(good, from, to))
            .display()
            .to_string();
        let mut all = vec![format!("{file}:{}: ", line(key))];
        all.extend(words.iter().map(|w| (*w).to_owned()));
        let all: Vec<_> = all.iter().map(String::as_str).collect();
        refused_with(&["run", &file], &all);
    }
    for (gone, key) in [
        ("kc = 1\n", "compression.kc"),
        ("rate_hz = 100.0\n", "rate_hz"),
    ] {
        let file = folder
            .write("scene.toml", &changed(good, gone, ""))
            .display()
            .to_string();
        refused_with(
            &["run", &file],
            &["scene.toml:", key, "expected", "found nothing"],
        );
    }
    for (text, word) in [
        ("", "an empty file"),
        ("\n \n", "an empty file"),
        ("[[[", "scene.toml:1"),
        ("x", "scene.toml:1"),
    ] {
        let file = folder.write("scene.toml", text).display().to_string();
        refused_with(&["run", &file], &["scene.toml", "expected", word]);
    }
    fs::write(folder.path("scene.toml"), b"name = \"a\"\n\xFF").unwrap();
    refused_with(
        &["run", &folder.path("scene.toml").display().to_string()],
        &["scene.toml:2", "UTF-8"],
    );
    refused_with(
        &["run", &folder.0.display().to_string()],
        &["expected a readable file"],
    );
}

#[test]
fn bad_benches_and_limits() {
    let folder = Folder::new("bad-benches");
    let good = palpate_fixtures::bench("emulated").unwrap();
    for (from, to, words) in [
        (
            "current_ma = 990.0",
            "current_ma = 0.0",
            &["drive.current_ma", "expected"][..],
        ),
        (
            "current_ma = 990.0",
            "current_ma = nan",
            &["drive.current_ma", "nan"],
        ),
        (
            "pwm_hz = 200.0",
            "pwm_hz = 0.0",
            &["drive.pwm_hz", "expected"],
        ),
        (
            "pwm_hz = 200.0",
            "pwm_hz = 5000.0",
            &["drive.pwm_hz", "expected"],
        ),
        (
            "kind = \"emulated\"",
            "kind = \"real\"",
            &["kind", "expected a [real] table that names the buses"],
        ),
        ("channel = 1", "channel = 0", &["outputs[1]", "expected"]),
        (
            "channel = 1",
            "channel = 16",
            &["outputs[1].channel", "expected"],
        ),
        (
            "channel = 1\n",
            "",
            &["outputs[1].channel", "found nothing"],
        ),
        (
            "channel = 1",
            "chanel = 1",
            &["outputs[1].chanel", "unknown key"],
        ),
        (
            "display = \"thimble-8\"",
            "display = \"uskin-4x4\"",
            &["display", "expected", "sensor"],
        ),
        (
            "display = \"thimble-8\"",
            "display = \"three-in-line\"",
            &["outputs", "3 outputs", "found 8"],
        ),
        (
            "limits = \"default\"",
            "limits = \"none\"",
            &["limits", "default"],
        ),
        (
            "kind = \"final-75um\"",
            "kind = \"final-80um\"",
            &["wire.kind", "final-75um, first-100um"],
        ),
    ] {
        let file = folder
            .write("bench.toml", &changed(good, from, to))
            .display()
            .to_string();
        let mut all = vec!["bench.toml:"];
        all.extend(words);
        refused_with(&["run", "--bench", &file], &all);
    }
    let bench = changed(good, "limits = \"default\"", "limits = \"limits.toml\"");
    let bench = folder.write("bench.toml", &bench).display().to_string();
    let good = palpate_fixtures::limits("default").unwrap();
    for (from, to, words) in [
        (
            "width_us = 200.0",
            "width_us = 201.0",
            &["pulse.width_us", "at most the hard limit 200", "201"][..],
        ),
        (
            "peak_c = 43.0 ",
            "peak_c = 43.1 ",
            &["skin.peak_c", "hard limit 43"],
        ),
        (
            "over_60s_mw = 60.0",
            "over_60s_mw = inf",
            &["fingertip_power.over_60s_mw", "inf"],
        ),
        (
            "width_us = 200.0",
            "width_us = 0.0",
            &["pulse.width_us", "more than 0"],
        ),
        (
            "width_us = 200.0",
            "width_us = -1.0",
            &["pulse.width_us", "more than 0"],
        ),
        (
            "width_us = 200.0",
            "width = 200.0",
            &["pulse.width", "unknown key"],
        ),
        (
            "width_us = 200.0",
            "width_us = true",
            &["pulse.width_us", "a number"],
        ),
    ] {
        folder.write("limits.toml", &changed(good, from, to));
        let mut all = vec!["limits.toml:"];
        all.extend(words);
        refused_with(&["run", "--bench", &bench], &all);
    }
    folder.write("limits.toml", "");
    refused_with(&["run", "--bench", &bench], &["limits.toml", "empty file"]);
    // Tightening is what a table is for.
    folder.write(
        "limits.toml",
        &changed(good, "width_us = 200.0", "width_us = 100.0"),
    );
    let said = hil(&["run", "--bench", &bench, "--json"]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    let summary: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert!(summary["limiter_events"].as_u64().unwrap() > 0);
}

#[test]
fn bad_layouts() {
    let folder = Folder::new("bad-layouts");
    let recording = contacts::recording(&folder, 60);
    let good = palpate_fixtures::layout("uskin-4x4").unwrap();
    for (from, to, words) in [
        (
            "rows = 4",
            "rows = 0",
            &["modules[0].grid.rows", "expected"][..],
        ),
        (
            "pitch_mm = 4.7",
            "pitch_mm = 0.0",
            &["modules[0].grid.pitch_mm", "expected"],
        ),
        ("pitch_mm = 4.7", "pitch_mm = nan", &["pitch_mm", "nan"]),
        (
            "pitch_mm = 4.7",
            "pitch = 4.7",
            &["modules[0].grid.pitch", "unknown key"],
        ),
        ("axes = 3", "axes = 2", &["axes", "1 or 3"]),
        ("axes = 3\n", "", &["axes", "found nothing"]),
        (
            "kind = \"sensor\"",
            "kind = \"skin\"",
            &["kind", "\"sensor\""],
        ),
        (
            "boards = [4]",
            "boards = [16]",
            &["modules[0].boards[0]", "expected"],
        ),
        ("bus = 0\n", "", &["modules[0].bus", "expected"]),
        (
            "bus = 0",
            "inactive = [16]\nbus = 0",
            &["modules[0].inactive[0]", "expected"],
        ),
    ] {
        let file = folder
            .write("layout.toml", &changed(good, from, to))
            .display()
            .to_string();
        let mut all = vec!["layout.toml:"];
        all.extend(words);
        refused_with(
            &["contacts", &recording, "--rate", "40", "--layout", &file],
            &all,
        );
        refused_with(
            &[
                "run", "--replay", &recording, "--rate", "40", "--layout", &file,
            ],
            &all,
        );
    }
    // A layout that cannot hold these columns, or is no grid of them.
    let text = changed(good, "rows = 4", "rows = 3");
    let file = folder.write("layout.toml", &text).display().to_string();
    for args in [
        ["contacts", &recording, "--rate", "40", "--layout", &file].to_vec(),
        [
            "run", "--replay", &recording, "--rate", "40", "--layout", &file,
        ]
        .to_vec(),
    ] {
        refused_with(&args, &["recording.csv:1", "36 taxel columns", "found 48"]);
    }
}

#[test]
fn a_layout_is_found_from_where_it_is_typed() {
    let folder = Folder::new("relative");
    fs::create_dir(folder.path("scenes")).unwrap();
    contacts::recording(&folder, 120);
    folder.write("scenes/mine.toml", palpate_fixtures::scene("idle").unwrap());
    folder.write("mine.toml", palpate_fixtures::layout("uskin-4x4").unwrap());
    let said = hil_in(
        &folder.0,
        &[
            "run",
            "scenes/mine.toml",
            "--replay",
            "recording.csv",
            "--rate",
            "40",
            "--layout",
            "mine.toml",
        ],
    );
    assert_eq!(said.status, Some(0), "{}", said.err);
}

#[test]
fn bad_recordings() {
    let folder = Folder::new("bad-recordings");
    let good = fs::read_to_string(contacts::recording(&folder, 60)).unwrap();
    let third = good.lines().nth(2).unwrap();
    let with_third = |row: &str| good.replacen(&format!("{third}\n"), &format!("{row}\n"), 1);
    let first = third.split(',').next().unwrap();
    let with_first = |value: &str| with_third(&third.replacen(first, value, 1));
    for (text, words) in [
        (String::new(), &["expected", "empty file"][..]),
        (
            good.lines().next().unwrap().to_owned(),
            &["at least one row"],
        ),
        (with_third("1,2,3"), &["f.csv:3", "48 columns", "found 3"]),
        (
            with_third(&format!("{third},1")),
            &["f.csv:3", "48 columns", "found 49"],
        ),
        (
            with_first("abc"),
            &["f.csv:3", "column 1 (txl1_x)", "whole count", "`abc`"],
        ),
        (
            with_first("NaN"),
            &["f.csv:3", "column 1 (txl1_x)", "`NaN`"],
        ),
        (with_first("-1"), &["f.csv:3", "0 to 65535", "`-1`"]),
        (with_first("70000"), &["f.csv:3", "0 to 65535", "`70000`"]),
        (with_first(""), &["f.csv:3", "found nothing"]),
        (
            good.replacen("txl1_x", "taxel1_x", 1),
            &["f.csv:1", "column 1", "txl1_x"],
        ),
        (good.replace(',', ";"), &["f.csv:1", "expected"]),
        (
            good.lines().take(8).collect::<Vec<_>>().join("\n"),
            &["f.csv", "expected", "rows", "found 7"],
        ),
    ] {
        let file = folder.write("f.csv", &text).display().to_string();
        let tail = ["--rate", "40", "--layout", "uskin-4x4"];
        refused_with(&[&["contacts", &file][..], &tail].concat(), words);
        refused_with(&[&["run", "--replay", &file][..], &tail].concat(), words);
    }
    let file = folder.write("f.csv", &good).display().to_string();
    for rate in ["0", "-1", "NaN"] {
        refused_with(
            &["run", "--replay", &file, "--rate", rate],
            &["--rate", "expected"],
        );
    }
    refused_with(
        &["run", "--replay", &file],
        &["f.csv:1", "time_us", "--rate"],
    );
    refused_with(&["run", "--rate", "40"], &["--replay"]);
    let pair = [
        "run",
        "--replay",
        &file,
        "--rate",
        "40",
        "--layout",
        "uskin-4x4-pair",
    ];
    refused_with(&pair, &["--replay", "2 files, one a module", "found 1"]);
    refused_with(
        &["run", "--replay", "nowhere.csv", "--rate", "40"],
        &["nowhere.csv", "readable file"],
    );
    // Times that no run could last.
    let timed: String = good
        .lines()
        .enumerate()
        .map(|(i, line)| match i {
            0 => format!("time_us,{line}\n"),
            60 => format!("18446744073709551615,{line}\n"),
            _ => format!("{i},{line}\n"),
        })
        .collect();
    let file = folder.write("f.csv", &timed).display().to_string();
    refused_with(
        &["run", "--replay", &file],
        &["f.csv:61: column 1 (time_us): expected at most a day"],
    );
}
