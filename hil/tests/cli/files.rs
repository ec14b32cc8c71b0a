//! `hil list`, `check`, `new` and `export`: files of one's own, from nothing to a run.

use serde_json::Value;

use super::*;

#[test]
fn everything_built_in_and_in_the_folder_is_listed_with_a_line() {
    let folder = Folder::new("list");
    let heading = "name = \"mine\"\ndescription = \"my own pad\"\n";
    folder.write("mine.toml", &format!("{heading}length_s = 3.0\n"));
    folder.write("Cargo.toml", "[package]\nname = \"stranger\"\n");
    let said = hil_in(&folder.0, &["list"]);
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
    for name in palpate_fixtures::scene_names().chain(palpate_fixtures::wire_names()) {
        let line = said
            .out
            .lines()
            .find(|l| l.trim_start().starts_with(&format!("{name} ")));
        let words = line.map_or(0, |line| line.split_whitespace().count());
        assert!(words > 3, "{name}: {line:?}");
    }
    assert!(
        said.out.contains("my own pad (in this folder)"),
        "{}",
        said.out
    );
    assert!(!said.out.contains("stranger"), "{}", said.out);
    assert!(said.out.contains("three-nearest"), "{}", said.out);

    let wires = hil_in(&folder.0, &["list", "wires"]).out;
    assert_eq!(
        wires.lines().count(),
        palpate_fixtures::wire_names().count()
    );
    let json = hil_in(&folder.0, &["list", "scenes", "illusions", "--json"]).out;
    let list: Vec<Value> = serde_json::from_str(&json).unwrap();
    let mine = list.iter().find(|l| l["name"] == "mine.toml").unwrap();
    assert_eq!(
        (&mine["kind"], &mine["description"]),
        (&"scene".into(), &"my own pad".into())
    );
    assert!(
        list.iter()
            .any(|l| l["kind"] == "illusion" && l["name"] == "balanced")
    );
    refused_with(&["list", "scene"], &["scenes"]);
}

#[test]
fn check_says_everything_at_once() {
    let folder = Folder::new("check");
    let bad = "name = \"bad\"\ndescription = \"d\"\nlenght_s = 3.0\ncompression.kc = 0\nlayout = \"uskin4x4\"\n";
    folder.write("bad.toml", bad);
    folder.write("good.toml", palpate_fixtures::scene("idle").unwrap());
    let said = hil_in(&folder.0, &["check", "bad.toml", "good.toml"]);
    assert_eq!(said.status, Some(1));
    let lines: Vec<&str> = said.out.lines().collect();
    assert_eq!(lines.len(), 4, "{}", said.out);
    for (line, words) in lines.iter().zip([
        &["bad.toml:3: lenght_s", "did you mean `length_s`?"][..],
        &["bad.toml:4: compression.kc", "from 1 to 1024, found 0"],
        &["bad.toml:5: layout", "did you mean `uskin-4x4`?"],
        &["good.toml: a scene, nothing wrong"],
    ]) {
        for word in words {
            assert!(line.contains(word), "no `{word}` in {line}");
        }
    }
    assert_eq!(said.err, "error: 3 errors in 1 of 2 files\n");
    assert_eq!(
        hil_in(&folder.0, &["check", "--quiet", "good.toml"]).out,
        ""
    );

    let said = hil_in(&folder.0, &["check", "--json", "bad.toml", "good.toml"]);
    let files: Vec<Value> = serde_json::from_str(&said.out).unwrap();
    assert_eq!(files[0]["errors"][1]["key"], "compression.kc");
    assert_eq!(
        (&files[0]["errors"][1]["line"], &files[0]["complete"]),
        (&4.into(), &true.into())
    );
    assert_eq!(
        (
            &files[1]["kind"],
            files[1]["errors"].as_array().unwrap().len()
        ),
        (&"scene".into(), 0)
    );
    let gone = hil_in(&folder.0, &["check", "gone.toml"]);
    assert_eq!((gone.status, gone.out.as_str()), (Some(2), ""));
}

#[test]
fn a_scene_is_held_against_the_benches_beside_it() {
    let folder = Folder::new("check-fit");
    let scene =
        "name = \"s\"\ndescription = \"d\"\nlength_s = 3.0\n[map]\ndisplay = \"thimble-8\"\n";
    folder.write("s.toml", scene);
    folder.write("b.toml", palpate_fixtures::bench("three-in-line").unwrap());
    assert_eq!(hil_in(&folder.0, &["check", "s.toml"]).status, Some(0));
    assert_eq!(hil_in(&folder.0, &["check", "b.toml"]).status, Some(0));
    let both = hil_in(&folder.0, &["check", "s.toml", "b.toml"]);
    assert_eq!(both.status, Some(1));
    let told = "s.toml:5: map.display: expected the bench's display";
    assert!(both.out.contains(told), "{}", both.out);
}

