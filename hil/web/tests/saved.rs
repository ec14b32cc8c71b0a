//! A session that is saved and run again comes to the same bits.

#![allow(clippy::unwrap_used)]

use palpate_web::Page;
use proptest::prelude::*;
use serde_json::{Value, json};

fn ask(page: &mut Page, request: &Value) -> Value {
    let answer: Value = serde_json::from_str(&page.answer(&request.to_string())).unwrap();
    assert!(answer["error"].is_null(), "{request}: {}", answer["error"]);
    answer["ok"].clone()
}

/// Every stimulus of a picture as the schedule has it: when, until when, and how wide.
fn bursts(picture: &Value, out: &mut Vec<(u64, u64, u64, u64)>) {
    for burst in picture["bursts"].as_array().unwrap() {
        let field = |name: &str| burst[name].as_u64().unwrap();
        out.push((
            field("at_us"),
            field("until_us"),
            field("asked"),
            field("ticks"),
        ));
    }
}

/// One finger's next state: who, where (um), how hard (mN).
type Move = (usize, i64, i64, i64);

fn played(scene: &str, bench: &str, set: &[&str], moves: &[Vec<Move>]) {
    let mut page = Page::default();
    let head = ask(
        &mut page,
        &json!({ "do": "open", "scene": scene, "bench": bench, "set": set }),
    );
    let mut now = head["quiet_us"].as_u64().unwrap() + 10_000;
    ask(&mut page, &json!({ "do": "step", "until_us": now }));
    let mut live = Vec::new();
    let module = head["drives"].as_u64().unwrap();
    for fingers in moves {
        now += 16_667;
        let fingers: Vec<Value> = fingers
            .iter()
            .map(|(n, x, y, force)| json!([n, module, x, y, force, 12_000]))
            .collect();
        let step = json!({ "do": "step", "until_us": now, "fingers": fingers });
        bursts(&ask(&mut page, &step), &mut live);
    }
    let saved = ask(&mut page, &json!({ "do": "save" }));
    let again = json!({ "do": "run", "text": saved["text"], "bench": bench });
    let run = ask(&mut page, &again);
    assert_eq!(run["schedule"], repeated(&saved, bench));
    let mut replayed = Vec::new();
    for line in run["lines"].as_str().unwrap().lines().skip(1) {
        let line: Value = serde_json::from_str(line).unwrap();
        if let (Some(requested), Some(at)) = (line["requested"].as_u64(), line["t_us"].as_u64())
            && at < live.last().map_or(0, |last| last.0) + 1
        {
            let width = line["off"].as_u64().unwrap() - line["on"].as_u64().unwrap();
            replayed.push((at, line["until_us"].as_u64().unwrap(), requested, width));
        }
    }
    live.sort_unstable();
    replayed.sort_unstable();
    assert_eq!(live, replayed, "{scene} on {bench}");
}

/// The digest of a saved session's schedule, by a session of it that is played to its end.
fn repeated(saved: &Value, bench: &str) -> Value {
    let mut page = Page::default();
    let open = json!({ "do": "open", "text": saved["text"], "bench": bench });
    ask(&mut page, &open);
    let end_us = (saved["length_s"].as_f64().unwrap() * 1e6).round() as u64;
    let mut now = 0;
    while now < end_us {
        now = (now + 300_000).min(end_us);
        ask(&mut page, &json!({ "do": "step", "until_us": now }));
    }
    ask(&mut page, &json!({ "do": "end" }))["digest"].clone()
}

fn moves() -> impl Strategy<Value = Vec<Vec<Move>>> {
    let one = (
        0usize..3,
        -9000i64..9000,
        -9000i64..9000,
        prop_oneof![Just(0), 100i64..2000],
    );
    proptest::collection::vec(proptest::collection::vec(one, 0..3), 20..90)
}

/// A finger that goes across the pad in a second and a half.
fn across() -> Vec<Vec<Move>> {
    (0..90)
        .map(|n| vec![(0, -7000 + 150 * n, 1000, 900)])
        .collect()
}

