//! A session of a study under a clock that is set.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::sync::atomic::Ordering;

use serde_json::json;

use crate::rig::on_bench;
use crate::study_page::Page;

const HOUR_NS: i64 = 3_600_000_000_000;
const PROTOCOL: &str = r#"
name = "one"
description = "One wire"
pause_s = 0.1
stimulus_s = 1.0
[localisation]
wires = [1]
level_db = 0.0
repeats = 5
simulated = { bias_mm = { mean = 0.0, sd = 1.0 }, noise_mm = 2.0, slips = 0.0 }
"#;

#[test]
fn a_clock_that_is_set_forward_cools_no_one() {
    on_bench(1, |bench| {
        fs::write(bench.path("one.toml"), PROTOCOL).unwrap();
        let words = ["study", "run", "one.toml", "--participant", "1"];
        let words = [&words[..], &["--out", "study", "--at", "0"]].concat();
        let mut command = bench.program(Path::new(env!("CARGO_BIN_EXE_hil")), &words);
        let spawned = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
        let mut session = spawned.unwrap();
        bench.leave(session.id());
        let mut line = String::new();
        let mut told = BufReader::new(session.stderr.take().unwrap());
        told.read_line(&mut line).unwrap();
        let (_, url) = line.split_once("http://").unwrap();
        let (host, _) = url.split_once('/').unwrap();

        let mut participant = Page::open(host, "", "participant");
        let view = participant.on("begin");
        participant.say(&json!({ "view": view, "reply": "read" }));
        let view = participant.on("place");
        let mut experimenter = Page::open(host, "", "experimenter");
        let before = experimenter.limits()["skin_mean"];
        bench.clock.realtime_ns.store(HOUR_NS, Ordering::Release);
        participant.say(&json!({ "view": view, "reply": { "answer": { "place": [0.0, 1.0] } } }));
        let after = experimenter.limits()["skin_mean"];
        assert!(before > 0.0 && after > 0.5 * before, "{before} {after}");
        participant.say(&json!({ "stop": true }));
        assert_eq!(session.wait().unwrap().code(), Some(4));
    });
}
