//! `hil diff`: words on standard output, and an exit status that tells cosmetic from meant.

use super::*;

const GOLDEN: &str = include_str!("../../../fixtures/goldens/sphere-along.schedule.snap");

/// A schedule of sphere-along with these options, in the folder.
fn schedule(folder: &Folder, name: &str, options: &[&str]) -> String {
    let path = folder.path(name).display().to_string();
    let mut args = vec!["run", "sphere-along", "--quiet", "--schedule", &path];
    args.extend(options);
    good(&args);
    path
}

fn diff(a: &str, b: &str) -> Said {
    hil(&["diff", a, b])
}

#[test]
fn a_file_does_not_differ_from_itself() {
    let folder = Folder::new("diff-same");
    let golden = folder.write("a.snap", GOLDEN).display().to_string();
    let said = diff(&golden, &golden);
    assert_eq!(
        (said.status, said.out.as_str()),
        (Some(0), "OK: sphere-along: no difference\n")
    );
    let run = schedule(&folder, "a.jsonl", &[]);
    assert_eq!(diff(&run, &run).status, Some(0));
    // A schedule says less than a golden of the same run, and nothing else.
    let said = diff(&run, &golden);
    assert_eq!(
        (said.status, said.out.as_str()),
        (Some(0), "OK: sphere-along: no difference\n")
    );
}

#[test]
fn a_shorter_stimulus_is_told_in_words_with_exit_1() {
    let folder = Folder::new("diff-tau");
    // So gently that no limit is met.
    let published = [
        "--illusion",
        "balanced",
        "--set",
        "bench.drive.current_ma=850",
    ];
    let a = schedule(&folder, "a.jsonl", &published);
    let shorter = [
        "--set",
        "illusion.tau_d_ms=30",
        "--set",
        "illusion.soa_ms=58.5",
    ];
    let b = schedule(&folder, "b.jsonl", &[&published[..], &shorter].concat());
    let said = diff(&a, &b);
    assert_eq!((said.status, said.err.as_str()), (Some(1), ""));
    for line in [
        "  tau_d 35.000 -> 30.000 ms\n",
        "  every burst falls 5 ms earlier: 496 on 8 wires\n",
    ] {
        assert!(said.out.contains(line), "{line}{}", said.out);
    }
    assert!(said.out.lines().count() <= 12);
    let quiet = hil(&["diff", "--quiet", &a, &b]);
    assert_eq!(
        (quiet.status, quiet.out.as_str(), quiet.err.as_str()),
        (Some(1), "", "")
    );
    let json = hil(&["diff", "--json", &a, &b]);
    let lines: serde_json::Value = serde_json::from_str(&json.out).unwrap();
    assert_eq!(lines[0]["text"], "tau_d 35.000 -> 30.000 ms");
    assert_eq!(lines[0]["meaning"], true);
    let near = hil(&["diff", "--tolerance-ms", "5", &a, &b]);
    assert!(
        near.out
            .contains("496 edges elsewhere by no more than 5 ms"),
        "{}",
        near.out
    );
}

#[test]
fn another_description_of_the_scene_is_cosmetic_and_a_comment_is_nothing() {
    let folder = Folder::new("diff-cosmetic");
    let scene = palpate_fixtures::scene("sphere-along").unwrap();
    let a = schedule(&folder, "a.jsonl", &[]);
    let described = scene.replacen("description = \"", "description = \"Again: ", 1);
    for (text, expected) in [
        (described, "nothing that could be felt or measured"),
        (format!("{scene}\n# said otherwise\n"), "no difference"),
    ] {
        let file = folder.write("another.toml", &text);
        let b = folder.path("b.jsonl").display().to_string();
        let scene = file.display().to_string();
        good(&["run", &scene, "--quiet", "--force", "--schedule", &b]);
        let said = diff(&a, &b);
        assert_eq!(said.status, Some(0));
        assert!(said.out.contains(expected), "{}", said.out);
    }
}