#[test]
fn a_finger_is_felt_and_comes_again_on_every_kind_of_bench() {
    for (scene, bench) in [
        ("idle", "emulated"),
        ("idle", "thesis"),
        ("sphere-along", "emulated"),
        ("idle", "unit"),
        ("sphere-streamed", "emulated"),
        ("two-finger-press", "three-in-line"),
        ("icub-patch-stroke", "emulated"),
        ("idle", "lra-8"),
        ("sphere-along", "voice-coil-8"),
        ("idle", "lra-grid-4x3"),
    ] {
        played(scene, bench, &[], &across());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn any_fingers_come_again(moves in moves()) {
        played("idle", "emulated", &["compression.kc_touches=3"], &moves);
    }
}

#[test]
fn the_number_of_contacts_follows_the_fingers() {
    let fingers = [[-5000, 5000], [5000, -4000]];
    for (set, contacts) in [(&[][..], 1), (&["compression.kc_touches=4"][..], 2)] {
        let mut page = Page::default();
        let open = json!({ "do": "open", "scene": "idle", "bench": "emulated", "set": set });
        let quiet_us = ask(&mut page, &open)["quiet_us"].as_u64().unwrap() + 10_000;
        ask(&mut page, &json!({ "do": "step", "until_us": quiet_us }));
        let mut step = |after_us: u64, forces: [i64; 2]| {
            let fingers = fingers.iter().zip(forces).enumerate();
            let fingers: Vec<Value> = fingers
                .map(|(n, ([x, y], force))| json!([n, 0, x, y, force, 9000]))
                .collect();
            let until_us = quiet_us + after_us;
            let step = json!({ "do": "step", "until_us": until_us, "fingers": fingers });
            ask(&mut page, &step)["contacts"]
                .as_array()
                .unwrap()
                .clone()
        };
        let found = step(500_000, [900, 900]);
        assert_eq!(found.len(), contacts, "{set:?}");
        for [x, y] in fingers.iter().filter(|_| contacts == 2) {
            let near = found.iter().filter(|contact| {
                let [u, v] = [0, 1].map(|n| contact["at_mm"][n].as_f64().unwrap());
                (u - f64::from(*x) * 1e-3).hypot(v - f64::from(*y) * 1e-3) < 2.0
            });
            assert_eq!(near.count(), 1, "{x} {y}: {found:?}");
        }
        assert_eq!(step(900_000, [900, 0]).len(), 1);
        assert_eq!(step(1_300_000, [0, 0]).len(), 0);
    }
}

#[test]
fn what_cannot_be_is_a_sentence() {
    let mut page = Page::default();
    for (request, expected) in [
        ("{", "request: "),
        (
            "{\"do\":\"step\",\"until_us\":5}",
            "expected an open session",
        ),
        (
            "{\"do\":\"open\",\"scene\":\"nowhere\",\"bench\":\"emulated\"}",
            "nowhere",
        ),
        (
            "{\"do\":\"open\",\"scene\":\"allegro-grasp\",\"bench\":\"allegro-hand\"}",
            "one display",
        ),
        (
            "{\"do\":\"open\",\"text\":\"name = 1\",\"bench\":\"emulated\"}",
            "the session",
        ),
        (
            "{\"do\":\"open\",\"scene\":\"idle\",\"bench\":\"emulated\",\"set\":[\"layout=million\"]}",
            "taxels",
        ),
    ] {
        let answer: Value = serde_json::from_str(&page.answer(request)).unwrap();
        let error = answer["error"].as_str().unwrap();
        assert!(error.contains(expected), "{request}: {error}");
    }
    ask(
        &mut page,
        &json!({ "do": "open", "scene": "idle", "bench": "emulated" }),
    );
    for finger in [
        json!([0, 0, 0, 0, 500, 12000]),
        json!([0, 7, 0, 0, 500, 12000]),
        json!([0, 0, 9_000_000, 0, 500, 12000]),
    ] {
        let request = json!({ "do": "step", "until_us": 0, "fingers": [finger] }).to_string();
        let answer: Value = serde_json::from_str(&page.answer(&request)).unwrap();
        assert!(
            answer["error"].as_str().unwrap().contains("expected"),
            "{answer}"
        );
        ask(&mut page, &json!({ "do": "step", "until_us": 600_000 }));
    }
}
