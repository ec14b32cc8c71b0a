//! `hil unit` and its host as programs: deaths, and what is refused with a sentence.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, Read};
use std::net::TcpStream;
use std::process::{Command, Stdio};

use palpate_buses::datagrams::Datagrams as Socket;
use palpate_buses::pacer::RunClock;
use palpate_buses::served::wait::monotonic_ns;
use palpate_core::codec::link::MOST;
use palpate_core::units::Duration;
use serde_json::Value;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, client};

use super::subject::{Process, hil, seen, write_key};

fn pause(ms: u64) {
    let clock = RunClock::start();
    clock.sleep_until(clock.now() + Duration::from_millis(ms));
}

/// Runs the program; its exit status and what it said on standard error.
fn said(unit: &Process, arguments: &[&str]) -> (i32, String) {
    let done = hil(&unit.folder).args(arguments).output().unwrap();
    (
        done.status.code().unwrap(),
        String::from_utf8(done.stderr).unwrap(),
    )
}

/// A host that drives the unit at this address.
fn playing(unit: &Process, address: &str) -> Command {
    let mut command = hil(&unit.folder);
    command.args(["run", "sphere-along", "--quiet", "--key", "unit.key"]);
    command.args(["--unit", address]);
    command
}

#[test]
fn a_host_that_is_killed_leaves_no_output_on_for_longer_than_100_ms() {
    let mut unit = Process::alone(&[]);
    let address = unit.address.to_string();
    let mut run = playing(&unit, &address)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut told = unit.wait_for_edges(12);
    run.kill().unwrap();
    let killed_ns = monotonic_ns();
    run.wait().unwrap();
    pause(400);
    told.extend(unit.finish());
    let after = told.iter().filter(|event| event["event"] == "edge");
    let last_ns = after
        .map(|event| event["t_ns"].as_u64().unwrap())
        .max()
        .unwrap();
    let late_ms = last_ns.saturating_sub(killed_ns) as f64 / 1e6;
    assert!(late_ms <= 100.0, "{late_ms} ms");
    let seen = seen(&told);
    assert!(seen.rising.len() >= 12);
    assert_eq!(seen.high, 0, "{seen:?}");
}

#[test]
fn a_host_that_is_killed_is_a_stop_at_every_address_of_its_unit() {
    let mut unit = Process::alone(&[]);
    let address = unit.address.to_string();
    let mut run = playing(&unit, &address)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    unit.wait_for_edges(3);
    run.kill().unwrap();
    run.wait().unwrap();
    let port = unit.address.port();
    for name in [
        address.clone(),
        format!("localhost:{port}"),
        format!("[::ffff:127.0.0.1]:{port}"),
    ] {
        let on = ["--unit", &name, "--key", "unit.key"];
        let (status, text) = said(&unit, &[&["run", "idle", "--quiet"], &on[..]].concat());
        let words = "stopped earlier: the run ended without a word";
        assert!(status == 4 && text.contains(words), "{name}: {text}");
    }
    let on = ["--unit", &address, "--key", "unit.key"];
    assert_eq!(said(&unit, &[&["off", "--unlatch"], &on[..]].concat()).0, 0);
    assert_eq!(said(&unit, &[&["doctor"], &on[..]].concat()).0, 0);
}

#[test]
fn a_host_that_could_keep_no_stop_plays_nothing() {
    let unit = Process::alone(&[]);
    let run = playing(&unit, &unit.address.to_string())
        .env("PALPATE_STATE", "/proc/nope")
        .output()
        .unwrap();
    let text = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(3), "{text}");
    assert!(
        text.contains("`sudo install -d -m 1777 /proc/nope`"),
        "{text}"
    );
    assert!(seen(&unit.finish()).rising.is_empty());
}

#[test]
fn a_reader_that_stops_keeps_no_unit_from_its_turns() {
    let unit = Process::alone(&[]);
    unit.narrow();
    let run = playing(&unit, &unit.address.to_string()).output().unwrap();
    let text = String::from_utf8(run.stderr).unwrap();
    assert_eq!(run.status.code(), Some(0), "{text}");
    // Who reads on learns of all of it.
    let seen = seen(&unit.finish());
    assert!(seen.rising.len() > 100 && seen.high == 0, "{seen:?}");
}

