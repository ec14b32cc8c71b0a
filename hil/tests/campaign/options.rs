//! Every option with every kind of bad value.

use super::{Expect, Try};

/// What an option takes.
#[derive(Clone, Copy)]
enum Takes {
    /// A number within bounds.
    Number,
    /// Numbers between commas.
    Numbers,
    /// One of some words.
    Word,
    /// Anything that is looked up: a file, a built-in name, a device.
    Named,
    /// Nothing.
    Nothing,
}

/// Options of a command.
type Options = &'static [(&'static str, Takes)];

/// Commands that are good but for the option that is tried, and their options.
const COMMANDS: [(&[&str], Options); 26] = [
    (
        &["run", "scene.toml"],
        &[
            ("--seed", Takes::Number),
            ("--bench", Takes::Named),
            ("--illusion", Takes::Named),
            ("--person", Takes::Named),
            ("--set", Takes::Named),
            ("--intensity", Takes::Word),
            ("--observe", Takes::Nothing),
            ("--color", Takes::Word),
            ("--json", Takes::Nothing),
            ("--quiet", Takes::Nothing),
            ("--explain", Takes::Nothing),
            ("--watch", Takes::Nothing),
        ],
    ),
    (
        &["run", "--replay", "taxels.csv", "--layout", "uskin-4x4"],
        &[
            ("--rate", Takes::Number),
            ("--time", Takes::Named),
            ("--columns", Takes::Named),
            ("--split-jumps", Takes::Nothing),
        ],
    ),
    (
        &["contacts", "taxels.csv", "--layout", "uskin-4x4"],
        &[
            ("--kc", Takes::Number),
            ("--ki", Takes::Number),
            ("--reference-frames", Takes::Number),
            ("--threshold", Takes::Number),
            ("--drift-s", Takes::Number),
            ("--faulty-deviations", Takes::Number),
            ("--weight-exponent", Takes::Number),
            ("--stop-mm", Takes::Number),
            ("--weber", Takes::Number),
            ("--vectors", Takes::Nothing),
            ("--rate", Takes::Number),
            ("--seed", Takes::Number),
            ("--scope", Takes::Word),
            ("--norm", Takes::Word),
            ("--axes", Takes::Word),
            ("--replay-stale", Takes::Word),
            ("--time", Takes::Named),
            ("--columns", Takes::Named),
        ],
    ),
    (
        &["diff", "a.csv", "a.csv"],
        &[
            ("--tolerance-mm", Takes::Number),
            ("--tolerance-ms", Takes::Number),
            ("--window", Takes::Word),
            ("--pin", Takes::Word),
            ("--json", Takes::Nothing),
        ],
    ),
    (
        &["test", "scene.toml"],
        &[
            ("--jobs", Takes::Number),
            ("--retries", Takes::Number),
            ("--seed", Takes::Number),
            ("--set", Takes::Named),
            ("--bench", Takes::Named),
            ("--quarantine", Takes::Named),
        ],
    ),
    (&["list"], &[("--json", Takes::Nothing)]),
    (&["list", "scenes"], &[("--kind", Takes::Word)]),
    (
        &["check", "scene.toml"],
        &[("--json", Takes::Nothing), ("--quiet", Takes::Nothing)],
    ),
    (
        &["new", "scene", "mine", "--force"],
        &[
            ("--length-s", Takes::Number),
            ("--path", Takes::Word),
            ("--layout", Takes::Named),
        ],
    ),
    (
        &["new", "bench", "weak", "--force"],
        &[
            ("--current-ma", Takes::Number),
            ("--supply-limit-ma", Takes::Number),
            ("--display", Takes::Named),
            ("--wire", Takes::Named),
        ],
    ),
    (
        &["new", "layout", "pad", "--force"],
        &[
            ("--rows", Takes::Number),
            ("--columns", Takes::Number),
            ("--pitch-mm", Takes::Number),
            ("--kind", Takes::Word),
        ],
    ),
    (
        &["new", "wire", "thin", "--force"],
        &[
            ("--diameter-um", Takes::Number),
            ("--length-mm", Takes::Number),
            ("--resistance-ohm", Takes::Number),
        ],
    ),
    (
        &["export", "taxels", "scene.toml", "--out", "made.csv"],
        &[("--seed", Takes::Number), ("--set", Takes::Named)],
    ),
    (
        &["texture", "encode", "default", "taxels.csv"],
        &[
            ("--rate", Takes::Number),
            ("--soa-ms", Takes::Number),
            ("--time", Takes::Named),
            ("--columns", Takes::Named),
        ],
    ),
    (
        &["texture", "map"],
        &[
            ("--strokes", Takes::Number),
            ("--seed", Takes::Number),
            ("--textures", Takes::Named),
        ],
    ),
    (
        &["texture", "panel"],
        &[
            ("--seed", Takes::Number),
            ("--textures", Takes::Named),
            ("--bench", Takes::Named),
        ],
    ),
    (
        &["identify", "trace.csv"],
        &[
            ("--rate", Takes::Number),
            ("--time", Takes::Named),
            ("--signal", Takes::Word),
            ("--bench", Takes::Named),
            ("--set", Takes::Named),
            ("--json", Takes::Nothing),
        ],
    ),
    (
        &["sweep", "scene.toml", "--out", "made.csv", "--force"],
        &[
            ("--seeds", Takes::Numbers),
            ("--jobs", Takes::Number),
            ("--part", Takes::Word),
            ("--set", Takes::Named),
            ("--bench", Takes::Named),
            ("--quiet", Takes::Nothing),
        ],
    ),
    (
        &["compare", "summary.json", "summary.json"],
        &[
            ("--tolerance-percent", Takes::Number),
            ("--json", Takes::Nothing),
        ],
    ),
    (
        &["design"],
        &[
            ("--diameter-um", Takes::Numbers),
            ("--length-mm", Takes::Numbers),
            ("--stress-mpa", Takes::Numbers),
            ("--current-a", Takes::Numbers),
            ("--pulses", Takes::Numbers),
            ("--cadence-ms", Takes::Numbers),
            ("--power-mw", Takes::Numbers),
            ("--seconds", Takes::Number),
            ("--wire", Takes::Named),
            ("--alloy", Takes::Named),
            ("--person", Takes::Named),
        ],
    ),
    (&["review"], &[("--goldens", Takes::Named)]),
    (
        &["texture", "strokes", "--out", "strokes"],
        &[
            ("--strokes", Takes::Number),
            ("--seed", Takes::Number),
            ("--textures", Takes::Named),
        ],
    ),
    (
        &["texture", "panel", "--rate", "100"],
        &[("--recordings", Takes::Named)],
    ),
    (&["doctor"], &[("--bench", Takes::Named)]),
    (
        &["pulse", "3", "--yes"],
        &[
            ("--bench", Takes::Named),
            ("--finger", Takes::Named),
            ("--layout", Takes::Named),
        ],
    ),
    (
        &["record", "made.log", "--can", "nocan0"],
        &[("--seconds", Takes::Number), ("--quiet", Takes::Nothing)],
    ),
];

