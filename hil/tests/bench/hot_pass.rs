//! The hot pass on hardware: cold wires are heated once, in turn, before the scene; the state outlives the run, and a death in
//! the middle of a pass leaves it unknown.

use std::fs;
use std::time::Duration;

use serde_json::Value;

use crate::rig::{Bench, now_ns, on_bench};
use crate::run::Said;

/// Time that a run with a pass is given to end: three wires take a second each.
const END: Duration = Duration::from_secs(20);

/// Lets the bench have three wires, which are passed before a run.
fn three_cold_wires(bench: &Bench) {
    let text = fs::read_to_string(bench.path("bench.toml")).unwrap();
    let text = text.replace("thimble-8", "three-in-line");
    let text = text.replace("hot_pass = false", "hot_pass = true");
    let (head, outputs) = text.split_once("[[outputs]]").unwrap();
    let three: Vec<&str> = outputs.split("[[outputs]]").take(3).collect();
    let text = format!("{head}[[outputs]]{}", three.join("[[outputs]]"));
    fs::write(bench.path("bench.toml"), text).unwrap();
}

/// Writes a scene that ends before its reference is taken, so that nothing but a pass drives; its name.
fn still(bench: &Bench) -> &'static str {
    let text = "name = \"still\"\ndescription = \"Nothing is felt\"\nlength_s = 0.4\n";
    fs::write(bench.path("still.toml"), text).unwrap();
    "still.toml"
}

/// A short run, its summary, and whether wires were driven in it.
fn run(bench: &Bench) -> (Said, Value, bool) {
    let _ = fs::remove_file(bench.path("lo.rx"));
    let _feed = bench.feed();
    let words = ["run", still(bench), "--bench", "bench.toml", "--json"];
    let at = now_ns();
    let said = bench.start(&words).finish(END);
    let summary = serde_json::from_str(&said.out).unwrap_or_default();
    let has_driven = bench.longest_on_since(at) > 0.0;
    (said, summary, has_driven)
}

#[test]
fn two_runs_pass_once_and_a_display_that_was_off_is_passed_again() {
    on_bench(1, |bench| {
        three_cold_wires(bench);
        let (said, first, _) = run(bench);
        assert_eq!(said.status, Some(0), "{said:?}");
        assert!(said.err.contains("each wire is heated in turn"), "{said:?}");
        let pass = &first["pass"];
        assert_eq!(
            (&pass["passed"], &pass["wires"]),
            (&3.into(), &3.into()),
            "{said:?}"
        );
        assert_eq!(first["felt"]["state"], "assumed passed", "{first}");
        // The scene's own time begins after the pass.
        assert!(first["sim_s"].as_f64().unwrap() < 2.0, "{first}");

        let (said, second, _) = run(bench);
        assert_eq!(said.status, Some(0), "{said:?}");
        assert!(second["pass"].is_null(), "{second}");
        let why = second["no_pass"].as_str().unwrap();
        assert!(
            why.contains("an earlier run has passed these wires"),
            "{why}"
        );
        assert_eq!(second["felt"]["state"], "assumed passed");

        let forgotten = bench.off(&["--bench", "bench.toml", "--forget-heat", "fake"]);
        assert_eq!(forgotten.status, Some(0), "{forgotten:?}");
        let (said, third, _) = run(bench);
        assert_eq!(said.status, Some(0), "{said:?}");
        assert_eq!(third["pass"]["passed"], 3, "{third}");
    });
}

#[test]
fn a_death_in_a_pass_leaves_outputs_off_and_the_wires_cold() {
    on_bench(1, |bench| {
        three_cold_wires(bench);
        let feed = bench.feed();
        let run_to_be_killed = bench.start(&Bench::run_words(still(bench)));
        run_to_be_killed.wait_until_on();
        run_to_be_killed.kill();
        let at = now_ns();
        run_to_be_killed.finish(END);
        drop(feed);
        bench.assert_off_within(crate::rig::OFF_MS, at);
        let cleared = bench.off(&["--bench", "bench.toml", "--unlatch"]);
        assert_eq!(cleared.status, Some(0), "{cleared:?}");
        // The reserve of the dead run stays booked, and the guard lets nothing heat the wires again.
        let (said, next, has_driven) = run(bench);
        assert_eq!(said.status, Some(0), "{said:?}");
        assert_eq!(
            (&next["pass"]["state"], has_driven),
            (&"cold".into(), false)
        );
        assert!(
            said.err.contains("NOT PASSED: the guard refused"),
            "{said:?}"
        );
        // Nor is a wire that was not heated kept as passed.
        let forgotten = bench.off(&["--bench", "bench.toml", "--forget-heat", "fake"]);
        assert_eq!(forgotten.status, Some(0), "{forgotten:?}");
        let (said, next, has_driven) = run(bench);
        assert_eq!(said.status, Some(0), "{said:?}");
        assert!(has_driven && next["pass"]["passed"] == 3, "{next}");
    });
}

#[test]
fn a_bench_that_forbids_it_drives_nothing_before_its_scene() {
    on_bench(1, |bench| {
        three_cold_wires(bench);
        let text = fs::read_to_string(bench.path("bench.toml")).unwrap();
        let text = text.replace("hot_pass = true", "hot_pass = false");
        fs::write(bench.path("bench.toml"), text).unwrap();
        let (said, summary, has_driven) = run(bench);
        assert_eq!(said.status, Some(0), "{said:?}");
        assert!(
            summary["pass"].is_null() && summary["no_pass"].is_null(),
            "{summary}"
        );
        assert_eq!(summary["felt"]["state"], "cold");
        assert!(!has_driven, "{summary}");
    });
}
