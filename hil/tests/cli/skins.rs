//! Skins that are no uSkin module: the iCub's boards, a camera, cells, readings over a network; maps to the display.

use serde_json::Value;

use super::*;

fn summary(args: &[&str]) -> Value {
    serde_json::from_str(&good(args)).unwrap()
}

fn run(scene: &str) -> Value {
    summary(&["run", scene, "--json"])
}

#[test]
fn a_patch_of_the_icub_is_felt_through_its_boards_own_frames() {
    let folder = Folder::new("icub");
    let (log, again) = (folder.path("patch.log"), folder.path("again.csv"));
    let first = folder.path("first.csv");
    let args = ["run", "icub-patch-stroke", "--json", "--record"];
    let of_run = |more: &[&Path]| {
        let mut all: Vec<String> = args.iter().map(|a| (*a).to_owned()).collect();
        all.extend(more.iter().map(|p| p.display().to_string()));
        let all: Vec<&str> = all.iter().map(String::as_str).collect();
        summary(&all)
    };
    let felt = of_run(&[&log]);
    of_run(&[&first]);
    assert_eq!(felt["verdict"], "ok");
    assert!(felt["stimuli"].as_u64().unwrap() > 50);
    assert!(felt["path_error_mm"]["rmse"].as_f64().unwrap() < 2.5);
    let text = fs::read_to_string(&log).unwrap();
    // Class 4, board 1, triangles 0 to 13, both halves of each.
    for id in (0..14).map(|triangle| format!(" 41{triangle:X}#")) {
        let heads = |head: &str| text.matches(&format!("{id}{head}")).count();
        assert!(
            heads("40") > 400 && heads("40").abs_diff(heads("C0")) <= 1,
            "{id}"
        );
    }
    // What was recorded on the bus goes the same way again.
    let (log, again) = (log.display().to_string(), again.display().to_string());
    good(&[
        "run",
        "icub-patch-stroke",
        "--replay",
        &log,
        "--record",
        &again,
    ]);
    assert_eq!(
        fs::read_to_string(again).unwrap(),
        fs::read_to_string(first).unwrap(),
        "contacts"
    );
}

#[test]
fn cameras_cells_and_scattered_taxels_are_felt_too() {
    for (scene, most_mm) in [
        ("digit-circle", 0.1),
        ("h1-patch", 8.0),
        ("scattered-circle", 1.0),
        ("sphere-streamed", 1.0),
    ] {
        let felt = run(scene);
        assert_eq!(felt["verdict"], "ok", "{scene}");
        assert!(felt["stimuli"].as_u64().unwrap() > 50, "{scene}");
        let error = felt["path_error_mm"]["rmse"].as_f64().unwrap();
        assert!(error < most_mm, "{scene}: {error} mm");
    }
}

#[test]
fn a_stream_without_delay_finds_what_the_boards_find_and_losses_are_seen() {
    let at = |set: &[&str]| {
        let mut args = vec!["run", "sphere-streamed", "--json"];
        set.iter().for_each(|key| args.extend(["--set", key]));
        summary(&args)
    };
    let good = ["stream.jitter_ms=0", "stream.late=0", "stream.loss=0"];
    let (whole, torn) = (at(&good), at(&["stream.loss=0.3"]));
    let frames = |run: &Value| run["frames"].as_u64().unwrap();
    assert!(frames(&torn) * 10 < frames(&whole) * 8);
    let error = |run: &Value| run["path_error_mm"]["rmse"].as_f64().unwrap();
    assert!(error(&whole) < error(&at(&[])), "late readings cost");
}

#[test]
fn recordings_of_such_skins_replay_as_they_are() {
    let folder = Folder::new("skins");
    for scene in ["digit-circle", "icub-patch-stroke"] {
        let (csv, a) = (folder.path("taxels.csv"), folder.path("a.csv"));
        let (csv, a) = (csv.display().to_string(), a.display().to_string());
        good(&["export", "taxels", scene, "--out", &csv, "--force"]);
        let replayed = summary(&[
            "run", scene, "--replay", &csv, "--json", "--record", &a, "--force",
        ]);
        assert_eq!(replayed["contacts"], run(scene)["contacts"], "{scene}");
    }
    let Some(data) = shared("fabric_slide/Linen_F150_V20mmps_1.csv") else {
        println!("skipped: no recordings of FabricSlide");
        return;
    };
    let args = [
        "run",
        "--layout",
        "mtb-finger",
        "--columns",
        "channel",
        "--json",
    ];
    let more = ["--time", "timestamp:ms", "--replay", &data];
    let felt = summary(&[&args[..], &more[..]].concat());
    assert!(felt["contacts"].as_u64().unwrap() > 0);
}

