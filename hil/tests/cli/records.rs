//! Records that others open: written whole, read again, and opened up to the place where they were cut.

use palpate_records::mcap;

use super::*;

/// The records of a run of the default scene, one of each ending, and the contacts beside them.
fn recorded(folder: &Folder, endings: &[&str]) {
    let mut args = vec!["run".to_owned(), "sphere-along".into(), "--quiet".into()];
    for ending in endings {
        args.push("--record".into());
        args.push(folder.path(&format!("a.{ending}")).display().to_string());
    }
    good(&args);
}

/// A replay of a file, with contacts beside it.
fn replayed(folder: &Folder, name: &str) -> Said {
    let (from, to) = (folder.path(name), folder.path("again.csv"));
    let (from, to) = (from.display().to_string(), to.display().to_string());
    let args = [
        "run",
        "sphere-along",
        "--replay",
        &from,
        "--record",
        &to,
        "--quiet",
    ];
    hil(&args)
}

#[test]
fn an_mcap_file_replays_to_the_contacts_of_its_run() {
    let folder = Folder::new("mcap");
    recorded(&folder, &["mcap", "csv"]);
    let said = replayed(&folder, "a.mcap");
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
    assert_eq!(folder.text("again.csv"), folder.text("a.csv"));
}

#[test]
fn the_same_run_gives_the_same_bytes_without_dates() {
    let (one, two) = (Folder::new("same-1"), Folder::new("same-2"));
    for folder in [&one, &two] {
        recorded(folder, &["mcap", "vcd"]);
    }
    for name in ["a.mcap", "a.vcd"] {
        let read = |folder: &Folder| fs::read(folder.path(name)).unwrap();
        assert!(read(&one) == read(&two), "{name}");
    }
    let vcd = one.text("a.vcd");
    assert!(!vcd.contains("$date"));
    for word in [
        "emulated",
        "pin_b0_ch0",
        "on_ticks",
        "wire_celsius",
        "skin_celsius",
    ] {
        assert!(vcd.contains(word), "{word}");
    }
}

#[test]
fn a_recording_that_was_cut_is_replayed_up_to_the_cut_and_says_so() {
    let folder = Folder::new("cut");
    recorded(&folder, &["mcap", "log"]);
    for (name, words) in [
        ("a.mcap", ["byte ", "cut short", "CAN frames"]),
        ("a.log", [":9", "cut short", "frames before it"]),
    ] {
        let bytes = fs::read(folder.path(name)).unwrap();
        // In the middle of a line: one that ends where the file does is no cut.
        let about = bytes.len() * 3 / 5;
        let line = bytes[about..].iter().position(|b| *b == b'\n').unwrap();
        fs::write(folder.path(name), &bytes[..about + line + 9]).unwrap();
        let said = replayed(&folder, name);
        assert_eq!(said.status, Some(0), "{}", said.err);
        for word in words {
            assert!(said.err.contains(word), "no `{word}` in: {}", said.err);
        }
        assert!(folder.text("again.csv").lines().count() > 100);
    }
}

#[test]
fn what_is_no_recording_of_ours_is_refused_by_name() {
    let folder = Folder::new("foreign");
    for (name, text, words) in [
        ("a.mcap", "hello", ["a.mcap", "an MCAP file", "byte 0"]),
        ("b.mcap", "", ["b.mcap", "an MCAP file", "byte 0"]),
        (
            "c.mcap",
            "\u{89}MCAP0\r\n",
            ["c.mcap", "an MCAP file", "byte 0"],
        ),
        ("a.log", "", ["a.log", "11-bit identifiers", "none"]),
    ] {
        let path = folder.write(name, text).display().to_string();
        refused_with(&["run", "--replay", &path], &words);
    }
    fs::write(folder.path("d.mcap"), b"\x89MCAP0\r\n").unwrap();
    let path = folder.path("d.mcap").display().to_string();
    refused_with(
        &["run", "--replay", &path],
        &["cut short", "byte 8", "/can"],
    );
}

