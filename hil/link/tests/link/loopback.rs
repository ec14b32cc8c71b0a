//! Two programs on this machine, over loopback.

use super::programs::{FINGER, Folder, display, link, port, skin};

#[test]
fn contacts_are_felt_and_the_robot_hears_of_the_wearers_end() {
    let port = port();
    let (skin, display) = (
        skin(&port, &["--seconds", "6"]),
        display(&port, &["--seconds", "4"]),
    );
    let (felt_status, felt, said) = display.ended();
    let (sent_status, sent, told) = skin.ended();
    assert_eq!(
        (felt_status, sent_status),
        (Some(0), Some(0)),
        "{said}{told}"
    );
    assert!(felt["held"].as_u64().unwrap() > 150, "{felt}{said}");
    assert!(felt["stimuli"].as_u64().unwrap() > 0, "{felt}{said}");
    assert_eq!(felt["frames"]["late"], 0, "{felt}");
    assert!(felt["age_ms"]["median"].as_f64().unwrap() < 20.0, "{felt}");
    assert_eq!(sent["stops"][0], "wearer: its time is over", "{sent}{told}");
    assert!(told.contains("wearer wearer feels this finger"), "{told}");
}

#[test]
fn scans_are_compressed_by_the_wearers_machine_into_the_same_contacts() {
    let port = port();
    let folder = Folder::new();
    let (robot, wearer) = (folder.file("robot.csv"), folder.file("wearer.csv"));
    let skin = skin(
        &port,
        &[
            "--send",
            "scans",
            "--seconds",
            "6",
            "--record",
            &robot,
            "--force",
        ],
    );
    let display = display(&port, &["--seconds", "4", "--record", &wearer, "--force"]);
    let (_, felt, said) = display.ended();
    let (_, _, told) = skin.ended();
    assert!(felt["held"].as_u64().unwrap() > 150, "{felt}{said}{told}");
    // Places and intensities, without the frames that one end alone counts: the wearer's are among the robot's.
    let places = |name: &str| -> Vec<String> {
        let text = std::fs::read_to_string(name).unwrap();
        let rows = text.lines().skip(1).map(|line| {
            line.split(',')
                .skip(4)
                .take(3)
                .collect::<Vec<_>>()
                .join(",")
        });
        rows.collect()
    };
    let (robot, wearer) = (places(&robot), places(&wearer));
    assert!(wearer.len() > 100);
    let shared = wearer.iter().filter(|row| robot.contains(row)).count();
    assert_eq!(
        shared,
        wearer.len(),
        "{:?} in {:?}",
        &wearer[..3],
        &robot[..3]
    );
}

#[test]
fn a_second_publisher_of_a_finger_is_refused_and_told() {
    let port = port();
    let first = skin(&port, &["--seconds", "4"]);
    let wearer = display(&port, &["--seconds", "3", "--quiet"]);
    let second = link(&[
        "skin",
        "sphere-along",
        "--connect",
        &port,
        FINGER[0],
        FINGER[1],
        "--seconds",
        "3",
    ]);
    let (status, _, said) = second.ended();
    assert_eq!(status, Some(2), "{said}");
    assert!(
        said.contains("expected a finger that is not published")
            || said.contains("refused by wearer"),
        "{said}"
    );
    assert_eq!(wearer.ended().0, Some(0));
    let (status, _, told) = first.ended();
    assert_eq!(status, Some(0));
    assert!(
        told.contains("a second publisher of this finger was refused"),
        "{told}"
    );
}

#[test]
fn ends_of_a_relay_feel_through_it_and_a_second_connection_carries_the_same() {
    let port = port();
    let relay = link(&["relay", "--listen", &port, "--seconds", "9"]);
    let through = |word: &str, seconds: &str| {
        let arguments = [word, "sphere-along", "--json", "--twice", "--relay", &port];
        link(&[&arguments[..], &FINGER, &["--seconds", seconds]].concat())
    };
    let (skin, display) = (through("skin", "6"), through("display", "4"));
    let (status, felt, said) = display.ended();
    let (_, sent, told) = skin.ended();
    assert_eq!(status, Some(0), "{said}{told}");
    assert!(felt["held"].as_u64().unwrap() > 150, "{felt}{said}");
    // What came first was felt, the other was not.
    assert!(felt["frames"]["order"].as_u64().unwrap() > 150, "{felt}");
    assert_eq!(sent["stops"][0], "wearer: its time is over", "{sent}{told}");
    assert_eq!(relay.ended().0, Some(0));
}

#[test]
fn another_layout_is_told_on_both_ends_and_nothing_is_felt() {
    let port = port();
    let skin = skin(&port, &["--seconds", "4"]);
    let arguments = [
        "display",
        "icub-patch-stroke",
        "--json",
        "--connect",
        &port,
        FINGER[0],
        FINGER[1],
    ];
    let display = link(&[&arguments[..], &["--seconds", "2"]].concat());
    let (_, felt, said) = display.ended();
    let (_, _, told) = skin.ended();
    assert_eq!(felt["held"], 0, "{felt}");
    assert!(felt["frames"]["layout"].as_u64().unwrap() > 0, "{felt}");
    assert!(
        said.contains("run the same scene on both machines"),
        "{said}"
    );
    assert!(
        told.contains("run the same scene on both machines"),
        "{told}"
    );
}

#[test]
fn list_says_who_publishes_and_who_feels() {
    let port = port();
    let (skin, display) = (
        skin(&port, &["--seconds", "5"]),
        display(&port, &["--seconds", "4"]),
    );
    // Until both have found each other a list may be empty.
    let mut seen = String::new();
    for _ in 0..3 {
        let (_, listed, _) = link(&["list", "--json", "--connect", &port]).ended();
        seen = listed.to_string();
        let finger = &listed[0];
        if finger["publishers"][0]["session"] == finger["wearers"][0]["feels"]
            && finger["finger"] == "r1/left/index"
        {
            seen.clear();
            break;
        }
    }
    assert_eq!(seen, "");
    display.ended();
    skin.ended();
}

#[test]
fn plain_text_to_another_machine_is_refused() {
    let refused = link(&["skin", "--listen", "0.0.0.0:7450", FINGER[0], FINGER[1]]);
    let (status, _, said) = refused.ended();
    assert_eq!(status, Some(2));
    assert!(said.contains("expected --keys DIR"), "{said}");
}
