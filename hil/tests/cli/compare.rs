//! `hil compare`: summaries, tables and a folder of earlier summaries.

use serde_json::Value;

use super::*;

fn summary(folder: &Folder, name: &str, more: &[&str]) {
    let args = [&["run", "sphere-along", "--json"], more].concat();
    folder.write(name, &good(&args));
}

#[test]
fn two_summaries_differ_figure_by_figure() {
    let folder = Folder::new("compare");
    summary(&folder, "a.json", &[]);
    summary(&folder, "again.json", &[]);
    summary(&folder, "b.json", &["--set", "illusion.soa_ms=119"]);
    let same = hil_in(&folder.0, &["compare", "a.json", "again.json"]);
    assert_eq!(
        (same.status, same.err.as_str()),
        (Some(0), ""),
        "{}",
        same.out
    );
    assert!(
        same.out.starts_with("OK\n") && same.out.contains("\n0 of "),
        "{}",
        same.out
    );
    let other = hil_in(&folder.0, &["compare", "a.json", "b.json"]);
    assert_eq!((other.status, other.err.as_str()), (Some(1), ""));
    assert!(
        other.out.starts_with("FAILED: ") && other.out.contains("felt error RMSE, all onsets mm"),
        "{}",
        other.out
    );
    for part in [
        "felt level over threshold dB",
        " dB\n",
        " values differ; --long lists them",
    ] {
        assert!(other.out.contains(part), "{part}: {}", other.out);
    }
    let decibels = |out: &str| {
        let lines = out.lines().skip(1).filter(|line| line.contains(" dB"));
        lines.filter(|line| line.contains('%')).count()
    };
    assert_eq!(decibels(&other.out), 0, "{}", other.out);
    assert!(other.out.lines().count() <= 20, "{}", other.out);
    let long = hil_in(&folder.0, &["compare", "a.json", "b.json", "--long"]);
    assert!(long.out.contains("felt.states["), "{}", long.out);
    let json = hil_in(&folder.0, &["compare", "a.json", "b.json", "--json"]);
    let json: Value = serde_json::from_str(&json.out).unwrap();
    assert_eq!(json["verdict"], "failed");
    assert_eq!(json["named"][0]["key"], "felt_level_db");
    let figures: Vec<&str> = json["differences"]
        .as_array()
        .unwrap()
        .iter()
        .map(|d| d["figure"].as_str().unwrap())
        .collect();
    assert!(
        figures.contains(&"felt_error_mm.rmse") && !figures.contains(&"wall_s"),
        "{figures:?}"
    );
    let wide = hil_in(
        &folder.0,
        &[
            "compare",
            "a.json",
            "b.json",
            "--tolerance-percent",
            "100",
            "--quiet",
        ],
    );
    assert_eq!(
        (wide.status, wide.out.as_str()),
        (Some(0), ""),
        "{}",
        wide.err
    );
}

#[test]
fn two_tables_are_compared_run_by_run() {
    let folder = Folder::new("compare-tables");
    let sweep = |out: &str, current: &str| {
        let set = format!("bench.drive.current_ma={current}");
        let args = [
            "sweep",
            "sphere-along",
            "--set",
            "length_s=2",
            "--set",
            &set,
            "--seeds",
            "1,2",
            "--out",
            out,
            "--quiet",
        ];
        assert_eq!(hil_in(&folder.0, &args).status, Some(0));
    };
    sweep("a.csv", "800,900");
    sweep("b.jsonl", "900,800");
    sweep("c.csv", "800");
    // Another form and order are no difference.
    let same = hil_in(&folder.0, &["compare", "a.csv", "b.jsonl"]);
    assert_eq!(same.status, Some(0), "{}{}", same.out, same.err);
    let fewer = hil_in(&folder.0, &["compare", "a.csv", "c.csv"]);
    assert_eq!(fewer.status, Some(1));
    assert!(
        fewer
            .out
            .starts_with("INCOMPLETE: 2 of 4 runs are not in the second table"),
        "{}",
        fewer.out
    );
    // What another version computed.
    let text = folder.text("a.csv");
    let own = concat!(",", env!("CARGO_PKG_VERSION"), ",ok,");
    assert!(text.contains(own), "{text}");
    let text = text.replace(own, ",0.0.9,ok,");
    folder.write("d.csv", &text);
    assert_eq!(
        hil_in(&folder.0, &["compare", "a.csv", "d.csv"]).status,
        Some(0)
    );
    summary(&folder, "s.json", &[]);
    refused_with(
        &[
            "compare",
            &folder.path("a.csv").display().to_string(),
            &folder.path("s.json").display().to_string(),
        ],
        &["s.json: expected a table of a sweep", "found a summary"],
    );
}

