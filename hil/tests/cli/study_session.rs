//! `hil study run` with its pages: what is kept of what was played, however a session ends, and what goes on with a record.

use std::io::{BufRead, BufReader};

use serde_json::{Value, json};

use super::serve::{Served, served};
use super::study_page::Page;
use super::*;

/// One wire for half a second, five times.
const PROTOCOL: &str = r#"
name = "one"
description = "One wire"
pause_s = 0.1
stimulus_s = 0.5
[localisation]
wires = [1]
level_db = 0.0
repeats = 5
simulated = { bias_mm = { mean = 0.0, sd = 1.0 }, noise_mm = 2.0, slips = 0.0 }
"#;
/// Bursts that half a second has at least.
const BURSTS: usize = 4;

fn words<'a>(more: &[&'a str]) -> Vec<&'a str> {
    let first = ["study", "run", "one.toml", "--participant", "1"];
    [&first[..], &["--out", "study"], more].concat()
}

fn begun(name: &str) -> Folder {
    let folder = Folder::new(name);
    folder.write("one.toml", PROTOCOL);
    folder
}

fn session(folder: &Folder, more: &[&str]) -> Served {
    served(folder, &words(&[&["--at", "0"][..], more].concat()))
}

fn page(run: &Served, who: &str) -> Page {
    Page::open(&run.host, "", who)
}

/// The participant's page, with its next trial played and its question open.
fn at_question(run: &Served) -> (Page, u64) {
    let mut page = page(run, "participant");
    let view = page.on("begin");
    page.say(&json!({ "view": view, "reply": "read" }));
    let view = page.on("place");
    (page, view)
}

const RECORD: &str = "study/records/participant-1.jsonl";

fn record(folder: &Folder) -> Vec<Value> {
    let text = folder.text(RECORD);
    let lines = text.lines().map(|line| serde_json::from_str(line).unwrap());
    lines.collect()
}

fn write_record(folder: &Folder, lines: &[Value]) {
    let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
    folder.write(RECORD, &text);
}

/// Bursts of what a reply's trial played.
fn bursts(line: &Value) -> usize {
    let intervals = line["reply"]["trial"]["intervals"].as_array();
    let of = |interval: &Value| interval["bursts"].as_array().unwrap().len();
    intervals.map_or(0, |all| all.iter().map(of).sum())
}

/// Why the trial of a void reply came to nothing.
fn void(line: &Value) -> Option<&str> {
    line["reply"]["reply"]["void"].as_str()
}

fn kill(run: &mut Served) {
    run.run.kill().unwrap();
    run.run.wait().unwrap();
}

#[test]
fn what_was_played_before_a_kill_is_booked() {
    let folder = begun("study-kill");
    let mut dose = Vec::new();
    for killed in 0..3 {
        let more: &[&str] = if killed > 0 { &["--resume"] } else { &[] };
        let mut run = session(&folder, more);
        let (_participant, _) = at_question(&run);
        dose.push(page(&run, "experimenter").limits()["cem43"]);
        kill(&mut run);
        let lines = record(&folder);
        let booked = &lines.last().unwrap()["playing"]["interval"]["bursts"];
        assert!(booked.as_array().unwrap().len() >= BURSTS, "{booked}");
        // Each trial that was open when its program was killed is void, with what was booked for it.
        let voids = lines.iter().filter(|line| void(line).is_some());
        let voids: Vec<usize> = voids.map(bursts).collect();
        assert_eq!(voids.len(), killed);
        assert!(voids.iter().all(|count| *count >= BURSTS), "{voids:?}");
    }
    // A program that goes on knows what its wearer had.
    assert!(dose[2] > 2.0 * dose[0] && dose[0] > 0.0, "{dose:?}");
}

#[test]
fn the_heat_of_a_hot_pass_outlives_a_kill() {
    let folder = begun("study-pass-kill");
    let mut run = session(&folder, &[]);
    let mut participant = page(&run, "participant");
    let view = participant.on("begin");
    participant.say(&json!({ "view": view, "reply": "read" }));
    participant.on("pass");
    kill(&mut run);
    let lines = record(&folder);
    let pass = &lines.last().unwrap()["passing"]["interval"];
    let bursts = pass["bursts"].as_array().unwrap();
    let wires: Vec<u64> = bursts.iter().map(|b| b[0].as_u64().unwrap()).collect();
    assert!((0..8).all(|wire| wires.contains(&wire)), "{wires:?}");
    // Nothing was answered: what the session goes on with is the pass's heat alone.
    let run = session(&folder, &["--resume"]);
    let dose = page(&run, "experimenter").limits()["cem43"];
    assert!(dose > 0.0, "{dose}");
}

