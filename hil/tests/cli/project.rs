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
    good(&["test", &place, "--accept"]);
    assert!(golden.is_file());
    good(&["test", &place]);

    // A scene that does something else is told by its golden, waits, and is remembered.
    folder.write("press.toml", &SCENE.replace("mean = 0.8", "mean = 0.5"));
    let page = folder.path("trials.html").display().to_string();
    let changed = hil(&["test", &place, "--html", &page]);
    assert_eq!(changed.status, Some(1));
    assert!(
        changed.out.contains("FAILED") && changed.out.contains("press@strong.schedule.snap: "),
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
        out.lines().map(line).collect::<Vec<_>>()
    };
    assert_eq!(timeless("1"), timeless("4"));
}
