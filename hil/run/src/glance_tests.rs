//! Eight lines of 80 columns, whatever a run came to.

use palpate_files::{Overrides, Setup, load_bench, load_scene};

use super::*;
use crate::{Input, Keep, Outcome, run_with};

fn played(scene: &str, set: &[&str]) -> Outcome {
    let mut overrides = Overrides::default();
    for text in set {
        overrides.set("--set", text).unwrap();
    }
    let scene = load_scene(scene).unwrap().with(&overrides).unwrap();
    let bench = load_bench(scene.value.own_bench()).unwrap();
    let setup = Setup::join(scene, bench).unwrap();
    let keep = Keep {
        spread: true,
        ..Keep::default()
    };
    run_with(&setup, &Input::Scene, 1, keep, &mut ()).unwrap()
}

fn glance(outcome: &Outcome) -> Vec<String> {
    let mut out = Vec::new();
    let summary = &outcome.summary;
    summary.write(&mut out, (false, false), &[]).unwrap();
    let text = String::from_utf8(out).unwrap();
    text.lines().map(str::to_owned).collect()
}

#[test]
fn the_default_scene_is_eight_lines_with_the_verdict_last() {
    let lines = glance(&played("sphere-along", &["length_s=3"]));
    assert_eq!(lines.len(), 8, "{lines:#?}");
    assert!(
        lines.iter().all(|line| line.chars().count() <= 80),
        "{lines:#?}"
    );
    assert!(lines[0].starts_with("sphere-along on emulated, seed 1: 3.0 s emulated in "));
    let begins = [
        "path error",
        "felt",
        "felt error",
        "hottest skin",
        "longest session",
        "next",
    ];
    for (line, name) in lines[1..7].iter().zip(begins) {
        assert!(line.starts_with(&format!("  {name} ")), "{line}");
    }
    assert!(lines[1].ends_with("at most; pitch 4.7 mm"), "{}", lines[1]);
    assert!(lines[2].contains("94 % of 19 onsets"), "{}", lines[2]);
    assert!(lines[2].contains(" um; band -"), "{}", lines[2]);
    assert!(lines[3].contains("over all ") && lines[3].ends_with(" inside the wires"));
    assert_eq!(lines[7], "OK");
}

#[test]
fn other_verdicts_say_what_to_do_and_keep_the_width() {
    let weak = "touches=[{ start_s = 0.8, path = { kind = \"hold\", points_mm = [[0.0, 0.0]] }, force_n = { mean = 0.001 } }]";
    let off = weak.replace("0.0, 0.0", "60.0, 0.0");
    let runs = [
        ("sphere-along", vec![weak], Verdict::NotFelt, "press harder"),
        (
            "sphere-along",
            vec![&off],
            Verdict::OffThePad,
            "move the touches",
        ),
        (
            "stuck-amplifier",
            vec![],
            Verdict::BeyondTheModel,
            "would be burnt",
        ),
        ("idle", vec![], Verdict::Ok, "--html"),
        ("ten-fingers", vec![], Verdict::Ok, "--html"),
    ];
    for (scene, set, verdict, advice) in runs {
        let outcome = played(scene, &[set, vec!["length_s=3"]].concat());
        assert_eq!(outcome.summary.conclusion.verdict, verdict, "{scene}");
        let lines = glance(&outcome);
        let others = outcome.summary.conclusion.why.len().max(1) - 1;
        assert!(lines.len() >= 8 + others, "{lines:#?}");
        assert!(
            lines.iter().all(|line| line.chars().count() <= 80),
            "{lines:#?}"
        );
        assert!(lines[6].contains(advice), "{lines:#?}");
        assert!(!lines.concat().contains("no break"), "{lines:#?}");
    }
}

#[test]
fn a_wide_line_loses_its_middle() {
    let line = format!("{} on emulated, seed 1", "x".repeat(90));
    let told = fitted(&line);
    assert_eq!(told.chars().count(), 80);
    assert!(told.starts_with("xxx") && told.ends_with(" on emulated, seed 1"));
    assert_eq!(fitted("short"), "short");
}