#[test]
fn nothing_is_sealed_twice_with_one_nonce() {
    let unit = Process::alone(&[]);
    let silent = Socket::listen("127.0.0.1:0".parse().unwrap()).unwrap();
    let here = silent.here().unwrap().to_string();
    let (mut nonces, mut buffer) = (BTreeSet::new(), [0; MOST]);
    for _ in 0..2 {
        let mut run = playing(&unit, &here).stderr(Stdio::null()).spawn().unwrap();
        while run.try_wait().unwrap().is_none() {
            while let Some((length, _)) = silent.receive(&mut buffer) {
                let sealed = buffer[..length].starts_with(b"PU");
                assert!(!sealed || nonces.insert(buffer[4..28].to_vec()));
            }
            pause(1);
        }
    }
    assert!(nonces.len() > 2, "it knocked {} times", nonces.len());
}

#[test]
fn what_cannot_be_is_refused_with_a_sentence() {
    let unit = Process::alone(&[]);
    let address = unit.address.to_string();
    let run = |address: &str, key: &str| {
        said(
            &unit,
            &[
                "run",
                "sphere-along",
                "--quiet",
                "--unit",
                address,
                "--key",
                key,
            ],
        )
    };
    write_key(&unit.folder.0.join("other.key"), &[3; 32]);
    let (status, text) = run(&address, "other.key");
    assert!(status == 3 && text.contains("have the same key"), "{text}");
    let closed = Socket::listen("127.0.0.1:0".parse().unwrap())
        .unwrap()
        .here()
        .unwrap();
    let (status, text) = run(&closed.to_string(), "unit.key");
    assert!(
        status == 3 && text.contains("nothing listens there"),
        "{text}"
    );
    let (status, text) = run("no such host", "unit.key");
    assert!(status == 2 && text.contains("expected ADDRESS"), "{text}");
    let (status, text) = run(&address, "missing.key");
    assert!(status == 2 && text.contains("hil unit --new-key"), "{text}");
    let (status, text) = said(
        &unit,
        &[
            "run",
            "sphere-along",
            "--observe",
            "--unit",
            &address,
            "--key",
            "unit.key",
        ],
    );
    assert!(status == 2 && text.contains("guard of its own"), "{text}");
    // A bench whose boards count other periods than the unit's.
    let bench = "name = \"slow\"\ndescription = \"Slow boards\"\n[drive]\npwm_hz = 100.0\n";
    std::fs::write(unit.folder.0.join("slow.toml"), bench).unwrap();
    let (status, text) = said(
        &unit,
        &[
            "run",
            "sphere-along",
            "--unit",
            &address,
            "--key",
            "unit.key",
            "--illusion",
            "linear",
            "--bench",
            "slow.toml",
        ],
    );
    assert!(status == 2 && text.contains("PRE_SCALE"), "{text}");
}

#[test]
fn sixteen_boards_on_one_address_are_refused_with_a_sentence() {
    let unit = Process::alone(&[]);
    // Sixteen fingertips whose boards all have the straps of the first: on a bus they would all answer at once.
    let wires: Vec<String> = (0..8)
        .map(|channel| format!("{{ board = 0x40, channel = {channel} }}"))
        .collect();
    let finger = |n| {
        format!(
            "[[displays]]\nname = \"finger-{n}\"\noutputs = [{}]\n",
            wires.join(", ")
        )
    };
    let displays: Vec<String> = (0..16).map(finger).collect();
    let bench = format!(
        "name = \"one-address\"\ndescription = \"Sixteen boards\"\n{}",
        displays.join("\n")
    );
    std::fs::write(unit.folder.0.join("one-address.toml"), bench).unwrap();
    let (status, text) = said(
        &unit,
        &[
            "unit",
            "--key",
            "unit.key",
            "--bench",
            "one-address.toml",
            "--at",
            "127.0.0.1:0",
        ],
    );
    assert_eq!(status, 2, "{text}");
    assert!(
        text.contains("one-address.toml") && text.contains("an output of its own"),
        "{text}"
    );
}

