//! Files and streams that the program writes: whole, or not there.

use std::fs::OpenOptions;

use serde_json::Value;

use super::*;

#[test]
fn a_schedule_is_a_header_and_sorted_integers() {
    let folder = Folder::new("schedule");
    let path = folder.path("s.jsonl").display().to_string();
    good(&["run", "--schedule", &path]);
    let text = folder.text("s.jsonl");
    let mut lines = text
        .lines()
        .map(|l| serde_json::from_str::<Value>(l).unwrap());
    let header = lines.next().unwrap();
    for key in ["version", "seed"] {
        assert!(header[key].is_u64(), "{header}");
    }
    for key in ["scene_digest", "limits_digest"] {
        assert!(header[key].is_string(), "{header}");
    }
    // Integers only: no number of the file has a fraction or an exponent.
    fn integers(value: &Value) -> bool {
        match value {
            Value::Number(n) => n.is_u64(),
            Value::Object(o) => o.values().all(integers),
            Value::Array(a) => a.iter().all(integers),
            _ => true,
        }
    }
    assert!(integers(&header));
    let (mut last, mut entries, mut offs) = ((0, 0, 0), 0, 0);
    for record in lines {
        assert!(integers(&record), "{record}");
        let number = |key: &str| {
            record[key]
                .as_u64()
                .unwrap_or_else(|| panic!("{key}: {record}"))
        };
        let (t, board) = (number("t_us"), number("board"));
        if record.get("channel").is_some() {
            let keys: Vec<_> = record.as_object().unwrap().keys().cloned().collect();
            assert_eq!(keys.len(), 10, "{record}");
            let key = (t, board, number("channel"));
            assert!(last <= key, "{last:?} before {record}");
            last = key;
            assert!(number("on") < 4096 && number("off") <= 4096, "{record}");
            assert!(number("requested") <= 4096);
            assert!(number("until_us") >= t, "{record}");
            assert!(record["reason"].is_null() || record["reason"].is_string());
            entries += 1;
        } else {
            assert!((last.0, last.1) <= (t, board), "{last:?} before {record}");
            last = (t, board, 0);
            if record.get("all_off").is_some() {
                assert!(record["all_off"].is_string(), "{record}");
                offs += 1;
            } else {
                assert!(record["pre_scale"].is_u64(), "{record}");
            }
        }
    }
    assert!(entries > 100, "{entries}");
    assert!(offs >= 2, "off at the start and at the end");
}

/// Several displays: the hand under the name given, and a page per finger that it leads to.
#[test]
fn a_hand_has_a_page_that_leads_to_its_fingers() {
    let folder = Folder::new("hand");
    let path = folder.path("r.html").display().to_string();
    let table = folder.path("c.csv").display().to_string();
    let hand = ["allegro-grasp", "--bench", "allegro-hand", "--quiet"];
    let written = ["--html", &path, "--record", &table];
    good(&[&["run"], &hand[..], &written].concat());
    let fingers = ["index", "middle", "ring", "thumb"];
    let page = folder.text("r.html");
    for finger in fingers {
        let file = format!("r-{finger}.html");
        assert_eq!(
            page.matches(&format!("href=\"./{file}\"")).count(),
            3,
            "{file}"
        );
        assert!(folder.text(&file).contains("<svg"));
    }
    let table = folder.text("c.csv");
    assert!(
        table.starts_with(
            "frame,time_us,module,contact,x_mm,y_mm,intensity,level,members,display\n"
        )
    );
    assert!(table.contains(",index\n") && table.contains(",thumb\n"));
    // Read again by what compares tables.
    let same = folder.path("c.csv").display().to_string();
    good(&["diff", &same, &same]);
}

#[test]
fn a_report_is_one_page_without_network() {
    let folder = Folder::new("report");
    let path = folder.path("r.html").display().to_string();
    good(&["run", "--html", &path]);
    assert_eq!(folder.names(), ["r.html"]);
    let page = folder.text("r.html");
    assert!(page.contains("<svg"));
    for outside in [
        "src=\"http",
        "href=\"http",
        "@import",
        "<script src",
        "url(http",
    ] {
        assert!(!page.contains(outside), "{outside}");
    }
}

