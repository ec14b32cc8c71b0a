//! Bad files, as people write them. What is said about each kind of mistake is tested where files are read; here: that
//! every command says it, with exit status 2.

use super::*;

/// A built-in file with one change.
fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

#[test]
fn an_unknown_name_says_what_lists_names() {
    refused_with(&["run", "nowhere"], &["nowhere", "hil list scenes"]);
    refused_with(&["run", ""], &["hil list scenes"]);
}

#[test]
fn every_kind_of_file_is_refused_with_its_place() {
    let folder = Folder::new("bad-files");
    let file = |name: &str, text: &str| folder.write(name, text).display().to_string();
    let heading = "name = \"bad\"\ndescription = \"d\"\n";
    let scene = file("scene.toml", &format!("{heading}compression.kc = 0\n"));
    let place = "scene.toml:3: compression.kc: expected a number from 1 to 1024, found 0";
    refused_with(&["run", &scene], &[place]);
    let bench = file("bench.toml", &format!("{heading}drive.current_ma = 0\n"));
    let place = "bench.toml:3: drive.current_ma: expected a number from 1 to 5000 mA, found 0";
    refused_with(&["run", "--bench", &bench], &[place]);

    let recording = contacts::recording(&folder, 60);
    let good = palpate_fixtures::layout("uskin-4x4").unwrap();
    let layout = file("layout.toml", &changed(good, "rows = 4", "rows = 0"));
    let line = 1 + good.lines().position(|l| l.contains("rows = 4")).unwrap();
    let place =
        format!("layout.toml:{line}: modules[0].grid.rows: expected a number from 1 to 4096");
    let place = place.as_str();
    let tail = ["--rate", "40", "--layout", &layout];
    refused_with(&[&["contacts", &recording][..], &tail].concat(), &[place]);
    let replay = ["run", "--replay", &recording];
    refused_with(&[&replay[..], &tail].concat(), &[place]);
}

/// Whatever else a bench says: no file loosens what the guard enforces.
#[test]
fn a_limit_table_tightens_and_never_loosens() {
    let folder = Folder::new("limits");
    let heading = "name = \"mine\"\ndescription = \"d\"\n";
    let bench = format!("{heading}limits = \"limits.toml\"\n");
    let bench = folder.write("bench.toml", &bench).display().to_string();
    let loose = format!("{heading}pulse.width_us = 200.001\n");
    folder.write("limits.toml", &loose);
    let place = "limits.toml:3: pulse.width_us: expected at most the hard limit 200";
    refused_with(&["run", "--bench", &bench], &[place]);
    let tight = format!("{heading}pulse.width_us = 100.0\n");
    folder.write("limits.toml", &tight);
    let said = hil(&["run", "--illusion", "balanced", "--bench", &bench, "--json"]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    let summary: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert!(summary["limiter_events"].as_u64().unwrap() > 0);
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
    let start: Vec<_> = good.lines().take(8).collect();
    for (text, words) in [
        (
            good.replacen(&format!("{third}\n"), "1,2,3\n", 1),
            &["f.csv:3", "48 columns", "found 3"][..],
        ),
        (start.join("\n"), &["f.csv", "expected", "rows", "found 7"]),
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
    refused_with(&pair, &["--replay", "2 files, one per module", "found 1"]);
}