#[test]
fn a_folder_of_summaries_gives_trends() {
    let folder = Folder::new("compare-trends");
    let place = folder.0.display().to_string();
    refused_with(&["compare", &place], &["summaries", "found none"]);
    let dated = |name: &str, date: &str, more: &[&str]| {
        summary(&folder, name, more);
        let mut object: Value = serde_json::from_str(&folder.text(name)).unwrap();
        object["date"] = date.into();
        folder.write(name, &object.to_string());
    };
    dated(
        "new.json",
        "2026-03-01 10:00 UTC",
        &["--set", "illusion.soa_ms=120"],
    );
    fs::create_dir_all(folder.path("old")).unwrap();
    dated("old/summary.json", "2026-01-01 10:00 UTC", &[]);
    dated("seed.json", "2026-02-01 10:00 UTC", &["--seed", "5"]);
    folder.write("package.json", "{\"name\": \"no summary\"}");
    let page = folder.path("t.html").display().to_string();
    let said = hil(&["compare", &place, "--html", &page]);
    assert_eq!(said.status, Some(1), "{}", said.err);
    assert!(
        said.out
            .starts_with("FAILED: sphere-along on emulated, seed 1: "),
        "{}",
        said.out
    );
    let (old, new) = (
        said.out.find("old/summary.json").unwrap(),
        said.out.find("new.json").unwrap(),
    );
    assert!(old < new, "{}", said.out);
    let page = folder.text("t.html");
    assert!(page.contains("felt error RMSE, all onsets [mm]") && page.contains("seed 5"));
    fs::remove_file(folder.path("new.json")).unwrap();
    let said = hil(&["compare", &place]);
    assert_eq!(said.status, Some(0), "{}", said.out);
}

#[test]
fn folders_of_a_run_stand_for_what_is_in_them() {
    let folder = Folder::new("compare-folders");
    let run = |out: &str, more: &[&str]| {
        let args = [&["run", "sphere-along", "--quiet", "-o", out], more].concat();
        assert_eq!(hil_in(&folder.0, &args).status, Some(0));
    };
    run("monday", &[]);
    run("tuesday", &["-s", "illusion.soa_ms=119"]);
    run("again", &[]);
    let same = hil_in(&folder.0, &["compare", "monday", "again"]);
    assert_eq!(same.status, Some(0), "{}{}", same.out, same.err);
    let page = folder.path("c.html");
    let other = hil_in(
        &folder.0,
        &["compare", "monday", "tuesday", "--html", "c.html"],
    );
    assert_eq!(other.status, Some(1), "{}", other.err);
    let page = fs::read_to_string(page).unwrap();
    for part in ["felt level over threshold [dB]", "tuesday", "stimuli"] {
        assert!(page.contains(part), "{part}");
    }
    let same = hil_in(&folder.0, &["diff", "monday", "again"]);
    assert_eq!(
        (same.status, &*same.out),
        (
            Some(0),
            "OK: sphere-along: no difference\nOK: contacts: no difference\n"
        ),
        "{}",
        same.err
    );
    let other = hil_in(&folder.0, &["diff", "monday", "tuesday"]);
    assert_eq!(other.status, Some(1), "{}", other.err);
    assert!(
        other.out.starts_with("FAILED: sphere-along: ") && other.out.contains("\nOK: contacts"),
        "{}",
        other.out
    );
    let one = hil_in(&folder.0, &["diff", "monday", "again/contacts.csv"]);
    assert_eq!(&*one.out, "OK: contacts: no difference\n", "{}", one.err);
    let json = hil_in(&folder.0, &["diff", "monday", "tuesday", "--json"]);
    let json: Value = serde_json::from_str(&json.out).unwrap();
    assert!(json.as_array().is_some_and(|all| !all.is_empty()), "{json}");
    // A summary has no digit that a binary fraction left behind.
    let summary = folder.text("monday/summary.json");
    let long = |word: &&str| word.trim_end_matches([',', '}']).len() > 15;
    let numbers = summary
        .split_whitespace()
        .filter(|w| w.contains('.') && !w.contains('"'));
    assert_eq!(numbers.filter(long).collect::<Vec<_>>(), Vec::<&str>::new());
}