#[test]
fn a_capture_of_the_pins_is_held_against_the_schedule() {
    let folder = Folder::new("capture");
    recorded(&folder, &["jsonl", "vcd"]);
    let (plan, capture) = (folder.path("a.jsonl"), folder.path("a.vcd"));
    let (plan, capture) = (plan.display().to_string(), capture.display().to_string());
    let told = good(&["diff", &plan, &capture]);
    assert!(
        told.starts_with("OK\n") && told.contains("PWM frequency, board 0"),
        "{told}"
    );
    // Half of it is not enough, unless half is asked for.
    let text = folder.text("a.vcd");
    let half = folder.write("half.vcd", &text[..text.len() / 2]);
    let half = half.display().to_string();
    let said = hil(&["diff", &plan, &half]);
    assert_eq!(said.status, Some(1), "{}", said.err);
    assert!(said.out.starts_with("INCOMPLETE: "), "{}", said.out);
    let (_, window) = said.out.split_once("--window ").unwrap();
    let (window, _) = window.split_once('`').unwrap();
    let said = hil(&["diff", &plan, &half, "--window", window]);
    assert!(said.out.starts_with("OK\n"), "{}", said.out);
    assert_eq!(said.status, Some(0), "{}", said.err);
    refused_with(&["diff", &plan, &half, "--window", "2..1"], &["FROM..TO"]);
    refused_with(&["diff", &plan, &plan, "--window", "1..2"], &["--window"]);
    // A wire that never comes on.
    let pin = "pin_b0_ch2";
    let spoilt = folder.text("a.vcd").replace(pin, "pin_b0_ch12");
    let spoilt = folder.write("b.vcd", &spoilt).display().to_string();
    let said = hil(&["diff", &plan, &spoilt, "--json"]);
    assert_eq!(said.status, Some(1), "{}", said.err);
    let found: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(found["verdict"], "failed");
    let stray = |m: &&serde_json::Value| m["name"] == "stray pulses, board 0 channel 12";
    let stray = found["measurements"]
        .as_array()
        .unwrap()
        .iter()
        .find(stray)
        .unwrap();
    assert!(
        stray["value"].as_f64().unwrap() > 10.0 && stray["high"] == 0.0,
        "{stray}"
    );
    refused_with(&["diff", &plan, &capture, "--pin", "D0=3"], &["D0=0:3"]);
    refused_with(&["diff", &capture, &plan], &["a.vcd"]);
}

#[test]
fn a_live_view_needs_a_terminal_and_the_run_goes_on_without() {
    let said = hil(&["run", "idle", "--watch"]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert!(said.err.contains("no terminal"), "{}", said.err);
    assert!(said.out.contains("idle on emulated"), "{}", said.out);
    assert!(!said.out.contains('\u{1b}'));
}

#[test]
fn a_replay_writes_the_same_records_while_it_runs_as_after_it() {
    let folder = Folder::new("while");
    recorded(&folder, &["mcap"]);
    let endings = ["csv", "jsonl", "log", "vcd", "mcap"];
    let replay = |name: &str, more: &[&str]| {
        let mut args = vec!["run", "--layout", "uskin-4x4", "--quiet", "--replay"];
        let from = folder.path("a.mcap").display().to_string();
        let to = endings.map(|ending| folder.path(&format!("{name}.{ending}")));
        let to = to.map(|path| path.display().to_string());
        args.push(&from);
        to.iter().for_each(|path| args.extend(["--record", path]));
        args.extend(more);
        let said = hil(&args);
        assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
    };
    replay("while", &[]);
    let report = folder.path("r.html").display().to_string();
    // A report needs the whole run, so everything is written behind it.
    replay("after", &["--html", &report]);
    let read = |name: &str, ending| fs::read(folder.path(&format!("{name}.{ending}"))).unwrap();
    for ending in ["csv", "jsonl", "log"] {
        assert!(read("while", ending) == read("after", ending), "{ending}");
    }
    // One that grew ends with its last event, one that was written whole with the run.
    let (grown, whole) = (read("while", "vcd"), read("after", "vcd"));
    assert!(grown.len() > 10_000 && whole.starts_with(&grown) || grown.starts_with(&whole));
    let [grown, whole] = ["while", "after"].map(|name| mcap::read(&read(name, "mcap")).unwrap());
    assert_eq!(
        (grown.frames, grown.messages),
        (whole.frames, whole.messages)
    );
    let left = fs::read_dir(folder.path("")).unwrap().flatten();
    let left = left.filter(|f| f.file_name().to_string_lossy().contains("partial"));
    assert_eq!(left.count(), 0);
}
