//! A glove bends an emulated hand, whose skin is felt: three programs on this machine.

use super::programs::{FINGER, link, port};

const SCENE: &str = "finger-flexes";

#[test]
fn a_glove_bends_the_hand_and_the_wearer_feels_it() {
    let port = port();
    let with =
        |command: &[&str], more: &[&str]| link(&[command, &["--json"], &FINGER, more].concat());
    let skin = with(
        &["skin", SCENE, "--glove", "anna", "--listen", &port],
        &["--seconds", "9"],
    );
    let display = with(
        &["display", SCENE, "--wearer", "anna", "--connect", &port],
        &["--seconds", "7"],
    );
    let glove = with(
        &["glove", SCENE, "--wearer", "anna", "--connect", &port],
        &["--seconds", "6"],
    );
    let (bent_status, bent, said) = glove.ended();
    let (felt_status, felt, heard) = display.ended();
    let (sent_status, sent, told) = skin.ended();
    let statuses = (bent_status, felt_status, sent_status);
    assert_eq!(statuses, (Some(0), Some(0), Some(0)), "{said}{heard}{told}");
    // The skin sends 100 frames per second, and each answers the newest message.
    let answered = bent["answered"].as_u64().unwrap();
    assert!(answered > 200, "{bent}{told}");
    let median = bent["round_trip_ms"]["median"].as_f64().unwrap();
    assert!((0.0..60.0).contains(&median), "{bent}");
    assert!(felt["stimuli"].as_u64().unwrap() > 0, "{felt}{heard}");
    assert!(sent["frames"].as_u64().unwrap() > 200, "{sent}");
    assert!(told.contains("the glove of anna bends the hand"), "{told}");
    assert!(told.contains("the glove of anna fell silent"), "{told}");
    println!("round trip {}", bent["round_trip_ms"]);
}

#[test]
fn without_a_glove_nothing_is_touched_and_what_cannot_follow_is_refused() {
    let port = port();
    let glove = link(
        &[
            &["glove", SCENE, "--seconds", "0.5", "--listen", &port],
            &FINGER[..],
        ]
        .concat(),
    );
    let (status, _, said) = glove.ended();
    assert_eq!(status, Some(0), "{said}");
    for (arguments, expected) in [
        (
            &["skin", "sphere-along", "--glove", "anna"][..],
            "--glove: expected a scene with a joint that presses",
        ),
        (
            &["glove", "sphere-along"],
            "sphere-along: expected a scene with [[joints]]",
        ),
        (&["glove", "--replay", "missing.csv"], "missing.csv"),
    ] {
        let (status, _, said) = link(&[arguments, &FINGER[..]].concat()).ended();
        assert_eq!(status, Some(2), "{said}");
        assert!(said.contains(expected), "{said}");
    }
}
