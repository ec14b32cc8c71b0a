//! Hostile surroundings: closed streams, full disks, folders that are not there, no home.

use super::{Expect, Try};

/// Commands that print, each with a good input.
const PRINTING: [&[&str]; 12] = [
    &["run", "scene.toml"],
    &["run", "scene.toml", "--json"],
    &["contacts", "taxels.csv", "--layout", "uskin-4x4"],
    &["diff", "a.csv", "a.csv"],
    &["list"],
    &["check", "scene.toml"],
    &["test", "scene.toml"],
    &["completions", "bash"],
    &["identify", "trace.csv"],
    &["compare", "summary.json", "summary.json"],
    &["design", "--seconds", "3", "--pulses", "2"],
    &["man"],
];

/// Commands that write a file, `{}`.
const WRITING: [&[&str]; 15] = [
    &["run", "scene.toml", "--quiet", "--record", "{}.csv"],
    &["run", "scene.toml", "--quiet", "--record", "{}.mcap"],
    &["run", "scene.toml", "--quiet", "--schedule", "{}.jsonl"],
    &["run", "scene.toml", "--quiet", "--html", "{}.html"],
    &["run", "scene.toml", "--quiet", "--junit", "{}.xml"],
    &["run", "scene.toml", "--quiet", "--out", "{}"],
    &[
        "contacts",
        "taxels.csv",
        "--layout",
        "uskin-4x4",
        "--out",
        "{}",
    ],
    &["export", "taxels", "scene.toml", "--out", "{}.csv"],
    &["new", "wire", "thin", "--out", "{}.toml"],
    &["export", "views", "--out", "{}"],
    &["sweep", "scene.toml", "--out", "{}.csv"],
    &[
        "design",
        "--seconds",
        "3",
        "--pulses",
        "2",
        "--out",
        "{}.csv",
    ],
    &[
        "design",
        "--seconds",
        "3",
        "--pulses",
        "2",
        "--html",
        "{}.html",
    ],
    &["texture", "strokes", "--out", "{}", "--strokes", "1"],
    &[
        "run",
        "--replay",
        "taxels.csv",
        "--quiet",
        "--record",
        "{}.mcap",
    ],
];

/// Folders in which no file can be made, for a person who may do everything too.
const NOWHERE: [&str; 2] = ["/proc/no/made", "scene.toml/made"];

/// The tries.
pub fn tries() -> Vec<Try> {
    let mut tries = Vec::new();
    for args in PRINTING {
        let call = |around, expect| Try::new(args, expect).around(around);
        tries.push(call(">/dev/full", Expect::Ends(3, "standard output")));
        tries.push(call("| head -c 1 >/dev/null", Expect::Good));
        for closed in ["2>&-", "<&-"] {
            let expect = match args[0] {
                "test" => Expect::Ends(1, "nothing was tested"),
                _ => Expect::Good,
            };
            tries.push(call(closed, expect));
        }
    }
    for args in WRITING {
        for place in NOWHERE {
            let filled: Vec<String> = args.iter().map(|a| a.replace("{}", place)).collect();
            let filled: Vec<&str> = filled.iter().map(String::as_str).collect();
            tries.push(Try::new(&filled, Expect::Ends(3, "cannot be written")));
        }
    }
    tries
}
