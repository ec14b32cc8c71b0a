//! `hil test`: trials, what a bench lacks, quarantine, JUnit.

use super::*;

#[test]
fn every_shipped_scene_passes_on_the_emulated_bench() {
    let out = good(&["test"]);
    let lines: Vec<&str> = out.lines().collect();
    let scenes = palpate_fixtures::scene_names().count();
    let stages = [
        format!("{} trials on emulated (emulated), seed 1", scenes - 8),
        "1 trial on allegro-hand (emulated), seed 1".to_owned(),
        "1 trial on lra-grid-4x3 (emulated), seed 1".to_owned(),
        "1 trial on voice-coil-8 (emulated), seed 1".to_owned(),
        "1 trial on lra-8 (emulated), seed 1".to_owned(),
        "2 trials on unit (emulated), seed 1".to_owned(),
        "1 trial on ten-fingers (emulated), seed 1".to_owned(),
        "1 trial on warm (emulated), seed 1".to_owned(),
    ];
    let told = lines.iter().filter(|l| l.ends_with(", seed 1"));
    assert_eq!(told.collect::<Vec<_>>(), stages.iter().collect::<Vec<_>>());
    assert_eq!(
        lines.last().unwrap(),
        &format!("OK: {scenes} passed, 0 failed")
    );
    let along = lines.iter().find(|l| l.contains("sphere-along ")).unwrap();
    assert!(
        along.contains("path error RMSE 0.194 mm <= 0.500 mm, contacts in a frame 1 <= 1"),
        "{along}"
    );
}

/// sphere-along with a path error that nothing reaches.
fn failing(folder: &Folder) -> String {
    let scene = palpate_fixtures::scene("sphere-along").unwrap();
    let strict = scene.replace("path_rmse_mm = 0.5", "path_rmse_mm = 0.001");
    assert_ne!(strict, scene);
    folder.write("strict.toml", &strict).display().to_string()
}

#[test]
fn a_failed_trial_says_what_was_expected_with_exit_1() {
    let folder = Folder::new("test-fails");
    let junit = folder.path("r.xml").display().to_string();
    let said = hil(&["test", &failing(&folder), "--junit", &junit]);
    assert_eq!(said.status, Some(1));
    let told = "path error RMSE: expected <= 0.001 mm, found 0.194 mm";
    assert!(said.out.contains(told), "{}", said.out);
    assert!(said.err.contains("0 passed, 1 failed"), "{}", said.err);
    let xml = folder.text("r.xml");
    assert!(
        xml.contains("<testsuite name=\"emulated\" tests=\"1\" failures=\"1\""),
        "{xml}"
    );
    assert!(
        xml.contains("<property name=\"path error RMSE limit\" value=\"&lt;= 0.001 mm\"/>"),
        "{xml}"
    );
    assert!(xml.contains("<property name=\"path error RMSE unit\" value=\"mm\"/>"));
    assert!(xml.contains("<property name=\"skin at 0.1 mm limit\" value=\"&lt;= 43.000 C\"/>"));
    assert!(xml.contains("<failure message=\"path error RMSE: expected &lt;= 0.001 mm"));
}

#[test]
fn a_quarantined_trial_may_fail_and_needs_a_reason() {
    let folder = Folder::new("test-quarantine");
    let scene = failing(&folder);
    let list = |text: &str| folder.write("q.toml", text).display().to_string();
    let known = list("[[quarantine]]\ntrial = \"sphere-along\"\nreason = \"issue 31\"\n");
    let said = hil(&["test", &scene, "--quarantine", &known]);
    assert_eq!(said.status, Some(0));
    assert!(
        said.out.contains("QUARANTINED     sphere-along"),
        "{}",
        said.out
    );
    assert!(said.out.contains("issue 31") && said.out.contains("0 failed, 1 quarantined"));
    // One that passes should be taken out; one on another bench is none.
    let said = hil(&["test", "sphere-along", "--quarantine", &known]);
    assert!(said.out.contains("take it out"), "{}", said.out);
    let elsewhere =
        list("[[quarantine]]\ntrial = \"sphere-along\"\nbench = \"x\"\nreason = \"y\"\n");
    assert_eq!(
        hil(&["test", &scene, "--quarantine", &elsewhere]).status,
        Some(1)
    );
    let none = list("[[quarantine]]\ntrial = \"sphere-along\"\nreason = \" \"\n");
    refused_with(&["test", "--quarantine", &none], &["q.toml:3", "reason"]);
    let unknown = list("[[quarantine]]\n\ntrial = \"tea\"\nreason = \"x\"\n");
    refused_with(
        &["test", "--quarantine", &unknown],
        &["q.toml:3", "tea", "sphere-along"],
    );
}