#[test]
fn what_is_damaged_is_named_with_its_line() {
    let folder = Folder::new("diff-damage");
    let good = folder.write("good.snap", GOLDEN).display().to_string();
    let lines: Vec<&str> = GOLDEN.lines().collect();
    let ledger = lines.iter().position(|l| l.starts_with("ledger")).unwrap();
    let mut cut = lines.clone();
    cut[ledger + 1] = "  stimuli                         many";
    let bad = folder
        .write("bad.snap", &cut.join("\n"))
        .display()
        .to_string();
    refused_with(
        &["diff", &good, &bad],
        &["bad.snap", &format!(":{}:", ledger + 2), "many"],
    );
    let noise = folder.path("noise.snap");
    fs::write(&noise, b"palpate\n\xff\xfe").unwrap();
    refused_with(
        &["diff", &good, &noise.display().to_string()],
        &["noise.snap:2:", "UTF-8"],
    );
    refused_with(
        &["diff", &good, "/no/such/file"],
        &["/no/such/file", "golden"],
    );
    let contacts = include_str!("../../../fixtures/goldens/sphere-along.contacts.snap");
    let contacts = folder.write("c.snap", contacts).display().to_string();
    refused_with(
        &["diff", &good, &contacts],
        &["expected a schedule", "found a contact path"],
    );
}

#[test]
fn recorded_contacts_are_compared_by_place_and_time() {
    let folder = Folder::new("diff-contacts");
    let path = |name: &str| folder.path(name).display().to_string();
    let (a, b) = (path("a.csv"), path("b.csv"));
    good(&["run", "sphere-along", "--quiet", "--record", &a]);
    assert_eq!(hil(&["diff", &a, &a]).out, "OK: contacts: no difference\n");
    good(&[
        "run",
        "sphere-along",
        "--quiet",
        "--seed",
        "2",
        "--record",
        &b,
    ]);
    let said = hil(&["diff", &a, &b]);
    assert_eq!(said.status, Some(1));
    assert!(
        said.out.contains("contact 0/1 elsewhere in "),
        "{}",
        said.out
    );
    let snap = folder.write("a.snap", GOLDEN).display().to_string();
    refused_with(
        &["diff", &a, &snap],
        &["expected a contact recording", "found a schedule"],
    );
    let cut = folder.write("cut.csv", &folder.text("a.csv")[..200]);
    refused_with(
        &["diff", &a, &cut.display().to_string()],
        &["cut.csv:", ": expected a contact"],
    );
}

/// Of what is too long to be held, the words tell what begins with the first difference.
#[test]
fn schedules_of_any_length_compare() {
    let folder = Folder::new("long-schedules");
    let header = "{\"version\":1,\"seed\":1,\"scene_digest\":\"0\",\"limits_digest\":\"0\",\"scene\":\"long\",\"pre_scale\":30,\"tau_d_us\":35000,\"soa_us\":58500}\n";
    let line = |n: u64, off: u16| {
        let (from, to) = (n * 58_500, n * 58_500 + 35_000);
        format!(
            "{{\"t_us\":{from},\"board\":0,\"channel\":3,\"on\":0,\"off\":{off},\"until_us\":{to},\"requested\":53,\"reason\":null}}\n"
        )
    };
    let write = |name: &str, other: u64, last: u64| {
        let off = |n| if n == other { 50 } else { 53 };
        let text = (0..last).map(|n| line(n, off(n))).collect::<String>();
        assert!(text.len() > 13 << 20);
        folder.write(name, &format!("{header}{text}"));
    };
    write("a.jsonl", u64::MAX, 250_000);
    write("early.jsonl", 7, 250_000);
    write("late.jsonl", 240_000, 250_000);
    write("short.jsonl", u64::MAX, 249_999);
    let said = |b: &str| {
        let said = hil_in(&folder.0, &["diff", "a.jsonl", b]);
        (said.status, said.out)
    };
    assert_eq!(
        said("a.jsonl"),
        (Some(0), "OK: long: no difference\n".into())
    );
    let (status, out) = said("late.jsonl");
    assert_eq!(status, Some(1));
    let words = "pulses of output 0:3 change by -3 ticks (-";
    assert!(
        out.starts_with("FAILED: long: ") && out.contains(words),
        "{out}"
    );
    assert!(out.contains("at 14040"), "{out}");
    let (status, out) = said("short.jsonl");
    assert_eq!(status, Some(1));
    assert!(
        out.starts_with("FAILED") && out.contains("1 burst gone: output 0:3"),
        "{out}"
    );
    let (status, out) = said("early.jsonl");
    assert_eq!(status, Some(1));
    assert!(
        out.starts_with("INCOMPLETE: long: ") && out.contains(words),
        "{out}"
    );
    assert!(out.contains("told up to "), "{out}");
}