#[test]
fn a_folder_gets_every_record_and_a_second_run_replaces_them() {
    let folder = Folder::new("out");
    let out = folder.path("a/b").display().to_string();
    for _ in 0..2 {
        good(&["run", "idle", "--out", &out]);
        let mut names: Vec<_> = fs::read_dir(&out)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        assert_eq!(
            names,
            [
                "contacts.csv",
                "contacts.schema.json",
                "report.html",
                "schedule.jsonl",
                "summary.json"
            ]
        );
    }
    let summary = fs::read_to_string(folder.path("a/b/summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["scene"], "idle");
}

#[test]
fn a_record_is_what_its_ending_says() {
    let folder = Folder::new("record");
    let path = |name: &str| folder.path(name).display().to_string();
    good(&[
        "run",
        "--record",
        &path("c.csv"),
        "--record",
        &path("s.jsonl"),
        "--schedule",
        &path("t.jsonl"),
    ]);
    assert_eq!(
        folder.names(),
        ["c.csv", "c.schema.json", "s.jsonl", "t.jsonl"]
    );
    assert_eq!(folder.text("s.jsonl"), folder.text("t.jsonl"));
    let contacts = folder.text("c.csv");
    assert!(
        contacts.starts_with("frame,time_us,module,contact,x_mm,y_mm,intensity,level,members\n")
    );
    for name in ["x.txt", "x", "x.CSVX", ".csv"] {
        refused_with(
            &["run", "--record", &path(name)],
            &["--record", name, "expected", ".csv", ".jsonl"],
        );
    }
    assert_eq!(
        folder.names(),
        ["c.csv", "c.schema.json", "s.jsonl", "t.jsonl"]
    );
}

#[test]
fn bad_input_leaves_nothing_behind() {
    let folder = Folder::new("nothing");
    let out = folder.path("out").display().to_string();
    let schedule = folder.path("s.jsonl").display().to_string();
    refused(&["run", "nowhere", "--out", &out, "--schedule", &schedule]);
    refused(&[
        "run",
        "--replay",
        "nowhere.csv",
        "--rate",
        "40",
        "--out",
        &out,
        "--schedule",
        &schedule,
    ]);
    assert_eq!(folder.names(), [""; 0]);
}

#[test]
fn a_file_that_cannot_be_written_is_said_and_not_half_there() {
    let folder = Folder::new("unwritable");
    let nowhere = folder.path("no/such/s.jsonl").display().to_string();
    folder.write("file", "kept");
    let below = folder.path("file/s.jsonl").display().to_string();
    let out = folder.0.display().to_string();
    for (args, path) in [
        (["run", "idle", "--schedule", &nowhere], &nowhere),
        (["run", "idle", "--schedule", &below], &below),
        (["run", "idle", "--schedule", &out], &out),
        (["run", "idle", "--html", &nowhere], &nowhere),
    ] {
        let said = hil(&args);
        assert_eq!(
            (said.status, said.out.as_str()),
            (Some(3), ""),
            "{}",
            said.err
        );
        assert!(
            said.err
                .starts_with(&format!("error: {path}: cannot be written: ")),
            "{}",
            said.err
        );
    }
    assert_eq!(
        (folder.names(), folder.text("file")),
        (vec!["file".into()], "kept".into())
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_a_device_stays_a_device() {
    for args in [
        &["run", "idle"][..],
        &["run", "idle", "--json"],
        &["--help"],
        &["run", "--help"],
        &["--version"],
    ] {
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = command(args, Path::new("/")).stdout(full).output().unwrap();
        let said = Said::from(output);
        assert_eq!(said.status, Some(3), "{args:?}: {}", said.err);
        assert!(
            said.err
                .contains("standard output: cannot be written: No space left"),
            "{args:?}: {}",
            said.err
        );
    }
    let said = hil(&["run", "idle", "--schedule", "/dev/full"]);
    assert_eq!(said.status, Some(3));
    assert!(
        said.err
            .contains("/dev/full: cannot be written: No space left"),
        "{}",
        said.err
    );
    assert!(!fs::metadata("/dev/full").unwrap().is_file());
    let said = hil(&["run", "idle", "--quiet", "--schedule", "/dev/stdout"]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert!(said.out.starts_with("{\"version\":"), "{}", said.out);
}

#[cfg(unix)]
#[test]
fn a_link_is_written_through() {
    let folder = Folder::new("link");
    let target = folder.write("target.jsonl", "");
    let link = folder.path("link.jsonl");
    std::os::unix::fs::symlink(&target, &link).unwrap();
    good(&["run", "idle", "--schedule", &link.display().to_string()]);
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert!(folder.text("target.jsonl").starts_with("{\"version\":"));
}

#[test]
fn a_reader_that_leaves_is_no_error() {
    let folder = Folder::new("pipe");
    let path = contacts::recording(&folder, 4000);
    for args in [
        vec!["run", "idle"],
        vec!["run", "idle", "--json"],
        vec!["--help"],
        vec![
            "contacts",
            &path,
            "--layout",
            "uskin-4x4",
            "--rate",
            "100",
            "--kc",
            "4",
        ],
    ] {
        let mut child = command(&args, &folder.0)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let said = Said::from(child.wait_with_output().unwrap());
        assert_eq!((said.status, said.err.as_str()), (Some(0), ""), "{args:?}");
    }
}

#[test]
fn a_can_log_replays_to_the_same_contacts_and_the_same_log() {
    let folder = Folder::new("can-log");
    let path = |name: &str| folder.path(name).display().to_string();
    let (log, again) = (path("a.log"), path("b.log"));
    let (first, second) = (path("a.csv"), path("b.csv"));
    good(&["run", "--record", &log, "--record", &first]);
    good(&[
        "run",
        "sphere-along",
        "--replay",
        &log,
        "--record",
        &again,
        "--record",
        &second,
    ]);
    let text = folder.text("a.log");
    // 16 taxels at 100 Hz for 10 s, and each line as candump writes it.
    assert_eq!(text.lines().count(), 16_000);
    assert!(text.starts_with("(0000000000.000"), "{}", &text[..40]);
    assert!(folder.text("a.csv").lines().count() > 500);
    assert_eq!(folder.text("b.csv"), folder.text("a.csv"));
    assert_eq!(folder.text("b.log"), text);
    let two = ["run", "--replay", &log, "--replay", &again];
    refused_with(&two, &["expected one recording of all buses"]);
    folder.write(
        "broken.log",
        "(0.000001) can0 004#00\n(0.000002) can0 004#0\n",
    );
    let broken = ["run", "--replay", &path("broken.log")];
    refused_with(&broken, &["broken.log:2: expected up to eight bytes"]);
}