#[test]
fn a_bench_without_what_a_scene_wants_refuses_the_trial() {
    let said = hil(&["test", "wifi-outage", "--bench", "emulated"]);
    assert_eq!(said.status, Some(1), "{}", said.out);
    assert!(
        said.out.contains("REFUSED         wifi-outage"),
        "{}",
        said.out
    );
    let why = "the scene wants a driver unit, such as bench `unit` has";
    assert!(said.out.contains(why), "{}", said.out);
    assert!(
        said.err.contains("0 passed, 0 failed, 1 refused"),
        "{}",
        said.err
    );
    let json = good(&["test", "along", "--bench", "emulated", "--json"]);
    let all: serde_json::Value = serde_json::from_str(&json).unwrap();
    let trials = all["trials"].as_array().unwrap();
    let wifi = trials.iter().find(|t| t["trial"] == "sphere-along-wifi");
    assert_eq!(wifi.unwrap()["verdict"], "refused");
    assert_eq!(all["verdict"], "ok");
}

#[test]
fn what_is_not_felt_fails_a_trial_where_the_scene_expects_it() {
    let folder = Folder::new("test-unfelt");
    let scene = palpate_fixtures::scene("sphere-along").unwrap();
    let weak = scene.replace(
        "mean = 0.7, amplitude = 0.3",
        "mean = 0.001, amplitude = 0.0",
    );
    let bounds = weak.replace("path_rmse_mm = 0.5\n", "");
    let path = folder.write("weak.toml", &bounds).display().to_string();
    let junit = folder.path("r.xml").display().to_string();
    let said = good(&["test", &path, "--junit", &junit]);
    assert!(said.contains("NOT FELT        sphere-along"), "{said}");
    assert!(
        said.ends_with("OK: 0 passed, 0 failed, 1 not felt\n"),
        "{said}"
    );
    let why = "<system-out>NOT FELT: no reading of the touch rose above the contact threshold";
    assert!(folder.text("r.xml").contains(why));
    let strict = format!("{bounds}felt_share_min = 0.9\n");
    let path = folder.write("strict.toml", &strict).display().to_string();
    let said = hil(&["test", &path]);
    assert_eq!(said.status, Some(1));
    let why = "share of onsets felt: expected >= 90.000 %, found 0.000 %";
    assert!(said.out.contains(why), "{}", said.out);
}

#[test]
fn what_a_bench_lacks_is_named() {
    let folder = Folder::new("test-lacks");
    let scene = palpate_fixtures::scene("idle").unwrap();
    let other = format!("{scene}\n[map]\ndisplay = \"tactile-brush-4x3\"\n");
    let path = folder.write("other.toml", &other).display().to_string();
    let said = hil(&["test", &path]);
    assert_eq!(said.status, Some(1));
    let out = said.out;
    assert!(
        out.contains("SKIPPED         idle")
            && out.contains("the bench lacks display tactile-brush-4x3"),
        "{out}"
    );
    let free = scene.split("[expect]").next().unwrap();
    let path = folder.write("free.toml", free).display().to_string();
    let said = hil(&["test", &path]);
    assert_eq!(said.status, Some(1), "what tests nothing is no success");
    assert!(
        said.out.contains("no [expect] in the scene") && said.out.contains("nothing was tested")
    );
    refused_with(
        &["test", "no-such-scene"],
        &["no-such-scene", "hil list scenes"],
    );
}

