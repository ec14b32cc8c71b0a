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
    let folder = Folder::new("motors-refused");
    let trace = "displacement_um,current_a\n0,0\n1,1\n2,1\n";
    fs::write(folder.path("trace.csv"), trace).unwrap();
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
        (
            &["calibrate", "lra-8"],
            "expected a bench of wires: no evidence on motors is published; `hil sweep",
        ),
        (
            &[
                "identify",
                "trace.csv",
                "--bench",
                "lra-8",
                "--rate",
                "1000",
            ],
            "expected a bench of wires: a motor's trace fits no wire; state",
        ),
        (
            &["emulate", "--bench", "voice-coil-8", "--scene", "idle"],
            "expected motors behind drivers on a bus, found voice coils on a sound card",
        ),
        (
            &["emulate", "--bench", "lra-8", "--scene", "idle", "--oe"],
            "expected no --oe: drivers of motors have no line",
        ),
        (
            &["design", "--response", "lra-8"],
            "expected a bench of wires: a motor shakes at its own frequency",
        ),
    ] {
        let said = hil_in(&folder.0, arguments);
        assert_eq!(said.status, Some(2), "{arguments:?}: {}", said.out);
        assert!(said.err.contains(words), "{arguments:?}: {}", said.err);
        assert_eq!(said.err.trim_end().lines().count(), 1, "{}", said.err);
    }
}

#[test]
fn voice_coils_play_into_a_wav_file_or_a_pipe() {
    let folder = Folder::new("wav");
    let run = [
        "run",
        "sphere-along",
        "--bench",
        "voice-coil-8",
        "--set",
        "length_s=3",
    ];
    let said = hil_in(&folder.0, &[&run[..], &["--wav", "a.wav"]].concat());
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""));
    assert!(
        said.out.contains("motors") && said.out.contains("wrote           a.wav"),
        "{}",
        said.out
    );
    let file = fs::read(folder.path("a.wav")).unwrap();
    // Eight channels of 16 bits at 48 kHz, with 0.2 s of silence after the run.
    assert_eq!(&file[..4], b"RIFF");
    let samples = 16 * 48_000 * 32 / 10;
    assert!(
        file.len() > samples && file.len() < samples + 2000,
        "{}",
        file.len()
    );
    // Again over itself, and into a pipe.
    let again = hil_in(
        &folder.0,
        &[&run[..], &["--wav", "a.wav", "--quiet"]].concat(),
    );
    assert_eq!(again.status, Some(0), "{}", again.err);
    let piped = command(&[&run[..], &["--wav", "-"]].concat(), &folder.0)
        .output()
        .unwrap();
    assert!(piped.status.success() && piped.stdout == file);
    assert!(piped.stderr.is_empty());
}

#[test]
fn a_wav_that_cannot_be_is_refused_in_a_sentence() {
    let coils = [
        "run",
        "sphere-along",
        "--bench",
        "voice-coil-8",
        "--set",
        "length_s=2",
    ];
    for (arguments, status, words) in [
        (
            &["run", "sphere-along", "--wav", "a.wav"][..],
            2,
            "--wav: expected a bench with voice coils on a sound card",
        ),
        (
            &["run", "sphere-along", "--bench", "lra-8", "--wav", "a.wav"],
            2,
            "such as `voice-coil-8`, found `lra-8`",
        ),
        (
            &[&coils[..], &["--wav", "-", "--json"]].concat(),
            2,
            "samples have standard output to themselves",
        ),
        (
            &[&coils[..], &["--wav", "/dev/full"]].concat(),
            3,
            "/dev/full: cannot be written: No space left",
        ),
        (
            &[&coils[..], &["--wav", "/nowhere/a.wav"]].concat(),
            3,
            "/nowhere/a.wav: cannot be written",
        ),
    ] {
        let said = hil(arguments);
        assert_eq!(said.status, Some(status), "{arguments:?}: {}", said.err);
        assert!(said.err.contains(words), "{arguments:?}: {}", said.err);
        assert_eq!(said.err.trim_end().lines().count(), 1, "{}", said.err);
    }
}

#[test]
fn scenes_of_motors_bring_their_benches() {
    for (scene, kind) in [
        ("coins-along", "lra"),
        ("coils-circle", "voice-coil"),
        ("back-circle", "lra"),
    ] {
        let said = hil(&["run", scene, "--json"]);
        assert_eq!(said.status, Some(0), "{scene}: {}", said.err);
        let summary: serde_json::Value = serde_json::from_str(&said.out).unwrap();
        assert_eq!(summary["motors"]["kind"], kind, "{scene}");
        assert_eq!(summary["verdict"], "ok", "{scene}");
    }
}

#[test]
fn a_new_bench_of_motors_runs_and_a_real_one_states_its_motors() {
    let folder = Folder::new("motors-new");
    let run = |arguments: &[&str]| {
        let said = hil_in(&folder.0, arguments);
        assert_eq!(said.status, Some(0), "{arguments:?}: {}", said.err);
        said.out
    };
    for (kind, display) in [
        ("lra", "thimble-8"),
        ("erm", "thimble-8"),
        ("voice-coil", "thimble-8"),
        ("lra", "tactile-brush-4x3"),
    ] {
        let new = ["new", "bench", "own", "--force", "--motors", kind];
        run(&[&new[..], &["--display", display]].concat());
        let scene = ["run", "sphere-along", "--set", "length_s=2", "--json"];
        let out = run(&[&scene[..], &["--bench", "own.toml"]].concat());
        let summary: serde_json::Value = serde_json::from_str(&out).unwrap();
        assert_eq!(summary["motors"]["kind"], kind);
    }
    let real = ["--motors", "lra", "--can", "can0", "--i2c", "/dev/i2c-1"];
    let new = ["new", "bench", "real"];
    run(&[&new[..], &real, &["--display", "tactile-brush-4x3"]].concat());
    run(&["check", "real.toml"]);
    let text = folder.text("real.toml");
    let last = "{ switch = 0x71, channel = 3 },\n]\n";
    assert!(
        text.ends_with(last) && text.contains("\nohm = 25.0\n"),
        "{text}"
    );
    for (more, words) in [
        (
            &[
                "--motors",
                "voice-coil",
                "--can",
                "can0",
                "--i2c",
                "/dev/i2c-1",
            ][..],
            "a sound card drives voice coils",
        ),
        (
            &["--motors", "lra", "--current-ma", "900"],
            "cannot be used with",
        ),
    ] {
        let said = hil_in(&folder.0, &[&["new", "bench", "other"], more].concat());
        assert_eq!(said.status, Some(2), "{}", said.err);
        assert!(said.err.contains(words), "{}", said.err);
    }
}
