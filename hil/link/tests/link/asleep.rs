//! Machines that stand still for two seconds and go on: what they missed is not felt afterwards.

use serde_json::Value;

use super::programs::{display, pause, port, skin};

/// The pauses of a wearer, microseconds: newest reading, off, the next stimulus.
fn pauses(felt: &Value) -> Vec<(u64, Option<u64>, Option<u64>)> {
    let all = felt["pauses"].as_array().unwrap().iter();
    let times = all.map(|p| {
        let at = |key: &str| p[key].as_u64();
        (at("newest_us").unwrap(), at("off_us"), at("back_us"))
    });
    times.collect()
}

#[test]
fn a_robot_that_stood_still_is_felt_again_and_nothing_of_what_it_missed() {
    let port = port();
    let mut robot = skin(&port, &["--seconds", "30"]);
    let wearer = display(&port, &["--seconds", "9"]);
    pause(3500);
    robot.signal("STOP");
    pause(2000);
    robot.signal("CONT");
    let (status, felt, said) = wearer.ended();
    assert_eq!(status, Some(0), "{said}");
    robot.signal("INT");
    let (_, sent, told) = robot.ended();
    // The frames of two seconds came at once, each with its own age, or found no room on the way.
    let count = |key: &str| felt["frames"][key].as_u64().unwrap();
    assert!(count("late") + count("lost") > 150, "{felt}");
    assert!(felt["age_ms"]["max"].as_f64().unwrap() < 100.0, "{felt}");
    let pauses = pauses(&felt);
    let long = pauses
        .iter()
        .filter(|p| p.2.is_none_or(|back| back - p.0 > 1_500_000));
    assert_eq!(long.count(), 1, "{pauses:?}");
    for (newest, off, back) in &pauses {
        assert!(off.is_none_or(|off| off - newest <= 103_000), "{pauses:?}");
        assert!(back.is_some(), "felt again: {pauses:?}{sent}{told}");
    }
}

#[test]
fn a_wearer_that_stood_still_feels_again_and_nothing_that_came_meanwhile() {
    let port = port();
    let mut robot = skin(&port, &["--seconds", "30"]);
    let mut wearer = display(&port, &["--seconds", "9"]);
    pause(3500);
    wearer.signal("STOP");
    pause(2000);
    wearer.signal("CONT");
    let (status, felt, said) = wearer.ended();
    assert_eq!(status, Some(0), "{said}");
    robot.signal("INT");
    robot.ended();
    // What waited in the kernel arrived late, and was judged so.
    let worst = felt["age_ms"]["max"].as_f64().unwrap();
    assert!(worst < 100.0, "{felt}");
    let pauses = pauses(&felt);
    let long = pauses
        .iter()
        .filter(|p| p.2.is_none_or(|back| back - p.0 > 1_500_000));
    assert_eq!(long.count(), 1, "{felt}{said}");
    assert!(pauses.iter().all(|p| p.2.is_some()), "{felt}{said}");
}