#[test]
fn the_object_has_every_measurement_with_its_limit() {
    let out = good(&["test", "two-finger", "--json"]);
    let all: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(all["verdict"], "ok");
    assert_eq!(
        (&all["bench"], &all["source"]),
        (&"emulated".into(), &"emulated".into())
    );
    let trial = &all["trials"][0];
    assert_eq!(
        (&trial["trial"], &trial["verdict"]),
        (&"two-finger-press".into(), &"ok".into())
    );
    let measures = trial["measures"].as_array().unwrap();
    let contacts = measures
        .iter()
        .find(|m| m["name"] == "contacts in a frame")
        .unwrap();
    assert_eq!(
        (&contacts["value"], &contacts["limit"]),
        (&2.0.into(), &"<= 2".into())
    );
    let skin = measures
        .iter()
        .find(|m| m["name"] == "skin at 0.1 mm")
        .unwrap();
    assert_eq!(
        (&skin["unit"], &skin["limit"]),
        (&"C".into(), &"<= 43.000 C".into())
    );
    let quiet = hil(&["test", "two-finger", "--quiet"]);
    assert_eq!((quiet.status, quiet.out.as_str()), (Some(0), ""));
}

#[test]
fn a_single_run_is_checked_and_kept_as_a_golden_too() {
    let folder = Folder::new("run-junit");
    let path = |name: &str| folder.path(name).display().to_string();
    let (xml, snap) = (path("r.xml"), path("r.snap"));
    good(&["run", "idle", "--quiet", "--junit", &xml, "--record", &snap]);
    assert!(
        folder
            .text("r.xml")
            .contains("classname=\"emulated\" name=\"idle\"")
    );
    let shipped = include_str!("../../../fixtures/goldens/idle.schedule.snap");
    assert!(shipped.ends_with(&folder.text("r.snap")));
    let said = hil(&["run", &failing(&folder), "--quiet", "--junit", &xml]);
    assert_eq!(said.status, Some(1));
    assert!(
        said.err.contains("path error RMSE: expected <= 0.001 mm"),
        "{}",
        said.err
    );
    assert!(folder.text("r.xml").contains("failures=\"1\""));
}

#[test]
fn a_bench_that_is_not_there_ends_the_trials_with_exit_3() {
    let folder = Folder::new("test-no-bench");
    let xml = folder.path("r.xml").display().to_string();
    let bench = real_bench(&folder);
    let said = hil(&[
        "test",
        "s",
        "--bench",
        &bench,
        "--can",
        "nope0",
        "--i2c",
        "/dev/i2c-250",
        "--junit",
        &xml,
        "--retries",
        "3",
    ]);
    assert_eq!(said.status, Some(3), "{}{}", said.out, said.err);
    assert!(said.err.contains("the bench is not well: "), "{}", said.err);
    assert!(
        said.out.contains("the bench lacks touch (`real.touch`)"),
        "{}",
        said.out
    );
    assert!(folder.text("r.xml").contains("failures=\"1\""));
}

#[test]
fn a_key_of_scene_or_bench_is_set_for_every_trial_and_checked_like_the_file() {
    let strict = hil(&["test", "sphere-along", "--set", "expect.path_rmse_mm=0.001"]);
    assert_eq!(strict.status, Some(1), "{}", strict.err);
    assert!(
        strict.out.contains("expected <= 0.001 mm, found 0.194 mm"),
        "{}",
        strict.out
    );
    let weak = good(&["test", "idle", "--set", "bench.drive.current_ma=900"]);
    assert!(weak.contains("1 passed, 0 failed"), "{weak}");
    let unknown = ["test", "idle", "--set", "ilusion.alpha=0.1"];
    refused_with(&unknown, &["--set: ilusion", "did you mean `illusion`?"]);
    refused_with(
        &["test", "idle", "--set", "bench.drive.current_ma=9000"],
        &["from 1 to 5000 mA"],
    );
    refused_with(&["test", "sphere-alng"], &["did you mean `sphere-along`?"]);
}
