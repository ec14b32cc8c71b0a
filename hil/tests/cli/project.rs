//! A project of one's own, from an empty folder to a suite with goldens, and what changes it.

use super::*;

const SCENE: &str = "name = \"press\"\ndescription = \"a press\"\nlength_s = 2.5\nexpect.contacts_max = 1\n\
     [[touches]]\nstart_s = 0.8\npath = { kind = \"line\", points_mm = [[0.0, 0.0], [4.0, 0.0]], period_s = 4.0 }\n\
     force_n = { mean = 0.8, amplitude = 0.1 }\n";

#[test]
fn a_folder_is_a_suite_with_goldens_that_are_reviewed_without_cargo() {
    let folder = Folder::new("project");
    folder.write("press.toml", SCENE);
    folder.write(
        "strong.toml",
        "name = \"strong\"\ndescription = \"more current\"\ndrive.current_ma = 990\n",
    );
    let place = folder.path(".").display().to_string();
    let golden = folder.path("goldens").join("press@strong.schedule.snap");

    // Nothing is kept before it is accepted.
    let first = hil(&["test", &place]);
    assert_eq!(first.status, Some(0), "{}{}", first.out, first.err);
    assert!(
        first.out.contains("1 trial on strong (emulated)"),
        "{}",
        first.out
    );
    assert!(!golden.exists());
    let accepted = good(&["test", &place, "--accept"]);
    assert!(golden.is_file());
    let wrote: Vec<&str> = accepted.lines().filter(|l| l.contains("wrote ")).collect();
    assert_eq!(wrote.len(), 2, "{accepted}");
    assert!(
        wrote[0].ends_with("press@strong.schedule.snap"),
        "{accepted}"
    );
    assert!(
        !good(&["test", &place, "--accept"]).contains("wrote "),
        "what says the same stays"
    );
    let held = good(&["test", &place]);
    assert!(held.contains("golden schedule and contacts"), "{held}");

    // A scene that does something else is told by its golden, waits, and is remembered.
    folder.write("press.toml", &SCENE.replace("mean = 0.8", "mean = 0.5"));
    let page = folder.path("trials.html").display().to_string();
    let changed = hil(&["test", &place, "--html", &page]);
    assert_eq!(changed.status, Some(1));
    assert!(
        changed.out.contains("FAILED")
            && changed.out.contains("press@strong.schedule.snap: ")
            && changed.out.contains("`hil review --goldens "),
        "{}",
        changed.out
    );
    assert!(fs::read_to_string(&page).unwrap().contains("FAILED"));
    let again = hil(&["test", &place, "--last-failed"]);
    assert!(
        again.out.contains("1 trial on") && again.status == Some(1),
        "{}",
        again.out
    );
    good(&[
        "review",
        "--goldens",
        &place,
        "accept",
        "--why",
        "a lighter finger",
    ]);
    assert!(
        fs::read_to_string(&golden)
            .unwrap()
            .contains("a lighter finger")
    );
    good(&["test", &place]);
    good(&["test", &place, "--last-failed"]);

    // A golden that cannot be read is no golden that agrees.
    let kept = fs::read(&golden).unwrap();
    fs::write(&golden, b"---\nsource: x\n---\npalpate \xFF\n").unwrap();
    let torn = hil(&["test", &place]);
    assert_eq!(torn.status, Some(1), "{}", torn.out);
    assert!(torn.out.contains("UTF-8"), "{}", torn.out);
    fs::write(&golden, kept).unwrap();

    // Known failures of the folder are found in it.
    folder.write("press.toml", SCENE);
    let known = "[[quarantine]]\ntrial = \"press\"\nreason = \"a heavier finger, on purpose\"\n";
    folder.write("quarantine.toml", known);
    let said = good(&["test", &place]);
    assert!(
        said.contains("QUARANTINED") && said.contains("on purpose"),
        "{said}"
    );
}

#[test]
fn a_folder_in_which_nothing_is_tested_fails() {
    let folder = Folder::new("project-empty");
    let place = folder.path(".").display().to_string();
    let said = hil(&["test", &place]);
    assert_eq!(said.status, Some(1), "{}", said.out);
    assert!(
        said.out
            .contains("INCOMPLETE: 0 passed, 0 failed; nothing was tested"),
        "{}",
        said.out
    );
    refused_with(
        &["test", "idle", "--last-failed"],
        &["--last-failed", "folder"],
    );
}

#[test]
fn trials_side_by_side_are_told_in_order_with_the_same_results() {
    let timeless = |jobs: &str| {
        let out = good(&["test", "sphere", "--jobs", jobs]);
        let line = |l: &str| {
            l.split_whitespace()
                .filter(|w| w.parse::<f64>().is_err())
                .collect::<Vec<_>>()
                .join(" ")
        };
        // Which took longest is the machine's business.
        let same = out.lines().filter(|l| !l.starts_with("slowest: "));
        same.map(line).collect::<Vec<_>>()
    };
    assert_eq!(timeless("1"), timeless("4"));
}