/// A real recording, where there are any.
fn shared(name: &str) -> Option<String> {
    let data = std::env::var_os("PALPATE_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        PathBuf::from,
    );
    let path = data.join(name);
    path.exists().then(|| path.display().to_string())
}

#[test]
fn the_icubs_arrays_replay_as_they_are() {
    let Some(data) = shared("icub_texture/icub_0.npy") else {
        println!("skipped: no recordings of the iCub");
        return;
    };
    let args = [
        "run",
        "--layout",
        "icub-forearm",
        "--replay",
        &data,
        "--json",
    ];
    let said = hil(&[&args[..], &["--rate", "50"]].concat());
    assert_eq!(said.status, Some(0), "{}", said.err);
    assert!(said.err.contains("an array's readings are compensated"));
    let felt: Value = serde_json::from_str(&said.out).unwrap();
    assert_eq!(
        felt["frames"],
        200 * 75 + 1,
        "all slides, and a row for the threshold"
    );
    assert!(felt["stimuli"].as_u64().unwrap() > 1000);
    let refused = hil(&args);
    assert_eq!(refused.status, Some(2));
    assert!(refused.err.contains("--rate HZ"), "{}", refused.err);
}

#[test]
fn an_array_is_a_row_per_frame() {
    let folder = Folder::new("npy");
    let array = |shape: &str, values: &[f32]| {
        let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        let path = folder.path("array.npy");
        fs::write(&path, bytes).unwrap();
        let path = path.display().to_string();
        let args = [
            "run",
            "--layout",
            "mtb-finger",
            "--rate",
            "50",
            "--json",
            "--replay",
        ];
        hil(&[&args[..], &[&path]].concat())
    };
    let mut values = vec![0.0; 100 * 16];
    values[50 * 16..]
        .iter_mut()
        .step_by(16)
        .for_each(|v| *v = 90.0);
    let felt = array("(100, 16)", &values);
    assert_eq!(felt.status, Some(0), "{}", felt.err);
    let felt: Value = serde_json::from_str(&felt.out).unwrap();
    assert_eq!(
        (&felt["frames"], &felt["contacts"]),
        (&101.into(), &50.into())
    );
    for (shape, values, said) in [
        ("(100, 15)", &values[..], "an array of frames x 16"),
        ("(100, 16)", &values[..1599], "[100, 16], 1599 numbers"),
        ("(1, 16)", &[-1.0; 16], "values such as `-1`"),
    ] {
        let refused = array(shape, values);
        assert_eq!(refused.status, Some(2));
        assert!(refused.err.contains(said), "{}", refused.err);
    }
}

#[test]
fn a_window_follows_what_happens_on_a_larger_skin() {
    let felt = run("h1-follow");
    assert!(felt["stimuli"].as_u64().unwrap() > 50);
    let explained = good(&[
        "run",
        "h1-follow",
        "--explain",
        "--set",
        "map.hysteresis=0.5",
    ]);
    let said = "a window of 140 mm by 120 mm goes to a contact outside that is 50 % stronger";
    assert!(explained.contains(said), "{explained}");
    // Without the window the whole body is the thimble: each touch is a point on it.
    let folder = Folder::new("follow");
    let still = "name = \"still\"\ndescription = \"the middle patch alone\"\nlayout = \"h1-body\"\n\
                 [compression]\naxes = \"z\"\nscope = \"skin\"\n[map]\nsensor_mm = [-70, -60, 70, 60]\n\
                 [[touches]]\nmodule = 4\nstart_s = 0.8\ndiameter_mm = 60.0\nforce_n = { mean = 4.0 }\n\
                 path = { kind = \"hold\", points_mm = [[0.0, 0.0]] }\n";
    let still = folder.write("still.toml", still).display().to_string();
    let unfelt = run(&still);
    assert!(unfelt["contacts"].as_u64().unwrap() > 0);
    assert_eq!(unfelt["stimuli"], 0, "outside the region nothing is felt");
}

