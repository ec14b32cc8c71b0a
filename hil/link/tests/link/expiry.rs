//! A certificate whose time runs out while its link is open.

use palpate_link::net::{Lab, Member};

use time::Duration;

use super::programs::{Folder, display, port, skin};

/// Keys of a robot and a wearer.
fn lab(folder: &Folder, robot: Duration, wearer: Duration) {
    let own = || vec!["r1/*/*".to_owned()];
    for (name, publishes, feels, lasts) in [
        ("r1", own(), Vec::new(), robot),
        ("anna", Vec::new(), own(), wearer),
    ] {
        let member = Member {
            name: name.into(),
            publishes,
            feels,
            watches: false,
            relays: false,
        };
        Lab::make(folder.path(), &[member], lasts).unwrap();
    }
}

const LONG: Duration = Duration::seconds(3600);
const SHORT: Duration = Duration::seconds(7);
/// TLS counts whole seconds, and a machine may be busy for a while.
const LATEST_S: f64 = 8.5;

fn ends_in_time(robot: Duration, wearer: Duration) {
    let folder = Folder::new();
    lab(&folder, robot, wearer);
    let port = port();
    let keys = |name: &str| folder.file(name);
    let (r1, anna) = (keys("r1"), keys("anna"));
    let robot_expires = robot == SHORT;
    let robot = skin(&port, &["--seconds", "13", "--keys", &r1]);
    let wearer = display(&port, &["--seconds", "12", "--keys", &anna]);
    let (status, felt, said) = wearer.ended();
    let (robot_status, sent, told) = robot.ended();
    let wanted = (Some(0), Some(if robot_expires { 3 } else { 0 }));
    assert_eq!((status, robot_status), wanted, "{said}{told}");
    // It was felt, then no more, and the outputs went off by the age of the newest reading.
    assert!(felt["held"].as_u64().unwrap() > 150, "{felt}{said}{told}");
    let held_s = felt["held"].as_f64().unwrap() / 100.0;
    assert!(held_s < LATEST_S, "felt for {held_s} s: {felt}{said}{told}");
    let last = felt["pauses"].as_array().unwrap().last().unwrap();
    assert!(last["back_us"].is_null(), "{last}{said}{told}");
    let newest = last["newest_us"].as_u64().unwrap();
    assert!((newest as f64) < LATEST_S * 1e6, "{last}");
    let off = last["off_us"].as_u64();
    assert!(off.is_none_or(|off| off - newest <= 103_000), "{last}");
    let expired = "has expired: make another with `palpate-link keys`";
    assert!(said.contains(expired), "the wearer: {said}");
    assert!(told.contains(expired), "the robot: {told}");
    assert!(
        robot_expires || sent["frames"].as_u64().unwrap() > 1000,
        "{sent}"
    );
}

#[test]
fn a_robots_certificate_that_expires_ends_its_link() {
    ends_in_time(SHORT, LONG);
}

#[test]
fn a_wearers_certificate_that_expires_ends_its_link() {
    ends_in_time(LONG, SHORT);
}