#[test]
fn a_unit_that_answers_from_two_addresses_or_in_another_version_is_refused() {
    for version in [false, true] {
        let unit = Process::alone(&[]);
        let [front, side, back] =
            [(); 3].map(|()| Socket::listen("127.0.0.1:0".parse().unwrap()).unwrap());
        let here = front.here().unwrap().to_string();
        let mut run = playing(&unit, &here)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut host = None;
        let mut buffer = [0; MOST];
        while run.try_wait().unwrap().is_none() {
            while let Some((length, from)) = front.receive(&mut buffer) {
                host = Some(from);
                buffer[2] += u8::from(version);
                back.send(&buffer[..length], unit.address);
            }
            while let Some((length, _)) = back.receive(&mut buffer) {
                if let Some(host) = host {
                    buffer[2] += u8::from(version);
                    front.send(&buffer[..length], host);
                    side.send(&buffer[..length], host);
                }
            }
            pause(1);
        }
        let done = run.wait_with_output().unwrap();
        let text = String::from_utf8(done.stderr).unwrap();
        let wanted = match version {
            true => "same version",
            false => "name the address that it answers from",
        };
        assert_eq!(done.status.code(), Some(3), "{text}");
        assert!(text.contains(wanted), "{text}");
    }
}

#[test]
fn off_stops_a_unit_under_a_running_host_which_says_so() {
    let mut unit = Process::alone(&[]);
    let address = unit.address.to_string();
    let on = ["--key", "unit.key", "--unit", &address];
    let run = hil(&unit.folder)
        .args(["run", "sphere-along", "--quiet"])
        .args(on)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut told = unit.wait_for_edges(3);
    let off = hil(&unit.folder).arg("off").args(on).output().unwrap();
    let words = String::from_utf8(off.stdout).unwrap();
    assert!(
        off.status.success() && words.contains("everything is off; stopped: end"),
        "{words}"
    );
    let done = run.wait_with_output().unwrap();
    let text = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(4), "{text}");
    assert!(
        text.contains("stopped by its own guard, end") && text.contains("hil off --unlatch"),
        "{text}"
    );
    let again = ["run", "idle", "--quiet", on[0], on[1], on[2], on[3]];
    let (status, text) = said(&unit, &again);
    assert!(status == 4 && text.contains("stopped earlier"), "{text}");
    let cleared = ["off", "--unlatch", on[0], on[1], on[2], on[3]];
    assert_eq!(said(&unit, &cleared).0, 0);
    let (status, text) = said(&unit, &["doctor", on[0], on[1], on[2], on[3]]);
    assert_eq!((status, text.as_str()), (0, ""));
    told.extend(unit.finish());
    assert_eq!(seen(&told).high, 0);
}

