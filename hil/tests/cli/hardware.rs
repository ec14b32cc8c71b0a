//! What the command line may say of a bench of hardware: where it is, and a stricter limit.

use super::*;

#[test]
fn no_option_makes_hardware_of_an_emulated_bench() {
    for command in [
        &["run", "idle"][..],
        &["test", "idle"],
        &["unit", "--key", "k"],
    ] {
        for devices in [
            &["--can", "can7"][..],
            &["--i2c", "/dev/i2c-7"],
            &["--can", "can7", "--i2c", "/dev/i2c-7"],
        ] {
            if command[0] == "unit" && devices != ["--i2c", "/dev/i2c-7"] {
                continue;
            }
            let folder = Folder::new("no-hardware");
            let key = folder.path("k").display().to_string();
            good(&["unit", "--new-key", &key]);
            let command = command
                .iter()
                .map(|word| if *word == "k" { &*key } else { word });
            let args: Vec<&str> = command.chain(devices.iter().copied()).collect();
            let message = refused(&args);
            let line = message
                .split('`')
                .find(|text| text.starts_with("hil new bench"));
            let line = line.unwrap_or_else(|| panic!("{args:?}: {message}"));
            // The line is one that works as it stands.
            let words: Vec<&str> = line.split(' ').skip(1).collect();
            let made = hil_in(&folder.0, &words);
            assert_eq!(made.status, Some(0), "{line}: {}", made.err);
            assert!(
                folder.text("my-bench.toml").contains("kind = \"real\""),
                "{line}"
            );
        }
    }
}

#[test]
fn an_address_that_replaces_none_is_refused() {
    let folder = Folder::new("too-many");
    let bench = real_bench(&folder);
    for (option, devices) in [
        ("--can", ["can7", "can8"]),
        ("--i2c", ["/dev/i2c-7", "/dev/i2c-8"]),
    ] {
        let [first, second] = devices;
        let args = [
            "run", "idle", "--bench", &bench, option, first, option, second,
        ];
        let at_most = format!("{option}: expected at most 1,");
        refused_with(&args, &[&*at_most, "`real`", "found 2"]);
    }
}

#[test]
fn a_fact_of_hardware_is_changed_in_its_file_alone() {
    let folder = Folder::new("facts");
    let bench = real_bench(&folder);
    let set = ["--bench", &bench, "--set", "bench.drive.current_ma=10"];
    let words = ["--set: drive.current_ma", "change the bench's own file"];
    refused_with(&[&["run", "idle"][..], &set].concat(), &words);
    refused_with(&[&["test", "idle"][..], &set].concat(), &words);
    let table = folder.path("runs.csv").display().to_string();
    refused_with(
        &[&["sweep", "idle", "--out", &table][..], &set].concat(),
        &words,
    );
    // A limit that is tightened gets as far as the devices.
    let tighter = [
        "run",
        "idle",
        "--bench",
        &bench,
        "--set",
        "bench.real.heartbeat_ms=20",
    ];
    let said = hil(&tighter);
    assert_eq!(said.status, Some(3), "{}", said.err);
    let looser = [
        "run",
        "idle",
        "--bench",
        &bench,
        "--set",
        "bench.real.heartbeat_ms=31",
    ];
    refused_with(&looser, &["--set: real.heartbeat_ms", "at most 30 ms"]);
}

#[test]
fn a_condition_of_a_study_changes_no_fact_of_hardware() {
    let folder = Folder::new("condition");
    let bench = real_bench(&folder);
    let protocol = folder.write(
        "p.toml",
        r#"name = "p"
description = "Understated current"
[[conditions]]
name = "weak"
scene = "brush-strokes"
set = ["bench.drive.current_ma=10"]
[rating]
conditions = ["weak"]
compare = []
groups = "within"
repeats = 1
simulated = { rating = { mean = 3.0, sd = 0.5 }, noise = 0.5, difference = 1.0 }
scales = [{ name = "strength", low = "none", high = "much" }]
"#,
    );
    let out = folder.path("out").display().to_string();
    let protocol = protocol.display().to_string();
    let args = [
        "study",
        "run",
        &protocol,
        "--participant",
        "1",
        "--out",
        &out,
        "--bench",
        &bench,
    ];
    let words = [
        "p.toml: conditions[0].set: drive.current_ma",
        "change the bench's own file",
    ];
    refused_with(&args, &words);
    assert!(!folder.path("out").exists());
}

#[test]
fn a_heartbeat_that_a_burst_outlasts_is_refused_with_the_arithmetic() {
    let folder = Folder::new("slow");
    let bench = real_bench(&folder);
    let text = fs::read_to_string(&bench).unwrap();
    for key in ["heartbeat_ms", "transfer_ms"] {
        let slow = text.replace("[real]", &format!("[real]\n{key} = 60"));
        let slow = folder.write("slow.toml", &slow).display().to_string();
        let words = [
            &*format!("real.{key}: expected at most"),
            "found 60",
            "a PWM period",
            "a burst may last 50 ms",
        ];
        refused_with(&["run", "sphere-along", "--bench", &slow], &words);
    }
}
