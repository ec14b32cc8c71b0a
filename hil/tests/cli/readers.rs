//! Files that never end, are of another kind, come from another program or would be lost: every command that takes
//! or writes one.

use std::time::Duration;

use palpate_live::clock;

use super::*;

/// Every command and option that reads a file, with `FILE` where that stands.
const READERS: [&[&str]; 16] = [
    &["run", "FILE"],
    &["run", "--bench", "FILE"],
    &["run", "--layout", "FILE"],
    &["run", "--replay", "FILE", "--rate", "40"],
    &["contacts", "FILE", "--layout", "uskin-4x4", "--rate", "40"],
    &["contacts", "none.csv", "--layout", "FILE", "--rate", "40"],
    &["diff", "FILE", "FILE"],
    &["diff", "good.jsonl", "FILE"],
    &["replay", "FILE", "--can", "none0"],
    &["test", "idle", "--bench", "FILE"],
    &["test", "idle", "--quarantine", "FILE"],
    &["texture", "encode", "default", "FILE"],
    &["texture", "encode", "FILE", "none.csv"],
    &["texture", "pulses", "default", "FILE", "--rate", "40"],
    &["texture", "map", "default", "--textures", "FILE"],
    &["texture", "panel", "FILE"],
];

fn with(args: &[&str], file: &str) -> Vec<String> {
    let one = |arg: &&str| if *arg == "FILE" { file } else { arg }.to_owned();
    args.iter().map(one).collect()
}

/// What never ends, waits or is far too large ends in a clear error at once.
#[test]
fn every_reader_refuses_what_never_ends() {
    let folder = Folder::new("readers");
    let said = hil_in(&folder.0, &["run", "--quiet", "--schedule", "good.jsonl"]);
    assert_eq!(said.status, Some(0), "{}", said.err);
    let sparse = fs::File::create(folder.path("sparse")).unwrap();
    sparse.set_len(6 << 30).unwrap();
    fs::write(folder.path("line"), vec![b'1'; 40 << 20]).unwrap();
    let fifo = Command::new("mkfifo").arg(folder.path("pipe")).status();
    assert!(fifo.unwrap().success());
    for file in ["/dev/zero", "sparse", "line", "pipe", ".", "nowhere"] {
        for args in READERS {
            let begun = clock::now();
            let said = hil_in(&folder.0, &with(args, file));
            let took = begun.elapsed();
            assert_eq!(said.status, Some(2), "{args:?} {file}: {}", said.err);
            assert!(said.out.is_empty(), "{args:?} {file}: {}", said.out);
            let clear = said.err.starts_with("error: ") && said.err.len() < 2000;
            assert!(clear, "{args:?} {file}: {}", said.err);
            // A second on an idle machine.
            assert!(took < Duration::from_secs(10), "{args:?} {file}: {took:?}");
        }
    }
}

#[test]
fn a_file_of_another_format_is_named_for_what_it_is() {
    let folder = Folder::new("formats");
    let log = "(0.000100) can0 104#938406805591BB0C\n";
    for (name, text, args, words) in [
        ("a.csv", log, READERS[4], "found a candump log"),
        ("a.toml", log, READERS[0], "found a candump log"),
        (
            "b.jsonl",
            "<!DOCTYPE html>\n",
            READERS[6],
            "found an HTML page",
        ),
        ("c.log", "name = \"a\"\n", READERS[8], "found TOML settings"),
        (
            "d.csv",
            "name = \"a\"\n",
            READERS[11],
            "found TOML settings",
        ),
        ("e.csv", "PK\x03\x04", READERS[4], "found a zip archive"),
    ] {
        let file = folder.write(name, text).display().to_string();
        refused_with(&with(args, &file), &[words]);
    }
}

/// A log under any name is a log.
#[test]
fn recordings_are_known_by_their_content() {
    let folder = Folder::new("content");
    let run = [
        "run",
        "sphere-along",
        "--quiet",
        "--record",
        "a.log",
        "--record",
        "a.mcap",
    ];
    assert_eq!(hil_in(&folder.0, &run).status, Some(0));
    for name in ["a.log", "a.mcap"] {
        fs::rename(folder.path(name), folder.path("capture.txt")).unwrap();
        let said = hil_in(&folder.0, &["run", "--replay", "capture.txt", "--json"]);
        assert_eq!(said.status, Some(0), "{name}: {}", said.err);
    }
}