#[test]
fn what_new_writes_is_checked_and_runs() {
    let folder = Folder::new("new");
    let good = |args: &[&str]| {
        let said = hil_in(&folder.0, args);
        assert_eq!(
            (said.status, said.err.as_str()),
            (Some(0), ""),
            "{args:?}\n{}",
            said.out
        );
        said.out
    };
    good(&[
        "new",
        "layout",
        "pad",
        "--rows",
        "6",
        "--columns",
        "5",
        "--pitch-mm",
        "3",
    ]);
    good(&[
        "new",
        "layout",
        "thimble",
        "--kind",
        "display",
        "--rows",
        "3",
        "--columns",
        "2",
    ]);
    good(&[
        "new",
        "wire",
        "thin",
        "--diameter-um",
        "50",
        "--length-mm",
        "6",
    ]);
    good(&[
        "new",
        "bench",
        "emu",
        "--display",
        "thimble.toml",
        "--wire",
        "thin.toml",
        "--current-ma",
        "600",
    ]);
    let real = [
        "new",
        "bench",
        "real",
        "--can",
        "can0",
        "--i2c",
        "/dev/i2c-1",
    ];
    good(&real);
    for (name, path) in [
        ("plain", "line"),
        ("round", "circle"),
        ("rest", "hold"),
        ("empty", "none"),
    ] {
        let text = "says \"so\"";
        good(&[
            "new",
            "scene",
            name,
            "--path",
            path,
            "--length-s",
            "3",
            "--description",
            text,
        ]);
    }
    good(&[
        "new",
        "scene",
        "own",
        "--layout",
        "pad.toml",
        "--out",
        "other.toml",
    ]);
    let files: Vec<String> = folder
        .names()
        .into_iter()
        .filter(|n| n.ends_with(".toml"))
        .collect();
    assert_eq!(files.len(), 10);
    for file in &files {
        let text = folder.text(file);
        let schema = text
            .strip_prefix("#:schema ")
            .unwrap()
            .lines()
            .next()
            .unwrap();
        assert!(folder.path(schema).is_file(), "{file}: {schema}");
        let said = good(&["check", file]);
        assert!(said.contains("nothing wrong"), "{said}");
    }
    for scene in ["plain.toml", "round.toml", "rest.toml", "other.toml"] {
        let summary: Value = serde_json::from_str(&good(&["run", scene, "--json"])).unwrap();
        assert!(
            summary["contacts"].as_u64().unwrap() > 50,
            "{scene}: {summary}"
        );
        let said = good(&["test", scene]);
        assert!(said.contains("1 passed, 0 failed"), "{said}");
    }
    good(&["run", "plain.toml", "--bench", "emu.toml", "--quiet"]);
}

#[test]
fn new_overwrites_nothing_and_says_what_it_wants() {
    let folder = Folder::new("new-refuses");
    folder.write("mine.toml", "precious\n");
    let refused = |args: &[&str], words: &[&str]| {
        let said = hil_in(&folder.0, args);
        assert_eq!(
            (said.status, said.out.as_str()),
            (Some(2), ""),
            "{}",
            said.err
        );
        for word in words {
            assert!(said.err.contains(word), "no `{word}` in {}", said.err);
        }
    };
    refused(&["new", "scene", "mine"], &["mine.toml", "--force"]);
    assert_eq!(
        (folder.text("mine.toml").as_str(), folder.names().len()),
        ("precious\n", 1)
    );
    refused(&["new", "scene", "My Scene"], &["lower-case letters"]);
    refused(
        &["new", "scene", "a", "--layout", "uskin4x4"],
        &["did you mean `uskin-4x4`?"],
    );
    refused(&["new", "scene", "a", "--layout", "thimble-8"], &["sensor"]);
    refused(
        &["new", "bench", "a", "--display", "uskin-4x4"],
        &["display"],
    );
    refused(&["new", "wire", "a", "--resistance-ohm", "0.5"], &["1.14"]);
    refused(&["new", "scne", "a"], &["scene"]);
    assert_eq!(folder.names(), ["mine.toml"]);
    assert_eq!(
        hil_in(&folder.0, &["new", "scene", "mine", "--force"]).status,
        Some(0)
    );
    assert!(folder.text("mine.toml").starts_with("#:schema"));
}