/// A golden that nothing is held against looks like one that agrees.
#[test]
fn a_golden_that_no_trial_claims_fails() {
    let folder = Folder::new("project-unclaimed");
    folder.write("press.toml", SCENE);
    let place = folder.0.display().to_string();
    good(&["test", &place, "--accept"]);
    // The scene has another name now.
    fs::rename(folder.path("press.toml"), folder.path("presses.toml")).unwrap();
    let said = hil(&["test", &place]);
    assert_eq!(said.status, Some(1), "{}", said.out);
    for part in [
        "press.contacts.snap, ",
        "no trial claims it: no scene `press.toml` is here; did you mean `presses`?",
        "FAILED: 1 passed, 1 failed",
    ] {
        assert!(said.out.contains(part), "{part}: {}", said.out);
    }
    let list = good(&["test", &place, "--list"]);
    assert_eq!(list, "press                      on emulated\n");
    // Fewer scenes are tried on purpose, but this one is gone.
    assert_eq!(hil(&["test", &place, "--filter", "pr"]).status, Some(1));
    fs::rename(folder.path("presses.toml"), folder.path("press.toml")).unwrap();
    good(&["test", &place]);
    assert!(
        good(&["test", &place, "--list"]).contains("golden schedule and contacts"),
        "a scene that is back is held"
    );
    // A bench in the folder replaces the one that ships.
    let bench = "name = \"strong\"\ndescription = \"more current\"\ndrive.current_ma = 990\n";
    folder.write("strong.toml", bench);
    let said = hil(&["test", &place]);
    assert_eq!(said.status, Some(1), "{}", said.out);
    for part in [
        "trials run on strong; `hil test .. --bench emulated` holds it",
        "held by no golden of this bench; there is press",
    ] {
        assert!(said.out.contains(part), "{part}: {}", said.out);
    }
    let json = hil(&["test", &place, "--json"]).out;
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (&json["verdict"], &json["bench"]),
        (&"failed".into(), &"strong".into())
    );
    assert_eq!(json["trials"][1]["trial"], "press");
    // The choice of a bench is the user's.
    good(&["test", &place, "--bench", "emulated"]);
    good(&["test", &place, "--bench", "strong"]);
    // What another program keeps there is its own business.
    fs::remove_file(folder.path("strong.toml")).unwrap();
    let other = "---\nsource: tests/mine.rs\n---\nhello\n";
    folder.write("goldens/mine.schedule.snap", other);
    good(&["test", &place]);
}

#[test]
fn a_wrong_scene_stops_no_other() {
    let folder = Folder::new("project-wrong");
    folder.write("press.toml", SCENE);
    folder.write("wrong.toml", &SCENE.replace("length_s", "lenght_s"));
    folder.write("torn.toml", &format!("{SCENE}\n[["));
    let place = folder.0.display().to_string();
    let xml = folder.path("t.xml").display().to_string();
    let said = hil(&["test", &place, "--junit", &xml]);
    assert_eq!(said.status, Some(1), "{}{}", said.out, said.err);
    for part in [
        "OK              press",
        "wrong.toml:3: lenght_s",
        "did you mean `length_s`?",
        "expected valid TOML",
        "FAILED: 1 passed, 2 failed",
    ] {
        assert!(said.out.contains(part), "{part}: {}", said.out);
    }
    let xml = folder.text("t.xml");
    assert!(
        xml.contains("<testsuite name=\"files\" tests=\"2\" failures=\"0\" errors=\"2\"")
            && xml.matches("<error message=").count() == 2,
        "{xml}"
    );
    // A bench that is wrong is no reason to try the scenes on another one.
    folder.write(
        "bench.toml",
        "name = \"b\"\ndescription = \"b\"\ndrive.curent_ma = 9\n",
    );
    refused_with(
        &["test", &place],
        &["bench.toml:3: drive.curent_ma", "current_ma"],
    );
    // Nothing but wrong files is a wrong command line.
    fs::remove_file(folder.path("press.toml")).unwrap();
    fs::remove_file(folder.path("bench.toml")).unwrap();
    assert_eq!(hil(&["test", &place]).status, Some(2));
}

/// As Git leaves them on Windows, and editors.
#[test]
fn goldens_behind_a_mark_with_other_line_ends_hold() {
    let folder = Folder::new("project-mark");
    folder.write("press.toml", SCENE);
    let place = folder.0.display().to_string();
    good(&["test", &place, "--accept"]);
    for kind in ["schedule", "contacts"] {
        let name = format!("goldens/press.{kind}.snap");
        let text = format!("\u{FEFF}{}", folder.text(&name).replace('\n', "\r\n"));
        folder.write(&name, &text);
    }
    let held = good(&["test", &place]);
    assert!(held.contains("golden schedule and contacts"), "{held}");
    folder.write("press.toml", &SCENE.replace("mean = 0.8", "mean = 0.5"));
    assert_eq!(hil(&["test", &place]).status, Some(1));
    good(&["review", "--goldens", &place, "accept"]);
    good(&["test", &place]);
}