#[test]
fn outputs_replace_nothing_but_earlier_outputs() {
    let folder = Folder::new("overwrite");
    let scene = palpate_fixtures::scene("idle").unwrap();
    folder.write("mine.toml", scene);
    folder.write("page.html", "<!DOCTYPE html>\n<title>mine</title>");
    let refused = |args: &[&str], words: &[&str]| {
        let said = hil_in(&folder.0, args);
        assert_eq!((said.status, said.out.as_str()), (Some(2), ""), "{args:?}");
        for word in words {
            assert!(said.err.contains(word), "no `{word}` in: {}", said.err);
        }
    };
    let toml = [
        "mine.toml: expected a new file",
        "found TOML settings",
        "--force",
    ];
    for option in ["--html", "--schedule", "--junit"] {
        refused(&["run", "idle", option, "mine.toml"], &toml);
    }
    refused(
        &["run", "idle", "--html", "page.html"],
        &["found another program's"],
    );
    refused(&["test", "idle", "--junit", "mine.toml"], &toml);
    refused(
        &["texture", "export", "default", "--out", "mine.toml"],
        &toml,
    );
    assert_eq!(folder.text("mine.toml"), scene);
    let run = [
        "run", "idle", "--quiet", "--html", "r.html", "--record", "a.log", "--out", "all",
    ];
    for time in 0..2 {
        let said = hil_in(&folder.0, &run);
        assert_eq!(said.status, Some(0), "{time}: {}", said.err);
    }
    refused(
        &["run", "--replay", "a.log", "--record", "a.log"],
        &["found an input of this command"],
    );
    refused(
        &["run", "idle", "--html", "x.html", "--html", "x.html"],
        &["--html"],
    );
    refused(
        &["run", "idle", "--record", "x.log", "--record", "x.log"],
        &["one output per file"],
    );
    let forced = ["run", "idle", "--quiet", "--html", "page.html", "--force"];
    assert_eq!(hil_in(&folder.0, &forced).status, Some(0));
    assert!(folder.text("page.html").contains("palpate"));
}

/// FabricSlide's recordings, as others made them.
#[test]
fn recordings_of_others_are_read_as_they_are() {
    let data = std::env::var_os("PALPATE_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    let recordings = data.join("fabric_slide");
    if !recordings.is_dir() {
        println!("skipped: no recordings");
        return;
    }
    let folder = Folder::new("fabric");
    let heading =
        "name = \"finger\"\ndescription = \"16 capacitive taxels\"\nkind = \"sensor\"\naxes = 1\n";
    let module = "[[modules]]\nname = \"tip\"\ngrid = { rows = 4, columns = 4, pitch_mm = 3.0 }\n";
    folder.write("finger.toml", &format!("{heading}{module}"));
    let mut read = 0;
    for entry in fs::read_dir(recordings).unwrap() {
        let path = entry.unwrap().path().display().to_string();
        if !path.ends_with(".csv") {
            continue;
        }
        let args = [
            "contacts",
            &path,
            "--layout",
            "finger.toml",
            "--columns",
            "channel",
        ];
        let args = [&args[..], &["--time", "timestamp:ms", "--axes", "z"]].concat();
        let said = hil_in(&folder.0, &args);
        assert_eq!(said.status, Some(0), "{path}: {}", said.err);
        let times: Vec<u64> = said
            .out
            .lines()
            .skip(1)
            .map(|l| l.split(',').nth(1).unwrap().parse().unwrap())
            .collect();
        assert!(times.windows(2).all(|t| t[0] <= t[1]));
        read += 1;
    }
    assert!(read > 0);
    println!("{read} recordings");
}

/// A Pi writes 1970 until its time server answers; power goes amid a line.
#[test]
fn jumps_of_the_clock_and_power_cuts() {
    let folder = Folder::new("jumps");
    let recording = fs::read_to_string(contacts::recording(&folder, 60)).unwrap();
    let timed = |at: &dyn Fn(u64) -> u64| {
        let line = |(n, line): (usize, &str)| match n {
            0 => format!("time_us,{line}\n"),
            n => format!("{},{line}\n", at(n as u64)),
        };
        recording.lines().enumerate().map(line).collect::<String>()
    };
    let even = timed(&|n| n * 25_000);
    let jumped = timed(&|n| n * 25_000 + if n > 30 { 1_700_000_000_000_000 } else { 0 });
    let tail = |file: &str, more: &[&str]| {
        let args = ["contacts", file, "--layout", "uskin-4x4"];
        hil_in(&folder.0, &[&args[..], more].concat())
    };
    folder.write("even.csv", &even);
    folder.write("jumped.csv", &jumped);
    let said = tail("jumped.csv", &[]);
    assert_eq!(said.status, Some(2));
    for word in ["jumped.csv:32", "53.9 years ahead", "--split-jumps"] {
        assert!(said.err.contains(word), "no `{word}` in: {}", said.err);
    }
    let whole = tail("even.csv", &[]);
    let split = tail("jumped.csv", &["--split-jumps"]);
    assert_eq!((split.status, &split.out), (Some(0), &whole.out));
    assert!(split.err.contains("taken out"), "{}", split.err);
    let cut = format!("{even}1500000,49\0\0\0\0\0\0");
    folder.write("cut.csv", &cut);
    let said = tail("cut.csv", &[]);
    assert_eq!((said.status, &said.out), (Some(0), &whole.out));
    assert!(said.err.contains("ends in 6 NUL bytes"), "{}", said.err);
    folder.write("ns.csv", &timed(&|n| n * 25_000_000));
    let said = tail("ns.csv", &[]);
    assert!(said.err.contains("looks like nanoseconds"), "{}", said.err);
    let said = tail("ns.csv", &["--time", "time_us:ns"]);
    assert_eq!((said.status, &said.out), (Some(0), &whole.out));
}
