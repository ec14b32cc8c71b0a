//! `hil review`: what insta left behind, in words and charts; accepted, rejected or left.

use std::io::Write;

use super::*;

const CONTACTS: &str = include_str!("../../../fixtures/goldens/sphere-along.contacts.snap");
const SCHEDULE: &str = include_str!("../../../fixtures/goldens/sphere-along.schedule.snap");

/// A folder of goldens in which sphere-along lost margin and falls later, and idle changed its seed.
fn goldens(name: &str) -> Folder {
    let folder = Folder::new(name);
    let waits = |text: &str| text.replacen("source:", "source: x\nassertion_line: 7\nold:", 1);
    folder.write("sphere-along.contacts.snap", CONTACTS);
    let other = CONTACTS.replace("seed 1", "seed 2");
    folder.write("sphere-along.contacts.snap.new", &waits(&other));
    folder.write("sphere-along.schedule.snap", SCHEDULE);
    let burst = SCHEDULE.lines().find(|l| l.contains(" 936000 ")).unwrap();
    let later = SCHEDULE
        .replace(burst, &burst.replacen("936000 ", "936000+43092 ", 1))
        .replacen("wire 2 ....", "wire 2 ..9.", 1);
    let row = SCHEDULE
        .lines()
        .find(|l| l.starts_with("  burst  "))
        .unwrap();
    let less = row.replace("30.578", "40.578").replace("61.156", "81.156");
    assert_ne!(less, row);
    let later = later.replace(row, &less);
    folder.write("sphere-along.schedule.snap.new", &waits(&later));
    let idle = include_str!("../../../fixtures/goldens/idle.contacts.snap");
    folder.write("idle.contacts.snap", idle);
    folder.write(
        "idle.contacts.snap.new",
        &waits(&idle.replace("seed 1", "seed 2")),
    );
    folder
}

/// Reviews a folder with these answers typed.
fn answered(folder: &Folder, answers: &str) -> Said {
    let goldens = folder.0.display().to_string();
    let mut child = command(&["review", "--goldens", &goldens], &folder.0)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // A program that has all its answers may be gone before it reads them all.
    let _ = child.stdin.take().unwrap().write_all(answers.as_bytes());
    child.wait_with_output().unwrap().into()
}

#[test]
fn the_margin_that_shrank_comes_first_and_rows_stand_above_one_another() {
    let folder = goldens("review-words");
    let said = answered(&folder, "");
    assert_eq!(said.status, Some(1));
    let lines: Vec<&str> = said.out.lines().collect();
    assert_eq!(
        lines[0],
        "1 of 2  sphere-along: schedule, contact path changed"
    );
    assert_eq!(
        lines[1],
        "  less left: burst 30.578 -> 40.578 ms of 50.000, 61.156 -> 81.156 % used"
    );
    assert_eq!(lines[2], "  wire 1 falls 5 ms later, at 0.936 s");
    let was = lines
        .iter()
        .position(|l| l.starts_with("-       wire 2 ...."))
        .unwrap();
    assert!(lines[was + 1].starts_with("+       wire 2 ..9."));
    assert!(
        said.out
            .contains("2 of 2  idle: contact path changed\n  bench emulated, seed 1 -> 2")
            || said.out.contains("  seed 1 -> 2"),
        "{}",
        said.out
    );
    assert!(said.err.contains("2 scenes wait"), "{}", said.err);
    assert_eq!(folder.names().len(), 6, "nothing was decided");
}

#[test]
fn accept_keeps_the_reason_reject_keeps_the_old_and_skip_keeps_both() {
    let folder = goldens("review-decide");
    let said = answered(&folder, "what\nc\na bursts may be longer\ns\n");
    assert_eq!(said.status, Some(1), "{}", said.out);
    assert!(said.out.contains("accepted sphere-along\n") && said.out.contains("skipped idle\n"));
    for kind in ["contacts", "schedule"] {
        let text = folder.text(&format!("sphere-along.{kind}.snap"));
        assert!(
            text.contains("\ndescription: \"bursts may be longer\"\n---\n"),
            "{text}"
        );
        assert!(!text.contains("assertion_line"));
    }
    assert!(
        folder
            .text("sphere-along.schedule.snap")
            .contains("81.156 %")
    );
    let idle = folder.text("idle.contacts.snap");
    let said = answered(&folder, "r\n");
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
    assert_eq!(folder.text("idle.contacts.snap"), idle);
    assert!(folder.names().iter().all(|n| n.ends_with(".snap")));
    let said = answered(&folder, "");
    assert_eq!(said.status, Some(0));
    assert!(said.out.starts_with("no golden waits"));
}

#[test]
fn decisions_go_by_name_too() {
    let folder = goldens("review-names");
    let goldens = folder.0.display().to_string();
    let out = good(&[
        "review",
        "accept",
        "sphere-along.contacts",
        "--why",
        "measured \"anew\"",
        "--goldens",
        &goldens,
    ]);
    assert_eq!(out, "accepted sphere-along.contacts\n");
    assert!(
        folder
            .text("sphere-along.contacts.snap")
            .contains("description: \"measured \\\"anew\\\"\"")
    );
    refused_with(
        &["review", "accept", "brush", "--goldens", &goldens],
        &["brush", "idle.contacts"],
    );
    assert_eq!(
        good(&["review", "reject", "idle", "--goldens", &goldens]),
        "rejected idle.contacts\n"
    );
    assert_eq!(
        good(&["review", "accept", "--goldens", &goldens]),
        "accepted sphere-along.schedule\n"
    );
    refused_with(
        &["review", "--goldens", "/no/such/folder"],
        &["--goldens", "/no/such/folder"],
    );
}

#[test]
fn the_page_draws_both_over_one_another_and_loads_nothing() {
    let folder = goldens("review-page");
    let page = folder.path("review.html").display().to_string();
    let goldens = folder.0.display().to_string();
    let out = good(&["review", "--html", &page, "--goldens", &goldens]);
    assert!(out.ends_with("2 scenes wait\n"), "{out}");
    let text = folder.text("review.html");
    // Eight wires in the whole run, some of them in the close look.
    let was = text.matches("class=\"was\" d=").count();
    assert!((9..=16).contains(&was), "{was}");
    assert_eq!(text.matches("class=\"is\" d=").count(), was);
    assert!(text.contains("less left: burst 30.578 -&gt; 40.578 ms"));
    for outside in ["src=", "href=", "@import", "<script", "url("] {
        assert!(!text.contains(outside), "{outside}");
    }
}

#[test]
fn texts_that_are_none_of_ours_and_damaged_ones_are_told_apart() {
    let folder = Folder::new("review-other");
    folder.write("other.snap", "---\nsource: x\n---\na\nb\n");
    folder.write("other.snap.new", "---\nsource: x\n---\na\nc\nd\n");
    folder.write("fresh.snap.new", "---\nsource: x\n---\na\n");
    let said = answered(&folder, "a\na\n");
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert!(said.out.contains("other: 2 lines differ"), "{}", said.out);
    assert!(said.out.contains("fresh is new"));
    assert_eq!(folder.names(), ["fresh.snap", "other.snap"]);
    folder.write(
        "bad.snap.new",
        "---\nsource: x\n---\npalpate schedule of x (emulated)\n  a\nb\n",
    );
    let said = answered(&folder, "");
    assert_eq!(said.status, Some(2));
    assert!(
        said.err.contains("bad.snap.new:6: expected an empty line"),
        "{}",
        said.err
    );
}