#[test]
fn a_stop_in_the_page_over_a_unit_switches_off_and_stays_until_it_is_cleared() {
    let mut unit = Process::alone(&[]);
    let address = unit.address.to_string();
    let mut run = playing(&unit, &address)
        .args(["--serve", "0"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut words = BufReader::new(run.stderr.take().unwrap());
    let mut line = String::new();
    words.read_line(&mut line).unwrap();
    let host = line
        .split("http://")
        .nth(1)
        .unwrap_or_else(|| panic!("{line}"));
    let host = host.split('/').next().unwrap();
    let mut request = format!("ws://{host}/live").into_client_request().unwrap();
    let origin = format!("http://{host}").parse().unwrap();
    request.headers_mut().insert("Origin", origin);
    let (mut page, _) = client(request, TcpStream::connect(host).unwrap()).unwrap();
    let mut told = unit.wait_for_edges(6);
    page.send(Message::text(r#"{"stop":true}"#)).unwrap();
    let mut text = String::new();
    words.read_to_string(&mut text).unwrap();
    assert_eq!(run.wait().unwrap().code(), Some(4), "{text}");
    assert!(text.contains("hil off --unlatch"), "{text}");
    let on = ["--unit", &address, "--key", "unit.key"];
    let again = [&["run", "idle", "--quiet"], &on[..]].concat();
    let (status, text) = said(&unit, &again);
    assert!(status == 4 && text.contains("stopped earlier"), "{text}");
    let cleared = [&["off", "--unlatch"], &on[..]].concat();
    assert_eq!(said(&unit, &cleared).0, 0);
    assert_eq!(said(&unit, &[&["doctor"], &on[..]].concat()).0, 0);
    told.extend(unit.finish());
    assert_eq!(seen(&told).high, 0);
}

/// Three seconds of metal.
const METAL: &str = r#"
name = "metal"
description = "A sphere of metal rolls"
length_s = 4.0
generation = "2021"
threshold = "maximum"

[[touches]]
start_s = 0.8
end_s = 4.0
path = { kind = "line", points_mm = [[0.0, -7.05], [0.0, 7.05]], period_s = 4.0 }
force_n = { mean = 0.7, amplitude = 0.3, period_s = 2.7 }

[[materials]]
start_s = 1.0
end_s = 3.9
material = "metal"
"#;

#[test]
fn a_unit_with_currents_and_a_module_is_driven_over_udp() {
    let unit = Process::alone(&["--bench", "unit-whole"]);
    let address = unit.address.to_string();
    std::fs::write(unit.folder.0.join("metal.toml"), METAL).unwrap();
    let run = |bench: &str| {
        let on = ["--unit", &address, "--key", "unit.key", "--bench", bench];
        let scene = ["run", "metal.toml", "--json"];
        let mut command = hil(&unit.folder);
        command.args(scene).args(on);
        let done = command.output().unwrap();
        let text = String::from_utf8(done.stderr).unwrap();
        (done.status.code().unwrap(), done.stdout, text)
    };
    let (status, summary, text) = run("unit-whole");
    assert_eq!(status, 0, "{text}");
    let summary: Value = serde_json::from_slice(&summary).unwrap();
    let (heat, driven) = (&summary["heat"], &summary["unit"]);
    let coldest = heat["coldest_face_c"].as_f64().unwrap();
    // The same scene in virtual time, on `unit-whole` and on `warm`: 26.3 C.
    assert!((25.8..26.8).contains(&coldest), "{heat}");
    assert!(heat["turns"].as_u64().unwrap() > 100, "{heat}");
    assert_eq!(heat["stops"], 0, "{heat}");
    assert!(driven["begun"].as_u64().unwrap() > 20, "{driven}");
    assert_eq!(driven["stops"], 0, "{driven}");
    // A host whose bench sets no currents plays at the unit's full scale, and leaves its face alone.
    let (status, _, text) = run("unit");
    assert_eq!(status, 0, "{text}");
    let differs = "most current of a pulse, its tolerance included: 1217 mA on the unit, 1200 mA on this bench. The higher counts: a guard expects what heats more.";
    assert!(text.contains(differs), "{text}");
    let doctor = ["doctor", "--unit", &address, "--key", "unit.key"];
    let done = hil(&unit.folder).args(doctor).output().unwrap();
    let told = String::from_utf8(done.stdout).unwrap();
    assert!(
        told.contains("currents set up to 1200 mA, a Peltier module"),
        "{told}"
    );
    let seen = seen(&unit.finish());
    assert_eq!(seen.high, 0, "{seen:?}");
    // One without them is refused where the bench wants them.
    let plain = Process::alone(&[]);
    let address = plain.address.to_string();
    let on = ["--unit", &address, "--key", "unit.key", "--bench"];
    let refused = |bench: &str| {
        said(
            &plain,
            &[&["run", "sphere-along"], &on[..], &[bench]].concat(),
        )
    };
    let (status, text) = refused("set-current");
    assert!(
        status == 2 && text.contains("expected a unit whose currents are set"),
        "{text}"
    );
    let (status, text) = refused("warm");
    assert!(
        status == 2 && text.contains("expected a unit with a Peltier module"),
        "{text}"
    );
}