#[test]
fn a_clock_that_is_set_cools_nothing() {
    let folder = begun("study-clock");
    let mut run = session(&folder, &[]);
    let (mut participant, view) = at_question(&run);
    participant.say(&json!({ "view": view, "reply": { "answer": { "place": [0.0, 1.0] } } }));
    participant.on("place");
    kill(&mut run);
    let mut lines = record(&folder);
    // What was open counts as played to its end.
    let open = &lines.last().unwrap()["playing"]["interval"];
    let bursts = open["bursts"].as_array().unwrap().iter();
    let last_us = bursts.map(|burst| burst[2].as_u64().unwrap()).max();
    let until_ms = open["began_ms"].as_u64().unwrap() + last_us.unwrap() / 1000;
    // As if the session had begun an hour ago, on another computer.
    let about = &mut lines[0]["session"];
    about["began_unix_ms"] = json!(about["began_unix_ms"].as_u64().unwrap() - 3_600_000);
    about["uptime"] = json!({ "start": "another one", "ms": 0 });
    write_record(&folder, &lines);
    let run = session(&folder, &["--resume"]);
    let mut participant = page(&run, "participant");
    participant.on("begin");
    let lines = record(&folder);
    let resumed = lines.iter().find_map(|line| line.get("resumed")).unwrap();
    let after_ms = resumed["at_ms"].as_u64().unwrap();
    assert!(
        (until_ms..=until_ms + 1).contains(&after_ms),
        "{until_ms} {after_ms}"
    );
    participant.say(&json!({ "stop": true }));
    assert_eq!(run.ended().0, Some(4));
}

#[test]
fn a_stop_or_a_signal_at_a_question_keeps_what_was_played() {
    for signal in [None, Some("-TERM")] {
        let folder = begun("study-stop");
        let run = session(&folder, &[]);
        let (mut participant, _) = at_question(&run);
        match signal {
            None => participant.say(&json!({ "stop": true })),
            Some(signal) => {
                let id = run.run.id().to_string();
                let sent = Command::new("kill").args([signal, &id]).status().unwrap();
                assert!(sent.success());
            }
        }
        let (status, said) = run.ended();
        assert_eq!(
            status,
            Some(if signal.is_some() { 130 } else { 4 }),
            "{said}"
        );
        let lines = record(&folder);
        let line = lines.iter().find(|line| void(line).is_some()).unwrap();
        assert!(bursts(line) >= BURSTS, "{line}");
    }
}

#[test]
fn a_trial_that_passed_a_limit_is_in_the_record() {
    let folder = Folder::new("study-exceeded");
    let text = r#"
name = "one"
description = "An amplifier that is stuck"
pause_s = 0.1
conditions = [{ name = "stuck", scene = "stuck-amplifier" }]
[rating]
scales = [{ name = "warmth", low = "cold", high = "hot" }]
conditions = ["stuck"]
compare = []
groups = "within"
repeats = 1
simulated = { rating = { mean = 3.0, sd = 0.5 }, noise = 0.5, difference = 1.0 }
"#;
    folder.write("one.toml", text);
    let said = hil_in(&folder.0, &words(&["--simulated"]));
    assert_eq!(said.status, Some(1), "{}", said.err);
    assert!(said.err.contains("BEYOND THE MODEL"), "{}", said.err);
    let lines = record(&folder);
    let line = lines.last().unwrap();
    assert!(void(line).unwrap().contains("BEYOND THE MODEL"), "{line}");
    let intervals = line["reply"]["trial"]["intervals"].as_array().unwrap();
    assert_eq!(intervals.len(), 1);
    assert_eq!(intervals[0]["stimulus"]["condition"], "stuck");
}

/// The record of a simulated session that was killed after two trials.
fn half(folder: &Folder) -> Vec<Value> {
    let said = hil_in(&folder.0, &words(&["--simulated"]));
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
    let mut lines = record(folder);
    let mut replies = (0..lines.len()).filter(|n| lines[*n].get("reply").is_some());
    let second = replies.nth(1).unwrap();
    lines.truncate(second + 1);
    write_record(folder, &lines);
    lines
}