#[test]
fn joints_of_a_recording_are_those_of_its_replay() {
    let folder = Folder::new("joints");
    let good = |args: &[&str]| {
        let said = hil_in(&folder.0, args);
        assert_eq!((said.status, said.err.as_str()), (Some(0), ""), "{args:?}");
    };
    let scene = palpate_fixtures::scene("sphere-along").unwrap();
    let joint = "[[joints]]\nname = \"mcp\"\npoints_s_deg = [[3.0, 0.0], [5.0, 40.0]]\n";
    folder.write("s.toml", &format!("{scene}\n{joint}"));
    good(&["run", "s.toml", "--quiet", "--record", "a.mcap"]);
    let replay = ["run", "sphere-along", "--quiet", "--replay", "a.mcap"];
    good(&[&replay[..], &["--record", "b.mcap"]].concat());
    let joints = ["a.mcap", "b.mcap"].map(|name| {
        let bytes = fs::read(folder.0.join(name)).unwrap();
        palpate_records::mcap::read(&bytes).unwrap().joints
    });
    let [of_scene, of_replay] = joints.map(|mut all| all.remove("mcp").unwrap());
    assert!(of_scene.len() > 500 && of_replay.len() > 500);
    let at = |t_ns: u64| (t_ns as f64 * 1e-9 - 3.0).clamp(0.0, 2.0) * 20.0;
    for (t_ns, deg) in of_scene.iter().chain(&of_replay) {
        assert!((deg - at(*t_ns)).abs() < 0.25, "{deg} at {t_ns} ns"); // 20 degrees per second, a frame every 10 ms
    }
}

/// Columns of a table of contacts but the times, which a recording counts from its first row.
fn timeless(csv: &str) -> Vec<String> {
    let row = |line: &str| {
        let mut columns: Vec<&str> = line.split(',').collect();
        columns.remove(1);
        columns.join(",")
    };
    csv.lines().map(row).collect()
}

#[test]
fn exported_taxels_replay_to_the_contacts_of_the_scene() {
    let folder = Folder::new("export");
    let good = |args: &[&str]| {
        let said = hil_in(&folder.0, args);
        assert_eq!((said.status, said.err.as_str()), (Some(0), ""), "{args:?}");
        said.out
    };
    good(&["export", "taxels", "sphere-along", "--out", "t.csv"]);
    good(&["run", "sphere-along", "--quiet", "--record", "a.csv"]);
    good(&[
        "run",
        "sphere-along",
        "--quiet",
        "--replay",
        "t.csv",
        "--record",
        "b.csv",
    ]);
    let (a, b) = (
        timeless(&folder.text("a.csv")),
        timeless(&folder.text("b.csv")),
    );
    assert!(a.len() > 500);
    assert_eq!(a, b);
    // A recording is replaced, another file is not.
    good(&[
        "export",
        "taxels",
        "sphere-along",
        "--out",
        "t.csv",
        "--seed",
        "2",
    ]);
    folder.write("notes.csv", "mine\n");
    let said = hil_in(
        &folder.0,
        &["export", "taxels", "idle", "--out", "notes.csv"],
    );
    assert_eq!(said.status, Some(2));
    assert!(said.err.contains("--force") && folder.text("notes.csv") == "mine\n");
    // One file per module.
    good(&[
        "export",
        "taxels",
        "allegro-four-buses",
        "--out",
        "hand.csv",
        "--set",
        "length_s=2",
        "--set",
        "touches=[]",
        "--set",
        "faults=[]",
        "--set",
        "expect={}",
    ]);
    assert!(folder.path("hand-0.csv").is_file() && folder.path("hand-14.csv").is_file());
    refused_with(
        &["export", "taxels", "nowhere", "--out", "x.csv"],
        &["nowhere", "hil list scenes"],
    );
}

#[test]
fn files_of_an_earlier_version_are_migrated_beside_or_in_place() {
    let folder = Folder::new("migrate");
    let old = "name = \"old\"\ndescription = \"d\" # mine\nlength_s = 2.0\nillusion.smallest_step = 0.2\n";
    folder.write("old.toml", old);
    assert_eq!(hil_in(&folder.0, &["check", "old.toml"]).status, Some(1));
    let said = hil_in(&folder.0, &["check", "--migrate", "old.toml"]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert!(
        said.err.contains("old.toml:4: `illusion.smallest_step`"),
        "{}",
        said.err
    );
    assert_eq!(folder.text("old.toml"), old);
    assert!(folder.text("old.migrated.toml").contains("\"d\" # mine"));
    let again = hil_in(&folder.0, &["check", "--migrate", "old.toml"]);
    assert_eq!(again.status, Some(2), "{}", again.err);
    let said = hil_in(&folder.0, &["check", "--migrate", "--force", "old.toml"]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert_eq!(folder.text("old.toml.old"), old);
    assert_eq!(hil_in(&folder.0, &["check", "old.toml"]).status, Some(0));
}

#[test]
fn lists_and_new_files_reach_into_folders() {
    let folder = Folder::new("reach");
    fs::create_dir_all(folder.path("mine/scenes")).unwrap();
    let said = hil_in(&folder.0, &["new", "scene", "own", "--out", "mine/scenes"]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert!(folder.path("mine/scenes/own.toml").is_file());
    let said = hil_in(&folder.0, &["list", "scenes", "--dir", "mine"]);
    assert!(said.out.contains("mine/scenes/own.toml"), "{}", said.out);
    let said = hil_in(&folder.0, &["list", "--dir", "nowhere"]);
    assert_eq!(said.status, Some(2), "{}", said.err);
}
