//! A bench of motors through the program: what runs on it, and what refuses it.

use super::*;

#[test]
fn a_scene_on_motors_says_what_moves_and_how_long_a_hand_bears_it() {
    let said = hil(&["run", "sphere-along", "--bench", "lra-8"]);
    assert_eq!(
        (said.status, said.err.as_str()),
        (Some(0), ""),
        "{}",
        said.out
    );
    for words in ["motors", "coil", "exposure", "A(8)"] {
        assert!(said.out.contains(words), "{words}: {}", said.out);
    }
    for words in ["hottest skin", "longest session", "band"] {
        assert!(!said.out.contains(words), "{words}: {}", said.out);
    }
    let longest = said.out.lines().map(|line| line.chars().count()).max();
    assert!(longest <= Some(80), "{}", said.out);
}

#[test]
fn records_of_motors_name_levels_and_motors() {
    let folder = Folder::new("motors");
    let run = ["run", "sphere-along", "--bench", "lra-8", "--json"];
    let files = [
        "--html",
        "r.html",
        "--schedule",
        "s.jsonl",
        "--record",
        "m.mcap",
    ];
    let said = hil_in(&folder.0, &[&run[..], &files].concat());
    assert_eq!(said.status, Some(0), "{}", said.err);
    let summary: serde_json::Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(summary["motors"]["kind"], "lra");
    assert!(summary["hottest_wire_c"].is_null());
    let page = fs::read_to_string(folder.0.join("r.html")).unwrap();
    assert!(page.contains("motor 7") && page.contains("largest level"));
    assert!(!page.contains("wire 7") && !page.contains("PWM, true"));
    let schedule = fs::read_to_string(folder.0.join("s.jsonl")).unwrap();
    assert!(schedule.lines().count() > 500);
}

#[test]
fn what_is_of_wires_refuses_motors_in_a_sentence() {
    for (arguments, words) in [
        (
            &[
                "run",
                "sphere-along",
                "--bench",
                "lra-8",
                "--illusion",
                "inverse",
            ][..],
            "expected a law for motors on bench `lra-8`: phantom, energy, linear",
        ),
        (
            &["run", "sphere-along", "--bench", "lra-8", "--observe"],
            "only a guard of wires can look on",
        ),
        (
            &["run", "texture-wood", "--bench", "lra-8"],
            "a texture is made of a wire's pulses",
        ),
        (&["calibrate", "lra-8"], "expected a bench of wires"),
        (
            &["design", "--response", "lra-8"],
            "expected a bench of wires",
        ),
    ] {
        let said = hil(arguments);
        assert_eq!(said.status, Some(2), "{arguments:?}: {}", said.out);
        assert!(said.err.contains(words), "{arguments:?}: {}", said.err);
        assert_eq!(said.err.trim_end().lines().count(), 1, "{}", said.err);
    }
}