#[test]
fn what_is_another_session_does_not_go_on_with_a_record() {
    let folder = begun("study-other");
    let lines = half(&folder);
    let refused = |more: &[&str], expected: &[&str]| {
        let said = hil_in(&folder.0, &words(more));
        assert_eq!(
            (said.status, said.out.as_str()),
            (Some(2), ""),
            "{}",
            said.err
        );
        for word in expected {
            assert!(said.err.contains(word), "no `{word}` in: {}", said.err);
        }
    };
    let resume = ["--simulated", "--resume"];
    refused(
        &["--simulated", "--resume", "--seed", "2"],
        &["--resume", "seed", "found 2"],
    );
    refused(&["--resume"], &["--resume", "found a participant"]);
    for (key, what) in [("protocol_digest", "protocol"), ("limits_digest", "limits")] {
        let mut other = lines.clone();
        other[0]["session"][key] = json!("0123456789abcdef");
        write_record(&folder, &other);
        refused(&resume, &["--resume", what, "0123456789abcdef"]);
    }
    let mut other = lines.clone();
    other[0]["session"]["participant"] = json!(2);
    write_record(&folder, &other);
    refused(&resume, &["line 1", "participant", "found 2"]);
    let analysed = hil_in(&folder.0, &["study", "analyse", "study"]);
    assert_eq!(analysed.status, Some(2), "{}", analysed.err);
    for at in 1..lines.len() {
        let mut twice = lines.clone();
        twice.insert(at, lines[at].clone());
        write_record(&folder, &twice);
        refused(&resume, &[format!("line {}", at + 2).as_str(), "at_ms"]);
    }
    // What would keep a guard busy for longer than there is time.
    let mut endless = lines.clone();
    let off = "/reply/trial/intervals/0/bursts/0/2";
    let is_played = |line: &Value| line.pointer(off).is_some();
    let played = lines.iter().position(is_played).unwrap();
    *endless[played].pointer_mut(off).unwrap() = json!(u64::MAX);
    write_record(&folder, &endless);
    let line = format!("line {}", played + 1);
    refused(&resume, &[line.as_str(), "when a burst goes off"]);
    write_record(&folder, &lines);
    let said = hil_in(&folder.0, &words(&resume));
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
    let answered = record(&folder);
    let answered = answered
        .iter()
        .filter(|l| l["reply"]["reply"]["answer"].is_object());
    assert_eq!(answered.count(), 5);
}

#[test]
fn notes_have_an_end() {
    const MOST: usize = 1000;
    let folder = begun("study-notes");
    let mut run = session(&folder, &[]);
    // One that is too long ends its page, and is not taken.
    let mut experimenter = page(&run, "experimenter");
    experimenter.say(&json!({ "note": "x".repeat(5000) }));
    while experimenter.next().is_some() {}
    kill(&mut run);
    let mut lines = record(&folder);
    assert_eq!(lines.len(), 1);
    let note = |n: usize| json!({ "note": { "at_ms": 1000 + n, "text": "x" } });
    lines.extend((0..MOST - 1).map(note));
    write_record(&folder, &lines);
    let run = session(&folder, &["--resume"]);
    let (mut participant, view) = at_question(&run);
    let mut experimenter = page(&run, "experimenter");
    for _ in 0..3 {
        experimenter.say(&json!({ "note": "one more" }));
    }
    participant.say(&json!({ "view": view, "reply": { "answer": { "place": [0.0, 1.0] } } }));
    let said = loop {
        let (_, shows) = experimenter.next().unwrap();
        if shows["said"].is_string() {
            break shows["said"].clone();
        }
    };
    assert_eq!(said, "The record takes no more notes.");
    experimenter.say(&json!({ "stop": true }));
    assert_eq!(run.ended().0, Some(4));
    let lines = record(&folder);
    let notes = lines.iter().filter(|line| line.get("note").is_some());
    assert_eq!(notes.count(), MOST);
}

#[test]
fn each_page_has_a_token_of_its_own() {
    let folder = begun("study-tokens");
    let mut command = command(&words(&["--at", "0.0.0.0:0"]), &folder.0);
    let spawned = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
    let mut child = spawned.unwrap();
    let mut told = BufReader::new(child.stderr.take().unwrap()).lines();
    let mut address = || {
        let line = told.next().unwrap().unwrap();
        let (_, url) = line.split_once("http://0.0.0.0:").unwrap();
        let (port, rest) = url.split_once('/').unwrap();
        let (path, token) = rest.split_once("#token=").unwrap();
        (port.to_owned(), path.to_owned(), format!("?token={token}"))
    };
    let (port, path, of_participant) = address();
    assert_eq!(path, "");
    let (_, path, of_experimenter) = address();
    assert_eq!(path, "experimenter");
    assert_ne!(of_participant, of_experimenter);
    let host = format!("127.0.0.1:{port}");
    for (query, who) in [
        (&of_participant, "experimenter"),
        (&of_experimenter, "participant"),
    ] {
        assert!(Page::open(&host, query, who).next().is_none(), "{who}");
    }
    let own = Page::open(&host, &of_experimenter, "experimenter").next();
    assert!(own.is_some());
    let mut participant = Page::open(&host, &of_participant, "participant");
    participant.on("begin");
    participant.say(&json!({ "stop": true }));
    assert_eq!(child.wait().unwrap().code(), Some(4));
}