#[test]
fn a_map_outside_its_skin_is_refused_with_the_arithmetic() {
    for (set, said) in [
        (
            "map.sensor_mm=[-7.05, -7.05, 9.0, 7.05]",
            "map.sensor_mm: expected a rectangle inside the taxels' hull, [-7.05, -7.05, 7.05, 7.05] mm: \
             its right edge lies 1.95 mm outside",
        ),
        (
            "map.window_mm=[20.0, 5.0]",
            "map.window_mm: expected a window inside the taxels' hull, 14.10 mm by 14.10 mm",
        ),
    ] {
        let refused = hil(&["run", "sphere-along", "--set", set]);
        assert_eq!(refused.status, Some(2));
        assert!(refused.err.contains(said), "{}", refused.err);
    }
    let folder = Folder::new("strip");
    let layout = folder.path("strip.toml").display().to_string();
    good(&[
        "new",
        "layout",
        "strip",
        "--rows",
        "1",
        "--columns",
        "4",
        "--out",
        &layout,
    ]);
    let refused = hil(&[
        "run",
        "sphere-along",
        "--set",
        &format!("layout={layout:?}"),
    ]);
    let said = "map.sensor_mm: expected a sensor rectangle of positive width";
    assert!(refused.err.contains(said), "{}", refused.err);
    let fault = "faults=[{ at_s = 1.0, kind = \"bus-off\", bus = 0 }]";
    let refused = hil(&["run", "sphere-streamed", "--set", fault]);
    assert_eq!(refused.status, Some(2), "{}", refused.out);
    assert!(refused.err.contains("no sensor bus"), "{}", refused.err);
}

/// A machine that sends these lines, each a moment after the one before, to the first host that connects.
fn sender(lines: Vec<String>) -> String {
    use std::io::Write;
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        for line in lines {
            // A host that has gone takes no more.
            if stream.write_all((line + "\n").as_bytes()).is_err() {
                return;
            }
            #[allow(clippy::disallowed_methods, reason = "another machine's pace")]
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
    });
    address
}

/// Half a second of rest, then a press on the middle of a 4x4 pad.
fn press() -> Vec<String> {
    let header = (1..=16).map(|t| format!("txl{t}_x,txl{t}_y,txl{t}_z"));
    let header = header.collect::<Vec<_>>().join(",");
    let row = |n: i64| {
        let taxel = |t: i64| {
            let pressed = n >= 60 && [5, 6, 9, 10].contains(&t);
            let z = 37_400 + (n * 7 + t * 3) % 5 + if pressed { 400 } else { 0 };
            format!("{},{},{z}", 32_800 + (n + t) % 3, 32_800 + (n + 2 * t) % 3)
        };
        (0..16).map(taxel).collect::<Vec<_>>().join(",")
    };
    std::iter::once(header).chain((0..160).map(row)).collect()
}

#[test]
fn readings_that_another_machine_sends_are_felt_as_they_come() {
    let address = sender(press());
    let felt = summary(&[
        "run",
        "--stream",
        &address,
        "--json",
        "--set",
        "length_s=1.3",
    ]);
    assert!(felt["frames"].as_u64().unwrap() > 30);
    assert!(felt["stimuli"].as_u64().unwrap() > 0);
    assert_eq!(felt["scene"], format!("stream of {address}"));
}

#[test]
fn a_stream_of_another_length_is_refused_with_the_arithmetic() {
    let run = |lines: Vec<String>, layout: &str| {
        let address = sender(lines);
        let said = hil(&["run", "--stream", &address, "--layout", layout]);
        assert_eq!(said.status, Some(2), "{}", said.err);
        said.err.replace(&address, "HOST")
    };
    let wrong = run(press(), "scattered-12");
    let expected = "tcp://HOST:1: ";
    let counted = "36 taxel columns (12 taxels of 3 axes in layout `scattered-12`)";
    assert!(
        wrong.contains(expected) && wrong.contains(counted),
        "{wrong}"
    );
    // A line in the middle that was cut.
    let mut lines = press();
    lines[100].truncate(100);
    let torn = run(lines, "uskin-4x4");
    assert!(
        torn.contains("tcp://HOST:101") && torn.contains("48"),
        "{torn}"
    );
    let unreached = hil(&["run", "--stream", "127.0.0.1:1"]);
    assert_eq!(unreached.status, Some(3), "{}", unreached.err);
    for address in ["host", "host:", ":80", "host:70000"] {
        refused_with(
            &["run", "--stream", address],
            &["expected HOST:PORT", address],
        );
    }
}