/// Bad values of what an option takes.
const fn bad(takes: Takes) -> &'static [&'static str] {
    match takes {
        Takes::Number => &["", "seven", "nan", "-1e9", "1e99", "1,5", "0x10"],
        Takes::Numbers => &["", "seven", "nan", "-1e9", "1e99", "1,", ",", "1,x"],
        Takes::Word => &["", "no-such", "\u{1F980}"],
        Takes::Named => &["", "no-such", "../../etc/shadow-no", "no such"],
        Takes::Nothing => &[],
    }
}

/// Calls that are wrong as a whole, and what their message names.
const CALLS: [(&[&str], &str); 37] = [
    (&["rnu"], "rnu"),
    (&["run", "--no-such"], "--no-such"),
    (&["run", "one", "two"], "two"),
    (&["run", "--rate", "40"], "--replay"),
    (&["run", "--replay"], "--replay"),
    (
        &[
            "run",
            "--replay",
            "taxels.csv",
            "--rate",
            "40",
            "--time",
            "t:s",
        ],
        "--time",
    ),
    (
        &["run", "--replay", "taxels.csv", "--replay", "taxels.csv"],
        "--replay",
    ),
    (
        &["run", "--replay", "a.log", "--replay", "taxels.csv"],
        "a.log",
    ),
    (
        &["run", "--replay", "a.log", "--columns", "txl"],
        "--columns",
    ),
    (&["run", "--json", "--quiet"], "--quiet"),
    (&["run", "scene.toml", "--set", "kc"], "--set"),
    (
        &["run", "scene.toml", "--set", "compression.kc=0"],
        "compression.kc",
    ),
    (&["run", "scene.toml", "--record", "made.xyz"], "made.xyz"),
    (
        &[
            "run",
            "scene.toml",
            "--record",
            "a.log",
            "--record",
            "a.log",
        ],
        "a.log",
    ),
    (&["run", "scene.toml", "--html", "scene.toml"], "scene.toml"),
    (
        &["run", "--replay", "taxels.csv", "--record", "taxels.csv"],
        "taxels.csv",
    ),
    (&["contacts", "taxels.csv"], "--layout"),
    (&["contacts"], "FILE"),
    (&["diff", "a.csv"], "<B>"),
    (&["diff", "a.csv", "a.snap"], "a.snap"),
    (&["diff", "a.csv", "a.csv", "--window", "0..1"], "--window"),
    (&["check"], "FILE"),
    (&["export", "taxels", "scene.toml"], "--out"),
    (&["off"], "--bench"),
    (&["test", ""], "\"\""),
    (&["identify"], "TRACE"),
    (&["identify", "taxels.csv"], "taxels.csv"),
    (
        &["identify", "trace.csv", "--signal", "resistance"],
        "resistance_ohm",
    ),
    (&["sweep", "scene.toml"], "--out"),
    (
        &["sweep", "scene.toml", "--out", "scene.toml"],
        "scene.toml",
    ),
    (
        &["sweep", "scene.toml", "--out", "taxels.csv"],
        "taxels.csv",
    ),
    (&["compare", "summary.json"], "summary.json"),
    (&["compare", "summary.json", "sweep.csv"], "sweep.csv"),
    (&["compare", "folder"], "folder"),
    (&["design", "--out", "taxels.csv"], "taxels.csv"),
    (&["design", "--html", "scene.toml"], "scene.toml"),
    (&["emulate", "--bench", "no-such"], "no-such"),
];

/// The tries.
pub fn tries() -> Vec<Try> {
    let mut tries: Vec<Try> = CALLS
        .iter()
        .map(|(args, by)| Try::refused(args, by))
        .collect();
    for (base, options) in COMMANDS {
        for &(option, takes) in options {
            let call = |more: &[&str], expect: Expect| Try::new(&[base, more].concat(), expect);
            let refused = || Expect::Refused(option.to_owned());
            for value in bad(takes) {
                // What is looked up is named itself.
                let by = match takes {
                    Takes::Named if !value.is_empty() => *value,
                    Takes::Named => "",
                    _ => option,
                };
                tries.push(call(&[option, value], Expect::Refused(by.to_owned())));
            }
            match takes {
                Takes::Nothing => tries.push(call(&[&format!("{option}=yes")], refused())),
                _ => tries.push(call(&[option], refused())),
            }
            let repeats = matches!(option, "--set" | "--pin" | "--alloy");
            if !repeats && (base[0], option) != ("design", "--wire") {
                let value: &[&str] = match takes {
                    Takes::Nothing => &[option, option],
                    _ => &[option, "1", option, "1"],
                };
                tries.push(call(value, refused()));
            }
        }
    }
    tries
}
